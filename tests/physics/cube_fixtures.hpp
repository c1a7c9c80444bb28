#pragma once

// Cubes for tests: solid boxes, beams, and random blobs.

#include "geometry/base/random.hpp"
#include "geometry/cubes/cubes.hpp"

#include <algorithm>
#include <functional>
#include <map>

namespace fixtures {

using geometry::Cubes;
using geometry::Vec3;
using geometry::Vec3i;

struct Stuff {
    double density = 1000, young = 1e6, poisson = 0.3, mass_damping = 0, stiffness_damping = 0;
};

// Cubes of edge h on the given cells, all full, numbered as geometry::Cubes asks.
inline Cubes cubes_on(std::vector<Vec3i> cells, double h, const Stuff& stuff = {})
{
    const auto before = [](const Vec3i& a, const Vec3i& b) {
        return std::tuple(a.z(), a.y(), a.x()) < std::tuple(b.z(), b.y(), b.x());
    };
    std::sort(cells.begin(), cells.end(), before);
    Cubes out;
    out.size = h;
    std::map<Vec3i, std::uint32_t, decltype(before)> corner(before);
    const auto at = [](const Vec3i& cell, unsigned a) {
        return Vec3i(cell + Vec3i(int(a & 1), int(a >> 1 & 1), int(a >> 2 & 1)));
    };
    for (const Vec3i& cell : cells) {
        for (unsigned a = 0; a < 8; ++a) corner.emplace(at(cell, a), 0u);
    }
    for (auto& [place, index] : corner) {
        index = static_cast<std::uint32_t>(out.corner.size());
        out.corner.push_back(place);
    }
    for (const Vec3i& cell : cells) {
        out.cell.push_back(cell);
        std::array<std::uint32_t, 8> eight;
        for (unsigned a = 0; a < 8; ++a) eight[a] = corner.at(at(cell, a));
        out.corners.push_back(eight);
    }
    const std::size_t n = cells.size();
    out.mass.assign(n, stuff.density * h * h * h);
    out.fill.assign(n, 1);
    out.young.assign(n, stuff.young);
    out.poisson.assign(n, stuff.poisson);
    out.mass_damping.assign(n, stuff.mass_damping);
    out.stiffness_damping.assign(n, stuff.stiffness_damping);
    out.matter.assign(n, 0);
    out.matters = {{"stuff", stuff.density, stuff.young, stuff.poisson, stuff.mass_damping,
                    stuff.stiffness_damping}};
    return out;
}

// nx x ny x nz cubes from the origin.
inline Cubes box(int nx, int ny, int nz, double h, const Stuff& stuff = {})
{
    std::vector<Vec3i> cells;
    for (int z = 0; z < nz; ++z)
        for (int y = 0; y < ny; ++y)
            for (int x = 0; x < nx; ++x) cells.emplace_back(x, y, z);
    return cubes_on(cells, h, stuff);
}

// About `count` cubes of a random walk: holes, branches, cubes that meet at an edge or corner only.
inline Cubes blob(std::uint64_t seed, int count, double h, const Stuff& stuff = {})
{
    const geometry::Random random(seed);
    std::vector<Vec3i> cells{Vec3i::Zero()};
    for (int i = 0; i < count; ++i) {
        const auto from = random.bits(std::uint64_t(2 * i)) % cells.size();
        const auto way = random.bits(std::uint64_t(2 * i + 1));
        Vec3i step = Vec3i::Zero();
        step[int(way % 3)] = way / 3 % 2 ? 1 : -1;
        if (way / 6 % 4 == 0) step[int((way % 3 + 1) % 3)] = way / 24 % 2 ? 1 : -1;
        const Vec3i next = cells[from] + step;
        if (std::find(cells.begin(), cells.end(), next) == cells.end()) cells.push_back(next);
    }
    return cubes_on(cells, h, stuff);
}

// The corners that `choose` says, in order.
inline std::vector<std::uint32_t> corners_where(const Cubes& cubes,
                                                const std::function<bool(const Vec3i&)>& choose)
{
    std::vector<std::uint32_t> out;
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        if (choose(cubes.corner[k])) out.push_back(k);
    }
    return out;
}

// Those at the low end along x.
inline std::vector<std::uint32_t> first_layer(const Cubes& cubes)
{
    return corners_where(cubes, [](const Vec3i& corner) { return corner.x() == 0; });
}

}  // namespace fixtures
