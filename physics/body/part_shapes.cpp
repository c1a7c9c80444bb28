#include "physics/body/part_shapes.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"

#include <algorithm>
#include <cmath>

namespace physics {

PartLists make_part_lists(const std::vector<std::uint32_t>& list_of, std::size_t lists)
{
    PartLists out;
    out.at.assign(lists + 1, 0);
    for (const auto list : list_of) ++out.at[list + 1];
    for (std::size_t i = 0; i < lists; ++i) out.at[i + 1] += out.at[i];
    out.item.resize(list_of.size());
    auto next = out.at;
    for (std::uint32_t i = 0; i < list_of.size(); ++i) out.item[next[list_of[i]]++] = i;
    return out;
}

PartLists cubes_around(const std::vector<std::array<std::uint32_t, 8>>& corners,
                       const std::vector<std::uint32_t>& of, std::size_t slots)
{
    std::vector<std::uint32_t> corner_list;
    for (const auto& eight : corners) {
        corner_list.insert(corner_list.end(), eight.begin(), eight.end());
    }
    const PartLists at_corner = make_part_lists(corner_list, slots);  // items: 8 c + a
    std::vector<std::uint32_t> met(corners.size(), geometry::no_index);
    PartLists out;
    out.at.push_back(0);
    for (std::uint32_t i = 0; i < of.size(); ++i) {
        std::vector<std::uint32_t> found{of[i]};
        met[of[i]] = i;
        std::size_t begin = 0;
        for (int step = 0; step < 2; ++step) {
            const std::size_t end = found.size();
            for (; begin < end; ++begin) {
                for (const auto k : corners[found[begin]]) {
                    for (const auto item : at_corner[k]) {
                        if (met[item / 8] == i) continue;
                        met[item / 8] = i;
                        found.push_back(item / 8);
                    }
                }
            }
        }
        std::sort(found.begin(), found.end());
        out.item.insert(out.item.end(), found.begin(), found.end());
        out.at.push_back(static_cast<std::uint32_t>(out.item.size()));
    }
    return out;
}

geometry::Vec3 PartShapes::inner_place(std::uint32_t part, std::uint32_t cube) const
{
    // Near the middle, where few models have a face.
    const geometry::Vec3 inner(0.5137, 0.4871, 0.5079);
    return grid[part].origin + grid[part].size * (cell[cube].cast<double>() + inner);
}

void find_windings(PartShapes& shapes)
{
    shapes.winding.assign(shapes.cell.size(), unknown_winding);
    const auto find = [&](std::uint32_t part, std::uint32_t cube) {
        constexpr double most = 1000;
        const double w = shapes.shape[part].winding_number(shapes.inner_place(part, cube));
        const double whole = std::round(w);
        // Off a whole number: on a face, or so near to one that rounding speaks.
        if (std::abs(w - whole) < 0.02 && std::abs(whole) < most) {
            shapes.winding[cube] = static_cast<std::int16_t>(whole);
        }
    };
    for (std::uint32_t part = 0; part < shapes.parts(); ++part) {
        const auto cubes = shapes.cubes[part];
        geometry::parallel_for(cubes.size(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) find(part, cubes[i]);
        });
    }
}

std::size_t PartShapes::bytes() const
{
    const auto of = [](const auto&... v) { return ((v.size() * sizeof(v[0])) + ...); };
    std::size_t sum = sizeof *this + of(grid, cell, corners, stiffness, mass, point, holder,
                                        point_at, overlapping, quarters, winding);
    for (const PartLists* lists : {&cubes, &slots, &holders, &around})
        sum += of(lists->at, lists->item);
    for (const auto* trees : {&shape, &outer}) {
        for (const auto& tree : *trees) sum += tree.bytes();
    }
    return sum;
}

}  // namespace physics
