#include "runtime/cache/memory_cache.hpp"

namespace runtime {

namespace {

// What an entry takes beside its values: nodes of the two containers and the shared block.
constexpr std::size_t overhead = 256;

}  // namespace

double MemoryCache::worth_of(const Result& result) const
{
    return aged_ + (result.seconds + 1e-7) / static_cast<double>(result.bytes + overhead);
}

SharedResult MemoryCache::find(const Key& key)
{
    const std::uint32_t place = place_of(key);
    if (place == KeyTable::none) return nullptr;
    Entry& entry = entries_[place];
    entry.worth = worth_of(*entry.result);
    return entry.result;
}

// The entry with the least worth. There must be one.
SharedResult MemoryCache::evict()
{
    for (;;) {
        std::pop_heap(queue_.begin(), queue_.end());
        Candidate& least = queue_.back();
        Entry& entry = entries_[least.place];
        if (entry.worth > least.worth) {
            least.worth = entry.worth;
            std::push_heap(queue_.begin(), queue_.end());
            continue;
        }
        aged_ = least.worth;
        bytes_ -= entry.result->bytes + overhead;
        table_.erase(entry.key, least.place);
        free_.push_back(least.place);
        queue_.pop_back();
        return std::move(entry.result);
    }
}

std::vector<SharedResult> MemoryCache::insert(const Key& key, SharedResult result)
{
    std::vector<SharedResult> gone;
    const std::size_t bytes = result->bytes + overhead;
    if (bytes > budget_) return gone;
    if (const std::uint32_t place = place_of(key); place != KeyTable::none) {
        Entry& entry = entries_[place];
        bytes_ -= entry.result->bytes + overhead;
        bytes_ += bytes;
        gone.push_back(std::exchange(entry.result, std::move(result)));
        return gone;
    }
    while (bytes_ + bytes > budget_) gone.push_back(evict());
    if (free_.empty()) {
        free_.push_back(static_cast<std::uint32_t>(entries_.size()));
        entries_.emplace_back();
    }
    const std::uint32_t place = free_.back();
    free_.pop_back();
    const double worth = worth_of(*result);
    bytes_ += bytes;
    entries_[place] = {key, std::move(result), worth};
    table_.insert(key, place);
    queue_.push_back({worth, place});
    std::push_heap(queue_.begin(), queue_.end());
    return gone;
}

}  // namespace runtime
