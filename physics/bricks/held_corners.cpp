#include "physics/bricks/held_corners.hpp"

#include "physics/state/hold_matter.hpp"

#include <algorithm>

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
    out.matter = pins.matter.cubes;
    std::stable_sort(out.matter.begin(), out.matter.end(),
                     [](const HeldCube& a, const HeldCube& b) { return a.cube < b.cube; });
    return out;
}

std::vector<std::uint8_t> axes_of_parts(const Pins& pins, const CornerBody& body)
{
    std::vector<std::uint8_t> out(std::max<std::size_t>(body.parts, 1), 0);
    for (std::size_t i = 0; i < pins.corner.size(); ++i) {
        out[body.part_of(body.slot_of(pins.corner[i]))] |= held_axes(pins, i);
    }
    for (const HeldCube& cube : pins.matter.cubes) {
        const std::uint32_t corner = pins.matter.corner[cube.corner[0]];
        auto& axes = out[body.part_of(body.slot_of(corner))];
        axes = static_cast<std::uint8_t>(axes | cube.axes);
    }
    return out;
}

void add_held(const HeldCube& cube, double weight, BrickMatrix& matrix)
{
    for (std::size_t a = 0; a < 8; ++a) {
        for (std::size_t b = 0; b < 8; ++b) {
            for (std::size_t i = 0; i < 3; ++i) {
                if ((cube.axes >> i & 1) == 0) continue;
                matrix(static_cast<Eigen::Index>(3 * a + i),
                       static_cast<Eigen::Index>(3 * b + i)) += weight * stiffness_at(cube, a, b);
            }
        }
    }
}

std::vector<std::uint8_t> axes_by_corner(const HeldCorners& held, std::size_t corners)
{
    std::vector<std::uint8_t> out(corners, 0);
    for (const auto k : held.whole) out[k] = all_axes;
    for (const auto& [k, axes] : held.along) out[k] = axes;
    return out;
}

}  // namespace physics
