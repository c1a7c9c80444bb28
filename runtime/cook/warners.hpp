#pragma once

// Warnings of what a result is made from. They are kept with it, by the keys of the results that
// they were given with: who finds it in a cache hears them again, of the nodes that would give them
// now, whatever those are called.

#include "runtime/cook/keys.hpp"
#include "runtime/cook/observer.hpp"

#include <set>

namespace runtime {

inline bool warns(const Result& result)
{
    return !result.warnings.empty() || !result.heard.empty();
}

// What one cook knows of the nodes that warn.
class Warners {
public:
    Warners(const graph::Graph& graph, Keys& keys) : graph_(graph), keys_(keys) {}

    // Collects what a result made from others is to keep: each node's texts once, with the earliest
    // frame at which it gave them.
    class Heap {
    public:
        explicit Heap(Warners& warners) : warners_(warners) {}
        void add(const Key& key, std::uint32_t node, int frame, const Result& result);
        std::vector<Heard> take();

    private:
        struct Entry {
            std::uint32_t node;
            Heard heard;
        };
        void add(std::uint32_t node, const Heard& heard);

        Warners& warners_;
        std::vector<Entry> entries_;
    };

    // What there is to tell of a result of `node` that arrived; nothing twice.
    std::vector<Warning> news(const Key& key, std::uint32_t node, int frame, const Result& result);

private:
    // The node whose result at that frame has that key, `below` or one that it depends on; `below`
    // itself when there is none.
    std::uint32_t find(const Heard& heard, std::uint32_t below);

    const graph::Graph& graph_;
    Keys& keys_;
    std::unordered_map<Key, std::uint32_t, KeyHash> nodes_;  // by the key of a result that warns
    std::set<std::pair<std::uint32_t, std::string>> told_;
};

}  // namespace runtime
