#pragma once

// What a run of each node takes, from what earlier runs took: the records of the disk cache know it
// of each result that was worth storing.

#include "graph/document/graph.hpp"
#include "runtime/cache/disk_cache.hpp"
#include "runtime/cook/keys.hpp"

#include <map>
#include <string>
#include <vector>

namespace runtime {

// A disk cache, and which results it held when the planning began: to ask a server for each of a
// million results would take minutes.
struct Stored {
    DiskCache* disk = nullptr;  // null: nothing is stored
    std::unordered_set<Key, KeyHash> keys;

    explicit Stored(DiskCache* cache) : disk(cache)
    {
        if (disk) keys = disk->all_held();
    }
    bool holds(const Key& key) const { return keys.contains(key); }
};

struct NodeCosts {
    std::vector<double> seconds;  // a run, by node
    bool measured = false;        // something of what differs from frame to frame is known
};

// Seconds by name of a node or by type of node.
using SecondsOf = std::map<std::string, double, std::less<>>;

// Looks at some of `frames`. Where the cache knows nothing of a node, `before` does (by name, from
// an earlier cook), then `usual` (by type), which takes up what is found. Nodes of which nothing is
// known count as free: they are too quick to be stored. But a simulation counts as 1 s where
// neither an earlier cook nor a stored result of a simulation, or of what depends on one, tells
// that this graph was cooked: a clock or a mesh may be another graph's too. An earlier cook that
// found one of `targets` in the cache tells nothing of what that takes.
NodeCosts node_costs(const graph::Graph& graph, Keys& keys,
                     const std::vector<std::uint32_t>& targets, const std::vector<int>& frames,
                     const Stored& stored, const SecondsOf& before, SecondsOf& usual);

}  // namespace runtime
