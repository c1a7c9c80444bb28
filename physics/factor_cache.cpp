#include "physics/factor_cache.hpp"

#include <algorithm>

namespace physics {

FactorCache::Factor FactorCache::find(const Key& key, const std::function<Factor()>& make)
{
    {
        const std::lock_guard lock(mutex_);
        const auto found = std::find_if(kept_.begin(), kept_.end(),
                                        [&](const auto& entry) { return entry.first == key; });
        if (found != kept_.end()) {
            kept_.splice(kept_.begin(), kept_, found);
            return found->second;
        }
    }
    // Not under the lock: making one runs on all threads, which may want this cache too.
    const Factor made = make();
    const std::lock_guard lock(mutex_);
    kept_.emplace_front(key, made);
    if (kept_.size() > most) kept_.pop_back();
    return made;
}

}  // namespace physics
