#pragma once

// Numbers by which a node tells how accurate its result is: what a body weighs beside its mesh, how
// well a simulation's equations were solved. They are kept with the result and come to everybody
// who cooks something made from it, from the caches too. `aspic cook` writes them as the accuracy
// card.

#include <limits>
#include <string>
#include <vector>

namespace graph {

// What a figure is of all frames.
enum class Over {
    once,     // the same at all: that of the first frame
    largest,  // its largest value
    balance,  // a quantity that only errors raise: the sums of its rises and of its falls
    frames,   // 1 or 0, whether something is so: the frames at which it is
};

struct Figure {
    static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

    std::string name;        // with its unit: "volume, m^3"
    double value = unknown;  // not a number where it is not known
    // What a figure told once should be. Of a balance, the part of the value that counts from
    // nothing (runtime/commands/accuracy_card.cpp, balance()).
    double of = unknown;
    Over over = Over::once;

    // Unknown values are equal.
    bool operator==(const Figure& b) const
    {
        const auto same = [](double x, double y) { return x == y || (x != x && y != y); };
        return name == b.name && same(value, b.value) && same(of, b.of) && over == b.over;
    }
};

// A figure by this name says why there is nothing to compare with.
inline constexpr const char* overlapping_parts = "parts of the mesh overlap";

// All that a node tells of a result.
struct Figures {
    std::string kind;  // "body", "simulation"
    std::vector<Figure> all;
    bool operator==(const Figures&) const = default;
};

}  // namespace graph
