#include "geometry/cubes/coarser_cubes.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/cells/sub_cells.hpp"

#include <algorithm>
#include <bit>

namespace geometry {
namespace {

int floor_div(int a, int b)
{
    return a >= 0 ? a / b : -((b - 1 - a) / b);
}

// The quarters of a coarse cell that the material of fine cube f, at `place` in it, lies in.
SubCells quarters_of(const Cubes& fine, std::size_t f, const Vec3i& place, int ratio)
{
    const SubCells held = fine.part.empty() ? all_sub_cells : fine.part[f];
    SubCells out = 0;
    for (int bit = 0; bit < 64; ++bit) {
        if ((held >> bit & 1) == 0) continue;
        const Vec3i within(bit % across_cell, bit / across_cell % across_cell,
                           bit / (across_cell * across_cell));
        const Vec3i at = (across_cell * place + within) / ratio;
        out |= SubCells{1} << sub_cell_bit(at.x(), at.y(), at.z());
    }
    return out;
}

// Some quarters and those beside them, in their cell.
SubCells grown(SubCells quarters)
{
    SubCells out = quarters;
    for (const Move& move : moves_on) out |= move(quarters);
    for (const Move& move : moves_back) out |= move(quarters);
    return out;
}

// Of the cubes first .. last - 1 of one cell, the one with most of these quarters, or with the
// nearest.
std::size_t piece_with(const Cubes& cubes, std::size_t first, std::size_t last, SubCells quarters)
{
    if (last - first == 1 || cubes.part.empty()) return first;
    for (int reach = 0; reach < across_cell; ++reach) {
        std::size_t best = first;
        int most = 0;
        for (std::size_t c = first; c < last; ++c) {
            const int shared = std::popcount(cubes.part[c] & quarters);
            if (shared > most) {
                most = shared;
                best = c;
            }
        }
        if (most > 0) return best;
        quarters = grown(quarters);
    }
    return first;
}

}  // namespace

std::vector<std::uint32_t> coarser_cubes(const Cubes& coarse, const Cubes& fine, int ratio)
{
    const auto before = [](const Vec3i& a, const Vec3i& b) {
        return std::array{a.z(), a.y(), a.x()} < std::array{b.z(), b.y(), b.x()};
    };
    std::vector<std::uint32_t> out;
    out.reserve(fine.count());
    for (std::size_t f = 0; f < fine.count(); ++f) {
        Vec3i in;
        for (int i = 0; i < 3; ++i) in[i] = floor_div(fine.cell[f][i], ratio);
        const auto found = std::equal_range(coarse.cell.begin(), coarse.cell.end(), in, before);
        if (found.first == found.second) {
            out.push_back(no_index);
            continue;
        }
        const auto first = static_cast<std::size_t>(found.first - coarse.cell.begin());
        const auto last = static_cast<std::size_t>(found.second - coarse.cell.begin());
        const SubCells quarters = quarters_of(fine, f, fine.cell[f] - ratio * in, ratio);
        out.push_back(static_cast<std::uint32_t>(piece_with(coarse, first, last, quarters)));
    }
    return out;
}

}  // namespace geometry
