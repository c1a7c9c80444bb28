#pragma once

// Parameters: their values and their description, which the loader, the reference, the schema and
// an editor read. A node declares its own with param_builder.hpp.

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace graph {

enum class ParamKind {
    boolean,
    integer,
    number,
    vector,  // three numbers
    colour,  // three numbers in 0..1, linear RGB; documents may also say "#rrggbb" (sRGB)
    text,
    choice,    // one of `choices`
    path_in,   // a file to read; documents say it relative to themselves, a loaded graph absolute;
               // its bytes are part of the node's key
    path_out,  // a file to write, relative to the output folder
    list,      // any number of structs described by `children`
    block,     // one struct described by `children`
};

// A parameter's value for one frame. Choices are their name; blocks and lists nest.
struct ParamValue {
    std::variant<std::monostate, bool, std::int64_t, double, std::array<double, 3>, std::string,
                 std::vector<ParamValue>>
        is;

    bool operator==(const ParamValue&) const = default;
};
using ParamValues = std::vector<ParamValue>;

// What a number may be. `unit` is for people: "m", "Pa", "s", "deg".
struct Limits {
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    std::string unit = {};
};

// Show (and check) a parameter only while another of the same struct has one of these values.
struct ShownWhen {
    std::string param;
    std::vector<std::string> values;
};

struct Param {
    std::string name, doc;
    ParamKind kind = ParamKind::number;
    Limits limits;                     // integer, number; each component of vector and colour
    std::vector<std::string> choices;  // choice: in order of the enumerators
    std::vector<Param> children;       // list, block
    ShownWhen shown_when;              // empty name: always
    ParamValue fallback;               // the default

    bool numeric() const
    {
        return kind == ParamKind::integer || kind == ParamKind::number ||
               kind == ParamKind::vector || kind == ParamKind::colour;
    }
};

}  // namespace graph
