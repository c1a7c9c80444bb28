#pragma once

// Cubes for tests, made from a list of cells.

#include "geometry/cubes.hpp"

#include <map>
#include <tuple>

namespace test {

struct CubeMatter {
    double density = 1000, young = 1e6, poisson = 0.3;
};

// One cube a cell, full, corners shared wherever they coincide.
inline geometry::Cubes some_cubes(std::vector<geometry::Vec3i> cells, double size,
                                  const CubeMatter& matter = {})
{
    const auto before = [](const geometry::Vec3i& a, const geometry::Vec3i& b) {
        return std::tuple(a[2], a[1], a[0]) < std::tuple(b[2], b[1], b[0]);
    };
    std::sort(cells.begin(), cells.end(), before);
    std::map<geometry::Vec3i, std::uint32_t, decltype(before)> number(before);
    const auto offset = [](unsigned a) {
        return geometry::Vec3i(int(a & 1), int(a >> 1 & 1), int(a >> 2 & 1));
    };
    for (const auto& cell : cells) {
        for (unsigned a = 0; a < 8; ++a) number[cell + offset(a)] = 0;
    }
    geometry::Cubes cubes;
    cubes.size = size;
    for (auto& [corner, i] : number) {
        i = std::uint32_t(cubes.corner.size());
        cubes.corner.push_back(corner);
    }
    for (const auto& cell : cells) {
        auto& corners = cubes.corners.emplace_back();
        for (unsigned a = 0; a < 8; ++a) corners[a] = number[cell + offset(a)];
    }
    const std::size_t n = cells.size();
    cubes.cell = std::move(cells);
    cubes.mass.assign(n, matter.density * size * size * size);
    cubes.fill.assign(n, 1);
    cubes.young.assign(n, matter.young);
    cubes.poisson.assign(n, matter.poisson);
    cubes.mass_damping.assign(n, 0);
    cubes.stiffness_damping.assign(n, 0);
    cubes.matter.assign(n, 0);
    cubes.matters = {{}};
    return cubes;
}

// A full block of nx x ny x nz cells.
inline geometry::Cubes block_of_cubes(int nx, int ny, int nz, double size,
                                      const CubeMatter& matter = {})
{
    std::vector<geometry::Vec3i> cells;
    for (int z = 0; z < nz; ++z) {
        for (int y = 0; y < ny; ++y) {
            for (int x = 0; x < nx; ++x) cells.emplace_back(x, y, z);
        }
    }
    return some_cubes(std::move(cells), size, matter);
}

// Corners whose lattice coordinate along `axis` is `at`, sorted.
inline std::vector<std::uint32_t> corners_where(const geometry::Cubes& cubes, int axis, int at)
{
    std::vector<std::uint32_t> found;
    for (std::uint32_t i = 0; i < cubes.corner_count(); ++i) {
        if (cubes.corner[i][axis] == at) found.push_back(i);
    }
    return found;
}

}  // namespace test
