#include "physics/lattice/tear_links.hpp"

#include "physics/lattice/torn_regions.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace physics {

bool tear_links(FrameState& step)
{
    const Lattice& lattice = step.body.torn->lattice();
    const double longest_sq = std::pow((1 + step.options.tear) * step.body.base.h, 2);
    std::vector<std::uint32_t> fresh;
    for (std::uint32_t i = 0; i < step.n; ++i) {
        for (std::uint32_t d = 0; d < 3; ++d) {
            const std::uint32_t j = lattice.next[i][d], link = 3 * i + d;
            if (j == none || (step.state.x[i] - step.state.x[j]).squaredNorm() <= longest_sq)
                continue;
            if (!std::binary_search(step.state.broken.begin(), step.state.broken.end(), link)) {
                fresh.push_back(link);
            }
        }
    }
    if (fresh.empty()) return false;
    std::vector<std::uint32_t> all;
    std::merge(step.state.broken.begin(), step.state.broken.end(), fresh.begin(), fresh.end(),
               std::back_inserter(all));
    step.state.broken = std::move(all);
    return true;
}

}  // namespace physics
