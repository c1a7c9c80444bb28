#pragma once

// What the volume of regions is measured by where particles are pinned, and weigh more: kept for
// the pins that were asked for last, as most stay from frame to frame. What is kept changes how
// long a step takes, never what it gives.

#include "physics/lattice/matched_regions.hpp"

#include <memory>
#include <mutex>

namespace physics {

class PinnedVolume {
public:
    using Found = std::shared_ptr<const std::vector<RegionVolume<float>>>;

    // Null where other pins were kept last.
    Found find(const std::vector<std::uint32_t>& pinned)
    {
        const std::lock_guard lock(mutex_);
        return pinned == pinned_ ? found_ : nullptr;
    }
    void keep(const std::vector<std::uint32_t>& pinned, Found found)
    {
        const std::lock_guard lock(mutex_);
        pinned_ = pinned;
        found_ = std::move(found);
    }

private:
    std::mutex mutex_;
    std::vector<std::uint32_t> pinned_;
    Found found_;
};

}  // namespace physics
