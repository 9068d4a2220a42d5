/* SPDX-License-Identifier: MIT */
#include "document.h"

#include <algorithm>
#include <charconv>

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
    void number(double value) {
        char digits[32];
        comma();
        text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
    }
    void integer(long value) {
        comma();
        text += std::to_string(value);
    }
    void truth(bool value) {
        comma();
        text += value ? "true" : "false";
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
    template <class Range> void numbers(const Range &range) {
        open('[');
        for (double value : range)
            number(value);
        close(']');
    }

  private:
    bool first = true;

    void comma() {
        if (!first)
            text += ',';
        first = false;
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

void write_curve(json &out, const trim_curve &curve) {
    out.open('{');
    out.key("degree");
    out.integer(curve.degree);
    out.key("knotvector");
    out.numbers(curve.knots);
    out.key("control_points");
    out.open('{');
    out.key("points");
    out.open('[');
    for (const std::array<double, 2> &point : curve.points)
        out.numbers(point);
    out.close(']');
    if (!curve.weights.empty()) {
        out.key("weights");
        out.numbers(curve.weights);
    }
    out.close('}');
    out.close('}');
}

void write_loops(json &out, const std::vector<trim_loop> &loops) {
    out.key("trims");
    out.open('[');
    for (const trim_loop &loop : loops) {
        out.open('{');
        out.key("type");
        out.string("container");
        out.key("reversed");
        out.truth(loop.outer);
        out.key("data");
        out.open('[');
        for (const trim_curve &curve : loop.curves)
            write_curve(out, curve);
        out.close(']');
        out.close('}');
    }
    out.close(']');
}

void write_marks(json &out, const face &face) {
    out.key("kind");
    out.string(face.kind);
    if (!face.name.empty()) {
        out.key("name");
        out.string(face.name);
    }
    if (!face.colour.empty()) {
        out.key("colour");
        out.string(face.colour);
    }
}

void write_face(json &out, const face &face) {
    static const char *const keys[2][3] = {{"degree_u", "size_u", "knotvector_u"},
                                           {"degree_v", "size_v", "knotvector_v"}};
    out.open('{');
    write_marks(out, face);
    for (int k = 0; k < 2; k++) {
        out.key(keys[k][0]);
        out.integer(face.degree[k]);
        out.key(keys[k][1]);
        out.integer(face.size[k]);
        out.key(keys[k][2]);
        out.numbers(face.knots[k]);
    }
    out.key("control_points");
    out.open('{');
    out.key("points");
    out.open('[');
    for (const std::array<double, 3> &point : face.points)
        out.numbers(point);
    out.close(']');
    if (!face.weights.empty()) {
        out.key("weights");
        out.numbers(face.weights);
    }
    out.close('}');
    if (!face.loops.empty())
        write_loops(out, face.loops);
    out.close('}');
}

void write_notes(json &out, const part &part) {
    out.key("notes");
    out.open('[');
    for (const std::string &note : part.notes)
        out.string(note);
    out.close(']');
}

void write_box(json &out, const double low[3], const double high[3]) {
    out.key("bounding_box");
    out.open('[');
    out.numbers(std::vector<double>(low, low + 3));
    out.numbers(std::vector<double>(high, high + 3));
    out.close(']');
}

void write_totals(json &out, const part &part) {
    double area = 0, low[3], high[3];
    for (int k = 0; k < 3; k++) {
        low[k] = part.faces[0].low[k];
        high[k] = part.faces[0].high[k];
    }
    for (const face &face : part.faces) {
        area += face.area;
        for (int k = 0; k < 3; k++) {
            low[k] = std::min(low[k], face.low[k]);
            high[k] = std::max(high[k], face.high[k]);
        }
    }
    out.key("length_unit");
    out.string(part.unit);
    out.key("area");
    out.number(area);
    write_box(out, low, high);
}

void write_edges(json &out, const part &part) {
    out.key("edges");
    out.open('{');
    out.key("shared");
    out.integer(part.edges.shared);
    out.key("free");
    out.integer(part.edges.free);
    out.key("faulty");
    out.integer(part.edges.faulty);
    out.key("largest_gap");
    out.number(part.edges.largest_gap);
    out.close('}');
}

} // namespace

std::string document_surface(const part &part) {
    json out;
    out.open('{');
    out.key("length_unit");
    out.string(part.unit);
    out.key("tolerance");
    out.number(part.tolerance);
    write_notes(out, part);
    out.key("faces");
    out.open('[');
    for (const face &face : part.faces)
        write_face(out, face);
    out.close(']');
    out.close('}');
    return out.text + "\n";
}

std::string document_list(const part &part) {
    json out;
    out.open('{');
    write_totals(out, part);
    out.key("tolerance");
    out.number(part.tolerance);
    out.key("faces");
    out.open('[');
    for (size_t k = 0; k < part.faces.size(); k++) {
        const face &face = part.faces[k];
        out.open('{');
        out.key("index");
        out.integer(part.numbers[k]);
        out.key("area");
        out.number(face.area);
        write_box(out, face.low, face.high);
        out.key("centre");
        out.numbers(std::vector<double>(face.centre, face.centre + 3));
        out.key("normal");
        out.numbers(std::vector<double>(face.normal, face.normal + 3));
        write_marks(out, face);
        out.close('}');
    }
    out.close(']');
    write_edges(out, part);
    write_notes(out, part);
    out.close('}');
    return out.text + "\n";
}

} // namespace drape
