#include "geometry/cubes/cube_finder.hpp"

#include "geometry/cells/sub_cells.hpp"

#include <algorithm>
#include <bit>
#include <limits>

namespace geometry {
namespace {

constexpr double inside_slack = 1e-3;  // of a cube
constexpr double quarter = 1.0 / across_cell;

Vec3 lower_corner(unsigned bit)
{
    return quarter * Vec3(bit & 3, bit >> 2 & 3, bit >> 4);
}

// A cell beyond those that can be, where the place is beyond them.
Vec3i cell_within_reach(const Vec3& at)
{
    constexpr double reach = CellSet::extent;
    return at.array().floor().cwiseMax(-reach - 1).cwiseMin(reach).matrix().cast<int>();
}

// The step to neighbour n of 27; 13 leads nowhere.
Vec3i step_to(int n)
{
    return {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
}

}  // namespace

void CubeFinder::look_in(const Vec3i& cell, const Vec3& at, Nearest& best) const
{
    const auto found = index_.find(cell);
    for (std::uint32_t c = found.begin; c < found.end; ++c) {
        const double d_sq = quarters_distance_sq(cubes_->part[c], at - cell.cast<double>());
        if (d_sq < best.distance_sq) best = {c, d_sq};
    }
}

std::uint32_t CubeFinder::find(const Vec3& at) const
{
    constexpr double reach = CellSet::extent;
    const Vec3i cell = at.array().floor().cwiseMax(-reach - 1).cwiseMin(reach).matrix().cast<int>();
    if (cubes_->part.empty()) {
        const auto found = index_.find(cell);
        return found ? found.begin : no_index;
    }
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Nearest here{no_index, infinity};
    look_in(cell, at, here);
    if (here.distance_sq == 0) {
        // A place on a face is nearest to what holds the quarter above it.
        const Vec3i q = (across_cell * (at - cell.cast<double>())).cast<int>().cwiseMin(3);
        const auto found = index_.find(cell);
        const unsigned bit = sub_cell_bit(q.x(), q.y(), q.z());
        for (std::uint32_t c = found.begin; c < found.end; ++c) {
            if (cubes_->part[c] >> bit & 1) return c;
        }
    }
    Nearest beyond{no_index, infinity};
    for (int n = 0; n < 27 && here.distance_sq > 0; ++n) {
        if (n != 13) look_in(cell + step_to(n), at, beyond);
    }
    const bool close = beyond.distance_sq <= inside_slack * inside_slack;
    return close && beyond.distance_sq < here.distance_sq ? beyond.cube : here.cube;
}

std::uint32_t CubeFinder::find_near(const Vec3& at) const
{
    const std::uint32_t holder = find(at);
    if (holder != no_index) return holder;
    const Vec3i cell = cell_within_reach(at);
    Nearest best{no_index, std::numeric_limits<double>::infinity()};
    for (int n = 0; n < 27; ++n) {
        const auto found = index_.find(cell + step_to(n));
        for (std::uint32_t c = found.begin; c < found.end; ++c) {
            const Box held = held_box(*cubes_, c);
            const double d_sq = (at - at.cwiseMax(held.lo).cwiseMin(held.hi)).squaredNorm();
            if (d_sq < best.distance_sq) best = {c, d_sq};
        }
    }
    return best.cube;
}

double quarters_distance_sq(SubCells part, const Vec3& at)
{
    double best = std::numeric_limits<double>::infinity();
    for (; part != 0; part &= part - 1) {
        const Vec3 lo = lower_corner(static_cast<unsigned>(std::countr_zero(part)));
        const Vec3 off = (lo - at).cwiseMax(at - lo - Vec3::Constant(quarter)).cwiseMax(0.0);
        best = std::min(best, off.squaredNorm());
    }
    return best;
}

bool quarters_hold(std::uint64_t part, const Vec3& at)
{
    const Vec3i q = (across_cell * at).cwiseMax(0.0).cwiseMin(across_cell - 1.0).cast<int>();
    return (part >> sub_cell_bit(q.x(), q.y(), q.z()) & 1) != 0;
}

bool share_a_corner(const Cubes& cubes, std::size_t a, std::size_t b)
{
    const auto &of_a = cubes.corners[a], &of_b = cubes.corners[b];
    return std::find_first_of(of_a.begin(), of_a.end(), of_b.begin(), of_b.end()) != of_a.end();
}

Box held_box(const Cubes& cubes, std::size_t cube)
{
    const Vec3 cell = cubes.cell[cube].cast<double>();
    Box box;
    if (cubes.part.empty()) {
        box.add(cell);
        box.add(cell + Vec3::Ones());
        return box;
    }
    for (SubCells part = cubes.part[cube]; part != 0; part &= part - 1) {
        const Vec3 lo = cell + lower_corner(static_cast<unsigned>(std::countr_zero(part)));
        box.add(lo);
        box.add(lo + Vec3::Constant(quarter));
    }
    return box;
}

}  // namespace geometry
