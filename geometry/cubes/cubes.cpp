#include "geometry/cubes/cubes.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/cells/cell_set.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

namespace geometry {
namespace {

// One of the four rows of cells around a row of corners.
struct Neighbour {
    std::uint32_t run = 0, end = 0;  // into CellRuns::runs, what is left of it
    std::size_t corner = 0;          // the corner a of its cubes that lies in the row of corners
};

// Numbers one row of corners: the union of the intervals that up to four rows of runs touch.
// Corner number(x) is `next` - start + x within each interval, so a run's cubes count up.
void number_row(const CellRuns& cells, std::array<Neighbour, 4>& rows, std::size_t count, int y,
                int z, Cubes& cubes)
{
    const auto x0 = [&](const Neighbour& n) { return cells.runs[n.run].x0; };
    for (;;) {
        int start = std::numeric_limits<int>::max();
        for (std::size_t i = 0; i < count; ++i) {
            if (rows[i].run < rows[i].end) start = std::min(start, x0(rows[i]));
        }
        if (start == std::numeric_limits<int>::max()) return;
        const auto base = static_cast<std::uint32_t>(cubes.corner.size());
        int end = start;  // last corner of the interval
        for (bool grew = true; grew;) {
            grew = false;
            for (std::size_t i = 0; i < count; ++i) {
                Neighbour& n = rows[i];
                for (; n.run < n.end && x0(n) <= end; ++n.run) {
                    const CellRuns::Run& run = cells.runs[n.run];
                    std::uint32_t number = base + static_cast<std::uint32_t>(run.x0 - start);
                    const auto last = run.first + static_cast<std::uint32_t>(run.x1 - run.x0);
                    for (std::uint32_t c = run.first; c < last; ++c, ++number) {
                        cubes.corners[c][n.corner] = number;
                        cubes.corners[c][n.corner + 1] = number + 1;
                    }
                    if (run.x1 > end) end = run.x1, grew = true;
                }
            }
        }
        for (int x = start; x <= end; ++x) cubes.corner.emplace_back(x, y, z);
    }
}

}  // namespace

void number_corners(Cubes& cubes)
{
    cubes.corners.resize(cubes.cell.size());
    stop_if_asked();
    cubes.corner.clear();
    cubes.corner.reserve(cubes.cell.size() + cubes.cell.size() / 2 + 8);
    const CellRuns cells = runs_of(cubes.cell);
    const std::size_t rows = cells.rows.size() - 1;
    // A row of cells (y, z) touches the rows of corners (y + i, z + j), i, j = 0, 1: four pointers
    // walk over the same rows, and whichever are at the smallest corner row come together there.
    std::array<std::size_t, 4> at{};
    const auto corner_row = [&](std::size_t k) {
        const CellRuns::Row& row = cells.rows[at[k]];
        return std::pair(row.z + static_cast<int>(k / 2), row.y + static_cast<int>(k % 2));
    };
    StopCheck check;
    for (;;) {
        check();
        std::pair<int, int> next(std::numeric_limits<int>::max(), 0);
        for (std::size_t k = 0; k < 4; ++k) {
            if (at[k] < rows) next = std::min(next, corner_row(k));
        }
        if (next.first == std::numeric_limits<int>::max()) break;
        std::array<Neighbour, 4> around;
        std::size_t count = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            if (at[k] >= rows || corner_row(k) != next) continue;
            around[count++] = {cells.rows[at[k]].first, cells.rows[at[k] + 1].first, 2 * k};
            ++at[k];
        }
        number_row(cells, around, count, next.second, next.first, cubes);
    }
}

Cubes solid_cubes(std::vector<Vec3i> cells, double size, const Matter& matter, const Vec3& origin)
{
    std::sort(cells.begin(), cells.end(), [](const Vec3i& a, const Vec3i& b) {
        return std::tuple(a.z(), a.y(), a.x()) < std::tuple(b.z(), b.y(), b.x());
    });
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    stop_if_asked();
    Cubes cubes;
    cubes.size = size;
    cubes.origin = origin;
    cubes.cell = std::move(cells);
    number_corners(cubes);
    stop_if_asked();
    const std::size_t n = cubes.count();
    cubes.mass.assign(n, matter.density * size * size * size);
    cubes.fill.assign(n, 1.0);
    cubes.young.assign(n, matter.young);
    cubes.poisson.assign(n, matter.poisson);
    cubes.mass_damping.assign(n, matter.mass_damping);
    cubes.stiffness_damping.assign(n, matter.stiffness_damping);
    cubes.matter.assign(n, 0);
    cubes.matters = {matter};
    return cubes;
}

