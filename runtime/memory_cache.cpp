#include "runtime/memory_cache.hpp"

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
    const auto found = entries_.find(key);
    if (found == entries_.end()) return nullptr;
    found->second.worth = worth_of(*found->second.result);
    return found->second.result;
}

std::vector<SharedResult> MemoryCache::insert(const Key& key, SharedResult result)
{
    std::vector<SharedResult> gone;
    const std::size_t bytes = result->bytes + overhead;
    if (bytes > budget_) return gone;
    const auto [entry, is_new] = entries_.try_emplace(key);
    if (!is_new) {
        bytes_ -= entry->second.result->bytes + overhead;
        bytes_ += bytes;
        gone.push_back(std::exchange(entry->second.result, std::move(result)));
        return gone;
    }
    // It is no candidate yet, so what goes now is not this one.
    while (bytes_ + bytes > budget_) {
        std::pop_heap(queue_.begin(), queue_.end());
        Candidate& least = queue_.back();
        const auto found = entries_.find(least.key);
        if (found == entries_.end()) {
            queue_.pop_back();
        } else if (found->second.worth > least.worth) {
            least.worth = found->second.worth;
            std::push_heap(queue_.begin(), queue_.end());
        } else {
            aged_ = least.worth;
            bytes_ -= found->second.result->bytes + overhead;
            gone.push_back(std::move(found->second.result));
            entries_.erase(found);
            queue_.pop_back();
        }
    }
    const double worth = worth_of(*result);
    bytes_ += bytes;
    entry->second = {std::move(result), worth};
    queue_.push_back({worth, key});
    std::push_heap(queue_.begin(), queue_.end());
    return gone;
}

}  // namespace runtime
