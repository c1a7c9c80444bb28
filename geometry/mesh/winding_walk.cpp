#include "geometry/mesh/winding_walk.hpp"

#include <cmath>

namespace geometry {

bool WindingWalk::inside(const Vec3& p)
{
    // Off a whole number: on a face, or so near to one that rounding speaks.
    constexpr double off = 0.02, most = 1000;
    if (winding_ && (p - last_).squaredNorm() < far_ * far_) {
        if (const auto gained = tree_.crossings(last_, p)) {
            winding_ = *winding_ + *gained;
            last_ = p;
            return *winding_ != 0;
        }
    }
    const double w = tree_.winding_number(p), whole = std::round(w);
    winding_.reset();
    if (std::abs(w - whole) < off && std::abs(whole) < most) winding_ = static_cast<int>(whole);
    last_ = p;
    return std::abs(w) > 0.5;
}

}  // namespace geometry