Cubes kept(const Cubes& cubes, const std::vector<std::uint8_t>& keep)
{
    Cubes out;
    out.size = cubes.size;
    out.origin = cubes.origin;
    out.matters = cubes.matters;
    std::vector<std::uint32_t> number(cubes.corner_count(), 0);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        if (keep[c]) {
            for (const std::uint32_t k : cubes.corners[c]) number[k] = 1;
        }
    }
    for (std::size_t k = 0; k < number.size(); ++k) {
        if (number[k] == 0) continue;
        number[k] = static_cast<std::uint32_t>(out.corner.size());
        out.corner.push_back(cubes.corner[k]);
        if (!cubes.place.empty()) out.place.push_back(cubes.place[k]);
    }
    const auto take = [&](const auto& from, auto& to) {
        if (from.empty()) return;
        for (std::size_t c = 0; c < keep.size(); ++c) {
            if (keep[c]) to.push_back(from[c]);
        }
    };
    take(cubes.cell, out.cell);
    take(cubes.corners, out.corners);
    for (auto& corners : out.corners) {
        for (std::uint32_t& k : corners) k = number[k];
    }
    take(cubes.mass, out.mass);
    take(cubes.fill, out.fill);
    take(cubes.young, out.young);
    take(cubes.poisson, out.poisson);
    take(cubes.mass_damping, out.mass_damping);
    take(cubes.stiffness_damping, out.stiffness_damping);
    take(cubes.matter, out.matter);
    take(cubes.component, out.component);
    take(cubes.part, out.part);
    for (const CubeAttribute& a : cubes.attributes) {
        take(a.values, out.attributes.emplace_back(CubeAttribute{a.name, a.unit, {}}).values);
    }
    take(cubes.own, out.own);
    for (std::uint32_t& own : out.own) {
        if (own == no_index) continue;
        out.elements.push_back(cubes.elements[own]);
        own = static_cast<std::uint32_t>(out.elements.size() - 1);
    }
    if (out.elements.empty()) out.own.clear();
    return out;
}

std::vector<Vec3> corner_positions(const Cubes& cubes)
{
    std::vector<Vec3> out(cubes.corner_count());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = cubes.corner_position(i);
    return out;
}

bool Cubes::is_own(std::size_t c) const
{
    return !own.empty() && own[c] != no_index;
}

void check_elements(const Cubes& cubes)
{
    bool sound = cubes.own.empty() ? cubes.elements.empty() : cubes.own.size() == cubes.count();
    for (const auto own : cubes.own) sound &= own == no_index || own < cubes.elements.size();
    for (const OwnElement& element : cubes.elements) {
        for (const float k : element.stiffness) sound &= std::isfinite(k);
        for (const float m : element.mass) sound &= std::isfinite(m);
    }
    if (!sound) {
        throw std::invalid_argument("expected an element that exists, of finite numbers, for each "
                                    "cube that has its own, found others. Make the cubes again");
    }
}

std::array<double, 8> corner_shares(const Cubes& cubes, std::size_t c)
{
    std::array<double, 8> out;
    out.fill(cubes.is_own(c) ? 0 : 1.0 / 8);
    if (is_triangle(cubes.corners[c])) {
        // A third for each corner of the triangle: the first two are two of a cube's, the last
        // four.
        constexpr double two = 1.0 / 6, four = 1.0 / 12;
        return {two, two, four, four, two, two, four, four};
    }
    if (!cubes.is_own(c)) return out;
    std::size_t at = 0;
    for (std::size_t a = 0; a < 8; ++a) {
        for (std::size_t b = 0; b <= a; ++b) {
            const auto m = double(cubes.elements[cubes.own[c]].mass[at++]);
            out[a] += m;
            if (b != a) out[b] += m;
        }
    }
    return out;
}

std::vector<double> corner_masses(const Cubes& cubes)
{
    std::vector<double> out(cubes.corner_count(), 0.0);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const auto share = corner_shares(cubes, c);
        for (std::size_t a = 0; a < 8; ++a) out[cubes.corners[c][a]] += cubes.mass[c] * share[a];
    }
    return out;
}

double total_mass(const Cubes& cubes)
{
    double sum = 0;
    for (const double m : cubes.mass) sum += m;
    return sum;
}

std::size_t component_count(const Cubes& cubes)
{
    std::uint32_t most = 0;
    for (const std::uint32_t c : cubes.component) most = std::max(most, c + 1);
    return most;
}

}  // namespace geometry
