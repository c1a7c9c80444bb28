#pragma once

// What regions see of how their matter is spread where particles are pinned, and weigh more: kept
// for the pins that were asked for last, as most stay from frame to frame. What is kept changes how
// long a step takes, never what it gives.

#include "physics/lattice/matched_regions.hpp"

#include <memory>
#include <mutex>

namespace physics {

template <class Values> class KeptForPins {
public:
    using Found = std::shared_ptr<const Values>;

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

using PinnedVolume = KeptForPins<std::vector<RegionVolume<float>>>;
using PinnedSpread = KeptForPins<std::vector<float>>;

struct PinnedShapes {
    PinnedVolume volume;  // of a solid that keeps its volume
    PinnedSpread spread;  // B^-1, where rest shapes flow
};

}  // namespace physics
