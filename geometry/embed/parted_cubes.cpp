#include "geometry/embed/parted_cubes.hpp"

#include <algorithm>

namespace geometry {
namespace {

bool is_broken(std::span<const std::uint32_t> broken, std::uint32_t corner, std::size_t axis)
{
    return std::binary_search(broken.begin(), broken.end(), 3 * corner + std::uint32_t(axis));
}

// The parts of one cube; one part when its corners are still joined.
PartedCube parts_of(const Cubes& cubes, std::uint32_t c, std::span<const std::uint32_t> broken)
{
    const auto& corners = cubes.corners[c];
    PartedCube cube{c, {0, 1, 2, 3, 4, 5, 6, 7}, 0};
    const auto join = [&](std::size_t a, std::size_t b) {
        const std::uint8_t low = std::min(cube.part[a], cube.part[b]);
        const std::uint8_t high = std::max(cube.part[a], cube.part[b]);
        std::replace(cube.part.begin(), cube.part.end(), high, low);
    };
    for (std::size_t a = 0; a < 8; ++a) {
        for (std::size_t d = 0; d < 3; ++d) {
            const std::size_t b = a | std::size_t{1} << d;
            if (a != b && (corners[a] == corners[b] || !is_broken(broken, corners[a], d))) {
                join(a, b);
            }
        }
    }
    std::array<std::uint8_t, 8> number;
    for (std::size_t a = 0; a < 8; ++a) {
        if (cube.part[a] == a) number[a] = cube.parts++;
        cube.part[a] = number[cube.part[a]];
    }
    return cube;
}

}  // namespace

std::vector<PartedCube> find_parted(const Cubes& cubes, std::span<const std::uint32_t> broken)
{
    if (broken.empty()) return {};
    std::vector<PartedCube> out;
    std::vector<std::uint8_t> has_lost(cubes.corner_count(), 0);
    for (const std::uint32_t link : broken) {
        if (link / 3 < has_lost.size()) has_lost[link / 3] = 1;
    }
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        if (c > 0 && cubes.cell[c] == cubes.cell[c - 1]) continue;
        const auto& corners = cubes.corners[c];
        if (std::none_of(corners.begin(), corners.end(),
                         [&](auto k) { return has_lost[k] != 0; })) {
            continue;
        }
        const PartedCube cube = parts_of(cubes, c, broken);
        if (cube.parts > 1) out.push_back(cube);
    }
    return out;
}

std::vector<std::uint8_t> marked(const Cubes& cubes, std::span<const PartedCube> parted)
{
    std::vector<std::uint8_t> out(cubes.count(), 0);
    for (const PartedCube& p : parted) out[p.cube] = 1;
    return out;
}

std::vector<Vec3i> cells_of(const Cubes& cubes, std::span<const PartedCube> parted)
{
    std::vector<Vec3i> cells;
    for (const PartedCube& p : parted) cells.push_back(cubes.cell[p.cube]);
    return cells;
}

}  // namespace geometry
