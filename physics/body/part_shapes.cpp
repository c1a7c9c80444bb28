#include "physics/body/part_shapes.hpp"

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

std::size_t PartShapes::bytes() const
{
    const auto of = [](const auto&... v) { return ((v.size() * sizeof(v[0])) + ...); };
    std::size_t sum =
        sizeof *this + of(cell, corners, stiffness, mass, point, holder, point_at, overlapping);
    for (const PartLists* lists : {&cubes, &slots, &holders}) sum += of(lists->at, lists->item);
    for (const auto& tree : shape) sum += tree.bytes();
    return sum;
}

}  // namespace physics
