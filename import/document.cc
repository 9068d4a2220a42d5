/* SPDX-License-Identifier: MIT */
#include "document.h"

#include <algorithm>
#include <charconv>
#include <type_traits>

namespace drape {
namespace {

/* JSON as it is written: commas are put where they belong. */
class json {
  public:
    std::string text;

    void open(char bracket) {
        comma();
        text += bracket;
        first = true;
    }
    void open(const char *name, char bracket) {
        key(name);
        open(bracket);
    }
    void close(char bracket) {
        text += bracket;
        first = false;
    }
    void key(const char *name) {
        comma();
        text += '"';
        text += name;
        text += "\":";
        first = true;
    }
    /* A number, true or false, a string, or an array of such or of arrays. */
    template <class T> void value(const T &value) {
        if constexpr (std::is_same_v<T, bool>) {
            comma();
            text += value ? "true" : "false";
        } else if constexpr (std::is_integral_v<T>) {
            comma();
            text += std::to_string(value);
        } else if constexpr (std::is_floating_point_v<T>) {
            char digits[32];
            comma();
            text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
        } else if constexpr (std::is_convertible_v<T, std::string>) {
            string(value);
        } else {
            open('[');
            for (const auto &one : value)
                this->value(one);
            close(']');
        }
    }
    template <class T> void member(const char *name, const T &value) {
        key(name);
        this->value(value);
    }

  private:
    bool first = true;

    void comma() {
        if (!first)
            text += ',';
        first = false;
    }
    /* Bytes beyond ASCII are kept where they are UTF-8 and replaced where they are not. */
    void string(const std::string &value) {
        comma();
        text += '"';
        for (size_t k = 0; k < value.size(); k++) {
            unsigned char c = static_cast<unsigned char>(value[k]);
            size_t more = sequence(value, k);
            if (c == '"' || c == '\\') {
                text += '\\';
                text += char(c);
            } else if (c >= 0x80 && more) {
                text.append(value, k, more);
                k += more - 1;
            } else {
                text += c < 0x20 || c >= 0x7f ? '?' : char(c);
            }
        }
        text += '"';
    }
    /* The length of the UTF-8 sequence at `k`, 0 when there is none. */
    static size_t sequence(const std::string &value, size_t k) {
        unsigned char c = static_cast<unsigned char>(value[k]);
        size_t length = c >= 0xc2 && c < 0xe0 ? 2 : c >= 0xe1 && c < 0xed ? 3 : 0;
        for (size_t i = 1; i < length; i++)
            if (k + i >= value.size() || (static_cast<unsigned char>(value[k + i]) & 0xc0) != 0x80)
                return 0;
        return length;
    }
};

/* Of a curve or a surface. */
template <class geometry> void write_control_points(json &out, const geometry &shape) {
    out.open("control_points", '{');
    out.member("points", shape.points);
    if (!shape.weights.empty())
        out.member("weights", shape.weights);
    out.close('}');
}

void write_trim_loop(json &out, const trim_loop &loop) {
    out.open('{');
    out.member("type", "container");
    out.member("reversed", loop.outer);
    out.open("data", '[');
    for (const trim_curve &curve : loop.curves) {
        out.open('{');
        out.member("degree", curve.degree);
        out.member("knotvector", curve.knots);
        write_control_points(out, curve);
        out.close('}');
    }
    out.close(']');
    out.close('}');
}

void write_marks(json &out, const face &face) {
    out.member("kind", face.kind);
    if (!face.name.empty())
        out.member("name", face.name);
    if (!face.colour.empty())
        out.member("colour", face.colour);
}

} // namespace

std::string document_surface(const part &part) {
    static const char *const keys[2][3] = {{"degree_u", "size_u", "knotvector_u"},
                                           {"degree_v", "size_v", "knotvector_v"}};
    json out;
    out.open('{');
    out.member("length_unit", part.unit);
    out.member("tolerance", part.tolerance);
    out.member("notes", part.notes);
    out.open("faces", '[');
    for (const face &face : part.faces) {
        out.open('{');
        write_marks(out, face);
        for (int k = 0; k < 2; k++) {
            out.member(keys[k][0], face.degree[k]);
            out.member(keys[k][1], face.size[k]);
            out.member(keys[k][2], face.knots[k]);
        }
        write_control_points(out, face);
        if (!face.loops.empty()) {
            out.open("trims", '[');
            for (const trim_loop &loop : face.loops)
                write_trim_loop(out, loop);
            out.close(']');
        }
        out.close('}');
    }
    out.close(']');
    out.close('}');
    return out.text + "\n";
}

std::string document_list(const part &part) {
    json out;
    double area = 0;
    std::array<double, 3> box[2] = {part.faces[0].box[0], part.faces[0].box[1]};
    for (const face &face : part.faces) {
        area += face.area;
        for (size_t k = 0; k < 3; k++) {
            box[0][k] = std::min(box[0][k], face.box[0][k]);
            box[1][k] = std::max(box[1][k], face.box[1][k]);
        }
    }
    out.open('{');
    out.member("length_unit", part.unit);
    out.member("area", area);
    out.member("bounding_box", box);
    out.member("tolerance", part.tolerance);
    out.open("faces", '[');
    for (size_t k = 0; k < part.faces.size(); k++) {
        const face &face = part.faces[k];
        out.open('{');
        out.member("index", part.numbers[k]);
        out.member("area", face.area);
        out.member("bounding_box", face.box);
        out.member("centre", face.centre);
        out.member("normal", face.normal);
        write_marks(out, face);
        out.close('}');
    }
    out.close(']');
    out.open("edges", '{');
    out.member("shared", part.edges.shared);
    out.member("free", part.edges.free);
    out.member("faulty", part.edges.faulty);
    out.member("largest_gap", part.edges.largest_gap);
    out.close('}');
    out.member("notes", part.notes);
    out.close('}');
    return out.text + "\n";
}

} // namespace drape
