#include "geometry/embed/part_corners.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/union_find.hpp"
#include "geometry/embed/torn_faces.hpp"

#include <algorithm>

namespace geometry {
namespace {

// The cube beside c that has all corners of this face of c; no_index: none. A face is named by what
// its corners have in common: of the bits in `axis`, those in `side`.
std::uint32_t cube_beside(const Cubes& cubes, std::uint32_t c, unsigned axis, unsigned side)
{
    Vec3i cell = cubes.cell[c];
    for (int d = 0; d < 3; ++d) {
        if (axis == 1u << d) cell[d] += side != 0 ? 1 : -1;
    }
    const auto [first, last] =
        std::equal_range(cubes.cell.begin(), cubes.cell.end(), cell, in_front);
    for (auto at = first; at != last; ++at) {
        const auto n = std::uint32_t(at - cubes.cell.begin());
        bool all = true;
        for (unsigned a = 0; a < 8; ++a) {
            if ((a & axis) == side) all &= cubes.corners[c][a] == cubes.corners[n][a ^ axis];
        }
        if (all) return n;
    }
    return no_index;
}

class PartJoiner {
public:
    PartJoiner(const Cubes& cubes, std::span<const PartedCube> parted)
        : cubes_(cubes), parted_(parted)
    {
        std::uint32_t parts = 0;
        for (const PartedCube& p : parted) {
            first_.push_back(parts);
            parts += p.parts;
        }
        out_.of.resize(parts);
        out_.own.assign(8 * std::size_t(parts), no_index);
    }

    PartCorners run()
    {
        UnionFind joined(out_.own.size());
        for (std::uint32_t p = 0; p < parted_.size(); ++p) {
            const auto& corners = cubes_.corners[parted_[p].cube];
            for (unsigned a = 0; a < 8; ++a) out_.own[number(p, a, a)] = corners[a];
            for (const unsigned axis : {1u, 2u, 4u}) {
                if (corners[0] == corners[axis]) continue;  // a plane's, which has no face there
                join_face(p, axis, 0, joined);
                join_face(p, axis, axis, joined);
            }
        }
        for (std::uint32_t i = 0; i < out_.own.size(); ++i) {
            const std::uint32_t root = joined.root(i);
            if (out_.own[i] != no_index) out_.own[root] = out_.own[i];
            out_.of[i / 8][i % 8] = root;
        }
        return std::move(out_);
    }

private:
    // Of the part that has corner a of a parted cube: its corner b.
    std::uint32_t number(std::uint32_t parted, unsigned a, unsigned b) const
    {
        return 8 * (first_[parted] + parted_[parted].part[a]) + b;
    }

    void join_face(std::uint32_t p, unsigned axis, unsigned side, UnionFind& joined)
    {
        const std::uint32_t cube = parted_[p].cube;
        const std::uint32_t beside = cube_beside(cubes_, cube, axis, side);
        if (beside == no_index) return;
        const auto found = std::ranges::lower_bound(parted_, beside, {}, &PartedCube::cube);
        const bool is_whole = found == parted_.end() || found->cube != beside;
        const auto q = std::uint32_t(found - parted_.begin());
        for (unsigned a = 0; a < 8; ++a) {
            for (unsigned b = 0; b < 8; ++b) {
                if ((a & axis) != side || (b & axis) != side) continue;
                if (is_whole) {
                    out_.own[number(p, a, b)] = cubes_.corners[cube][b];
                } else {
                    joined.join(number(p, a, b), number(q, a ^ axis, b ^ axis));
                }
            }
        }
    }

    const Cubes& cubes_;
    std::span<const PartedCube> parted_;
    std::vector<std::uint32_t> first_;  // of each parted cube, its first part
    PartCorners out_;
};

}  // namespace

PartCorners corners_of_parts(const Cubes& cubes, std::span<const PartedCube> parted)
{
    return PartJoiner(cubes, parted).run();
}

}  // namespace geometry
