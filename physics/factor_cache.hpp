#pragma once

#include "physics/corner_factor.hpp"

#include <functional>
#include <list>
#include <memory>
#include <mutex>

namespace physics {

// The last few factorisations of a body. Each is a function of the body and its key alone, so what
// the cache holds changes how long a step takes, never what it gives.
class FactorCache {
public:
    struct Key {
        double stiffness = 0, damping = 0;
        std::vector<double> mass;         // K
        std::vector<std::uint32_t> held;  // sorted
        bool operator==(const Key&) const = default;
    };
    using Factor = std::shared_ptr<const CornerFactor>;  // null: there is none worth having

    // What is kept for `key`, or else make(), kept from now on.
    Factor find(const Key& key, const std::function<Factor()>& make);

private:
    static constexpr std::size_t most = 3;
    std::mutex mutex_;
    std::list<std::pair<Key, Factor>> kept_;  // newest first
};

}  // namespace physics
