#pragma once

// Keeps the last few preparations of a body's preconditioner (factorisations, coarse grids), so
// that frames with the same step length, masses and pins do not prepare anew.

#include "physics/bricks/corner_factor.hpp"
#include "physics/bricks/held_corners.hpp"
#include "physics/bricks/multigrid.hpp"

#include <algorithm>
#include <list>
#include <memory>
#include <mutex>

namespace physics {

// What a preparation is made for.
struct FactorKey {
    double stiffness = 0, damping = 0;
    std::vector<double> mass;  // K
    HeldCorners held;
    bool operator==(const FactorKey&) const = default;
};

// Each preparation is a function of the body and its key alone, so what the cache holds changes how
// long a step takes, never what it gives.
template <class T> class PreparedCache {
public:
    using Key = FactorKey;
    using Factor = std::shared_ptr<const T>;  // null: there is none worth having

    // What is kept for `key`, or else make(), kept from now on.
    template <class Make> Factor find(const Key& key, const Make& make)
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

private:
    static constexpr std::size_t most = 3;
    std::mutex mutex_;
    std::list<std::pair<Key, Factor>> kept_;  // newest first
};

class FactorCache : public PreparedCache<CornerFactor> {};
class MultigridCache : public PreparedCache<Multigrid> {};
class DissectionCache : public PreparedCache<Dissection> {};

}  // namespace physics
