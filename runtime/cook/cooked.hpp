#pragma once

// What a cook reports at its end: counts and seconds of each node.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace runtime {

// How often a node ran and what that took, in one cook; preparations included.
struct Tally {
    std::size_t runs = 0, hits = 0, loads = 0, failures = 0, blocked = 0;
    std::size_t equal = 0;      // results taken over because all inputs came out as before
    std::size_t rechecked = 0;  // of the hits and loads: made again and compared
    double seconds = 0;
    std::size_t bytes = 0;  // of all results that it made

    std::size_t found() const { return hits + loads + equal; }
};

// Of all nodes of a graph; those that had nothing to do take no room.
class Tallies {
public:
    Tallies() = default;
    explicit Tallies(std::size_t nodes) : places_(nodes, 0) {}

    Tally& of(std::uint32_t node)
    {
        std::uint32_t& place = places_[node];
        if (place == 0) {
            all_.emplace_back();
            place = static_cast<std::uint32_t>(all_.size());
        }
        return all_[place - 1];
    }
    const Tally& operator[](std::size_t node) const
    {
        static const Tally nothing;
        return places_[node] == 0 ? nothing : all_[places_[node] - 1];
    }
    // Of the nodes that had something to do.
    auto begin() const { return all_.begin(); }
    auto end() const { return all_.end(); }

private:
    std::vector<std::uint32_t> places_;  // into all_, from 1
    std::deque<Tally> all_;
};

struct Cooked {
    std::size_t done = 0;  // wants that arrived
    std::size_t failures = 0, blocked = 0;
    bool cancelled = false;
    Tallies tallies;
    double seconds = 0;
};

// What runs of a type of node take, as far as this process knows; 0 when not known yet.
struct Usual {
    double mean = 0;     // s, of the last few
    double longest = 0;  // s, of the last, those before them counting for less
};

}  // namespace runtime
