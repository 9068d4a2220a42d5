/* SPDX-License-Identifier: MIT */
#include "import.h"

#include "cad.h"
#include "document.h"
#include <cstdio>
#include <cstdlib>
#include <cstring>

using namespace drape;

static bool say_why(import_answer *answer, const char *why) {
    std::snprintf(answer->why, sizeof answer->why, "%s", why);
    return false;
}

bool import_cad(const import_order *order, import_answer *answer) {
    *answer = {};
    try {
        selection wanted = {
            order->unit, {order->faces, order->faces + order->face_count}, order->list, {}};
        bool step = std::strcmp(order->format, "step") == 0;
        part part = cad_read(step ? cad_format::step : cad_format::iges, order->bytes,
                             order->length, wanted);
        std::string text = order->list ? document_list(part) : document_surface(part);
        answer->text = static_cast<char *>(std::malloc(text.size() + 1));
        if (!answer->text)
            throw std::bad_alloc();
        std::memcpy(answer->text, text.c_str(), text.size() + 1);
        answer->length = text.size();
        return true;
    } catch (const unreadable &why) {
        return say_why(answer, why.what());
    } catch (const std::bad_alloc &) {
        return say_why(answer, "the file needs more memory than allowed");
    } catch (...) {
        return say_why(answer, "the reader crashed on this file");
    }
}
