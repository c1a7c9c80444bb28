#pragma once

// Results kept in memory under a budget of bytes.
//   Cao, Irani. Cost-aware WWW proxy caching algorithms. USENIX Symposium on Internet Technologies
//   and Systems 1997 (GreedyDual-Size).
//     H = L + seconds / bytes      the entry with the least H goes, and L becomes that H
// so what is cheap to make again for the room it takes goes first, and what nobody asked for in a
// while follows, however dear it was.

#include "runtime/content_names.hpp"
#include "runtime/key_table.hpp"

#include <filesystem>

namespace runtime {

// A file that a sink wrote, and what was in it then.
struct Written {
    std::filesystem::path path;
    Key digest;  // zero of a file that other frames write to, too
};

// A warning that came with a result that this one is made from.
struct Heard {
    Key from;  // that result's
    int frame = 0;
    std::string text;
    bool operator==(const Heard&) const = default;
};

// What running a node, or one of its preparations, gave.
struct Made {
    std::vector<graph::Value> values;      // a node's, one an output port
    std::shared_ptr<const void> prepared;  // a preparation's
    std::vector<std::string> warnings;     // its own
    std::vector<Heard> heard;              // earliest first
    std::vector<Written> files;            // a sink's
    double seconds = 0;                    // it took
    double since_stored = 0;  // s of a simulation since its last frame on disk, this included
    std::size_t bytes = 0;    // it holds
};

struct Result : Made {
    Result() = default;
    Result(const Result& other) : Made(other) {}

    // Names of the values, made when first asked for. Safe from many threads.
    const std::vector<graph::ContentName>& names(ContentNames& all) const
    {
        std::call_once(named_, [&] {
            for (const graph::Value& value : values) names_.push_back(all.of(value));
        });
        return names_;
    }
    void know_names(std::vector<graph::ContentName> names)
    {
        std::call_once(named_, [&] { names_ = std::move(names); });
    }

private:
    mutable std::once_flag named_;
    mutable std::vector<graph::ContentName> names_;
};
using SharedResult = std::shared_ptr<const Result>;

// Not safe for several threads at once: its owner guards it.
class MemoryCache {
public:
    explicit MemoryCache(std::size_t budget) : budget_(budget) {}

    SharedResult find(const Key& key);
    bool holds(const Key& key) const { return place_of(key) != KeyTable::none; }

    // What had to go is returned, so that the caller can let it die outside of any lock.
    [[nodiscard]] std::vector<SharedResult> insert(const Key& key, SharedResult result);

    // The key will be inserted soon.
    void expect(const Key& key) const { table_.expect(key); }

    std::size_t bytes() const { return bytes_; }
    std::size_t count() const { return table_.size(); }
    std::size_t budget() const { return budget_; }

private:
    struct Entry {
        Key key;
        SharedResult result;  // null where the place is free
        double worth = 0;     // H
    };
    struct Candidate {
        double worth;  // the entry's H when it was queued: it may have risen since
        std::uint32_t place;
        bool operator<(const Candidate& other) const { return worth > other.worth; }
    };
    double worth_of(const Result& result) const;
    std::uint32_t place_of(const Key& key) const
    {
        return table_.find(key, [this](std::uint32_t place) { return entries_[place].key; });
    }
    SharedResult evict();

    std::size_t budget_, bytes_ = 0;
    double aged_ = 0;  // L
    std::vector<Entry> entries_;
    std::vector<std::uint32_t> free_;  // places
    KeyTable table_;                   // into entries_
    std::vector<Candidate> queue_;     // a heap, least worth on top; one candidate an entry
};

}  // namespace runtime
