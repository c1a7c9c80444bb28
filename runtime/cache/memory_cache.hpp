#pragma once

// Results kept in memory under a budget of bytes.
//   Cao, Irani. Cost-aware WWW proxy caching algorithms. USENIX Symposium on Internet Technologies
//   and Systems 1997 (GreedyDual-Size).
//     H = L + seconds / bytes      the entry with the least H goes, and L becomes that H
// so what is cheap to make again for the room it takes goes first, and what nobody asked for in a
// while follows, however dear it was.

#include "runtime/cache/key_table.hpp"
#include "runtime/cache/result.hpp"

namespace runtime {

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
