#include "physics/bricks/held_corners.hpp"

namespace physics {

HeldCorners held_by(const Pins& pins)
{
    HeldCorners out;
    for (std::size_t p = 0; p < pins.corner.size(); ++p) {
        const std::uint8_t axes = held_axes(pins, p);
        if (axes == all_axes) {
            out.whole.push_back(pins.corner[p]);
        } else {
            out.along.emplace_back(pins.corner[p], axes);
        }
    }
    return out;
}

std::vector<std::uint8_t> axes_by_corner(const HeldCorners& held, std::size_t corners)
{
    std::vector<std::uint8_t> out(corners, 0);
    for (const auto k : held.whole) out[k] = all_axes;
    for (const auto& [k, axes] : held.along) out[k] = axes;
    return out;
}

}  // namespace physics
