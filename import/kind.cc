/* SPDX-License-Identifier: MIT */
#include "kind.h"

#include <cstdint>
#include <cstring>
#include <string_view>

namespace drape {
namespace {

/* Kinds of files that are taken for CAD files, by how they begin. */
const struct kind {
    std::string_view begin;
    const char *what, *remedy;
} kinds[] = {
    {std::string_view("PK\3\4", 4), "a zip archive", "unpack it"},
    {"\x1f\x8b", "compressed by gzip", "decompress it"},
    {"\x28\xb5\x2f\xfd", "compressed by zstd", "decompress it"},
    {"\xd0\xcf\x11\xe0", "a CAD system's own document", "export it as STEP"},
    {"\xff\xfe", "text in UTF-16", "save it as ASCII or UTF-8"},
    {"\xfe\xff", "text in UTF-16", "save it as ASCII or UTF-8"},
    {"%PDF", "a PDF", "export the model itself"},
    {"<", "XML or a web page", "download or export the model itself"},
    {"{", "JSON", "send a surface in JSON as application/json"},
    {"**ABCDEFG", "a Parasolid file", "export it as STEP"},
    {"DBRep_DrawableShape", "a BREP file", "export it as STEP"},
    {"CASCADE Topology", "a BREP file", "export it as STEP"},
    {"solid", "an STL mesh", "draped and drape read it as stl"},
};

/* The head of a binary STL is 80 bytes of anything; FreeCAD's has an S in column 73. */
bool is_binary_stl(const char *bytes, size_t length) {
    enum { HEAD = 80, TRIANGLE = 50 };
    uint32_t count;
    if (length < HEAD + sizeof count)
        return false;
    std::memcpy(&count, bytes + HEAD, sizeof count);
    return HEAD + sizeof count + std::size_t{count} * TRIANGLE == length;
}

const kind *find_foreign(const char *bytes, size_t length) {
    const std::string_view text(bytes, length);
    static const kind stl = {"", "an STL mesh", "draped and drape read it as stl"};
    for (const kind &one : kinds)
        if (text.substr(0, one.begin.size()) == one.begin)
            return &one;
    return is_binary_stl(bytes, length) ? &stl : nullptr;
}

} // namespace

bool kind_is_step(const char *bytes, size_t length) {
    enum { HEAD = 4096 };
    return std::string_view(bytes, length).substr(0, HEAD).find("ISO-10303-21") !=
           std::string_view::npos;
}

/* The first line is of the start section (S), or says that the file is binary (B) or compressed
 * (C); its number is in columns 74 to 80, and nothing behind. */
bool kind_is_iges(const char *bytes, size_t length) {
    const std::string_view text(bytes, length);
    return length > 80 && bytes[72] != '\0' && std::strchr("SBC", bytes[72]) &&
           text.substr(73, 7).find_first_not_of(" 0123456789") == std::string_view::npos;
}

const char *kind_of_faceless(const char *bytes, size_t length) {
    static const struct {
        std::string_view word;
        const char *told;
    } holdings[] = {
        {"TRIANGULATED_FACE(", ": it is tessellated and has only triangles, not the exact "
                               "surfaces; export the exact faces, or the triangles as STL"},
        {"ELEMENT_REPRESENTATION(",
         ": it is a model of finite elements; export its shell elements as "
         "Nastran bulk data"},
    };
    for (const auto &[word, told] : holdings)
        if (std::string_view(bytes, length).find(word) != std::string_view::npos)
            return told;
    return "";
}

bool kind_is_foreign(const char *bytes, size_t length) {
    return find_foreign(bytes, length) != nullptr;
}

std::string kind_refusal(const char *wanted, const char *bytes, size_t length) {
    const kind *other = find_foreign(bytes, length);
    bool step = std::strcmp(wanted, "STEP") == 0;
    std::string text = std::string("this is not ") + (step ? "a STEP" : "an IGES") + " file: ";
    if (length == 0)
        return text + "it is empty";
    if (other)
        return text + "it is " + other->what + "; " + other->remedy;
    if (step && kind_is_iges(bytes, length))
        return text + "it is an IGES file; give its format as iges";
    if (!step && kind_is_step(bytes, length))
        return text + "it is a STEP file; give its format as step";
    return text +
           (step ? "it does not begin with ISO-10303-21" : "its first line has no S in column 73");
}

} // namespace drape
