#include "geometry/cubes/piece_meetings.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "geometry/cells/voxel_grid.hpp"
#include "geometry/mesh/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

namespace geometry {
namespace {

PiecePair pair_of(std::uint32_t a, std::uint32_t b)
{
    return {std::min(a, b), std::max(a, b)};
}

constexpr std::size_t block_size = 2048;  // triangles

// Finds the cubes that hold points, most of which lie in the cell of the one before.
class CubeHolder {
public:
    explicit CubeHolder(const PlacedMesh& all)
        : finder_(all.finder), origin_(all.cubes.origin), per_cube_(1 / all.cubes.size),
          copies_(!all.cubes.part.empty())
    {}

    std::uint32_t of(const Vec3& p)  // no_index where there is none
    {
        const Vec3 lattice = per_cube_ * (p - origin_);
        if (copies_) {
            // On a plane between the quarters of two pieces it is of the upper one: where the lower
            // one reaches the plane they are one. Rounding may have taken it off the plane.
            const std::uint32_t cube = finder_.find(lattice + below);
            return cube != no_index ? cube : finder_.find(lattice - below);
        }
        const Vec3i cell = cell_of(lattice);
        if (cube_ != no_index && cell == cell_) return cube_;
        auto found = finder_.in_cell(cell);
        cell_ = cell;
        cube_ = found ? found.begin : no_index;
        if (found) return cube_;
        // A face between two cubes may be of the lower one.
        found = finder_.in_cell(cell_of(lattice - below));
        return found ? found.begin : no_index;
    }

private:
    const Vec3 below = Vec3::Constant(1e-5);
    const CubeFinder& finder_;
    const Vec3 origin_;
    const double per_cube_;
    const bool copies_;  // several cubes may have one cell
    Vec3i cell_ = Vec3i::Zero();
    std::uint32_t cube_ = no_index;
};

// Whether the cubes of the corners hold the whole triangle: they are one, or share a face.
bool in_two_cubes(const PlacedMesh& all, const Triangle& t)
{
    Vec3i lo = Vec3i::Constant(std::numeric_limits<int>::max()), hi = -lo;
    for (const std::uint32_t v : t) {
        if (all.cube[v] == no_index) return false;
        const Vec3i& cell = all.cubes.cell[all.cube[v]];
        lo = lo.cwiseMin(cell), hi = hi.cwiseMax(cell);
    }
    return (hi - lo).sum() <= 1;
}

// Calls visit(point) for points of a triangle that is longer than half a cube: rows of points from
// one corner to the opposite, shortest side, at most half of `size` apart, or in a large triangle
// 32 a side.
template <class Visit>
void points_within(const PlacedMesh& all, const Triangle& t, double size, const Visit& visit)
{
    std::array<Vec3, 3> p{all.point(t[0]), all.point(t[1]), all.point(t[2])};
    std::array<double, 3> opposite_sq{};
    for (std::size_t k = 0; k < 3; ++k) {
        opposite_sq[k] = (p[(k + 1) % 3] - p[(k + 2) % 3]).squaredNorm();
    }
    const auto [least, most] = std::minmax_element(opposite_sq.begin(), opposite_sq.end());
    if (*most <= 0.25 * size * size) return;
    const auto steps = [&](double length) {
        return static_cast<int>(std::clamp(std::ceil(2 * length / size), 1.0, 32.0));
    };
    const int rows = steps(std::sqrt(*most));
    const double shortest = std::sqrt(*least);
    std::rotate(p.begin(), p.begin() + (least - opposite_sq.begin()), p.end());
    for (int i = 1; i <= rows; ++i) {
        const double down = double(i) / rows;
        const Vec3 from = p[0] + down * (p[1] - p[0]), across = down * (p[2] - p[1]);
        const int n = steps(down * shortest);
        for (int j = 0; j <= n; ++j) visit(Vec3(from + across * j / n));
    }
}

bool overlap(const Box& a, const Box& b)
{
    return ((a.lo - b.hi).array() <= 0).all() && ((b.lo - a.hi).array() <= 0).all();
}

// Where the boxes around the pieces come so near that they might share a corner of cubes: a piece
// has few such regions, or one around all of them.
struct Regions {
    std::vector<std::vector<Box>> of;  // P

    bool meet(const PlacedMesh& all, const Triangle& t, std::uint32_t piece) const
    {
        Box box;
        for (const std::uint32_t v : t) box.add(all.point(v));
        return std::any_of(of[piece].begin(), of[piece].end(),
                           [&](const Box& region) { return overlap(region, box); });
    }
    void add(std::uint32_t piece, const Box& region)
    {
        constexpr std::size_t few = 12;
        if (of[piece].size() < few) {
            of[piece].push_back(region);
        } else {
            of[piece].back().add(region);
        }
    }
};

Regions find_regions(const PlacedMesh& all)
{
    constexpr std::size_t many = 1024;  // pieces: every two of them would be too many pairs
    Regions regions;
    if (all.pieces.count() > many) {
        regions.of.assign(all.pieces.count(), {bounds(all.mesh)});
        return regions;
    }
    const double reach = 2 * all.cubes.size;  // along each axis
    std::vector<Box> boxes(all.pieces.count());
    for (std::uint32_t v = 0; v < all.piece.size(); ++v) {
        if (all.piece[v] != no_index) boxes[all.piece[v]].add(all.point(v));
    }
    for (Box& box : boxes) {
        box.lo -= Vec3::Constant(reach);
        box.hi += Vec3::Constant(reach);
    }
    std::vector<std::uint32_t> by_x(boxes.size());
    std::iota(by_x.begin(), by_x.end(), 0u);
    std::sort(by_x.begin(), by_x.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::pair(boxes[a].lo.x(), a) < std::pair(boxes[b].lo.x(), b);
    });
    regions.of.resize(boxes.size());
    for (auto a = by_x.begin(); a != by_x.end(); ++a) {
        for (auto b = a + 1; b != by_x.end() && boxes[*b].lo.x() <= boxes[*a].hi.x(); ++b) {
            if (!overlap(boxes[*a], boxes[*b])) continue;
            const Box common{boxes[*a].lo.cwiseMax(boxes[*b].lo),
                             boxes[*a].hi.cwiseMin(boxes[*b].hi)};
            regions.add(*a, common);
            regions.add(*b, common);
        }
    }
    return regions;
}

PlacedMesh::Block block_of(const PlacedMesh& all, const Regions& regions, std::size_t begin,
                           std::size_t end)
{
    PlacedMesh::Block block;
    CubeHolder holder(all);
    block.cubes.reserve(3 * (end - begin));
    for (std::size_t t = begin; t < end; ++t) {
        const auto first = static_cast<std::uint32_t>(block.cubes.size());
        block.first.push_back(first);
        if (all.pieces.of[t] == no_index) continue;
        const Triangle& triangle = all.mesh.triangles()[t];
        if (!regions.meet(all, triangle, all.pieces.of[t])) continue;
        const auto add = [&](std::uint32_t cube) {
            const bool known = block.cubes.size() > first && block.cubes.back() == cube;
            if (cube != no_index && !known) block.cubes.push_back(cube);
        };
        for (const std::uint32_t v : triangle) add(all.cube[v]);
        if (in_two_cubes(all, triangle)) continue;
        points_within(all, triangle, all.cubes.size, [&](const Vec3& p) { add(holder.of(p)); });
    }
    block.first.push_back(static_cast<std::uint32_t>(block.cubes.size()));
    return block;
}

// Whether pieces meet at a corner of a cube.
bool has_meeting(const PieceMeetings& all, const std::array<std::uint32_t, 8>& corners)
{
    return std::any_of(corners.begin(), corners.end(),
                       [&](std::uint32_t c) { return all.at[c][1] != no_index; });
}

void mark_near(const Cubes& cubes, PieceMeetings& all)
{
    std::vector<std::uint8_t> corner(cubes.corner_count(), 0);
    for (const auto& corners : cubes.corners) {
        if (!has_meeting(all, corners)) continue;
        for (const std::uint32_t c : corners) corner[c] = 1;
    }
    all.near.assign(cubes.count(), PieceMeetings::far);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const auto& corners = cubes.corners[c];
        if (has_meeting(all, corners)) {
            all.near[c] = PieceMeetings::here;
        } else if (std::any_of(corners.begin(), corners.end(),
                               [&](std::uint32_t v) { return corner[v] != 0; })) {
            all.near[c] = PieceMeetings::beside;
        }
    }
}

}  // namespace

std::span<const std::uint32_t> PlacedMesh::cubes_of(std::size_t triangle) const
{
    const Block& block = blocks[triangle / block_size];
    const std::size_t t = triangle % block_size;
    return std::span(block.cubes).subspan(block.first[t], block.first[t + 1] - block.first[t]);
}

PlacedMesh place_mesh(const TriMesh& mesh, const Pieces& pieces, const Cubes& cubes)
{
    const std::size_t n = mesh.positions.size(), count = mesh.triangles().size();
    PlacedMesh all{mesh,
                   pieces,
                   cubes,
                   CubeFinder(cubes),
                   std::vector<std::uint32_t>(n, no_index),
                   std::vector<std::uint32_t>(n, no_index),
                   {}};
    for (std::size_t t = 0; t < count; ++t) {
        if (pieces.of[t] == no_index) continue;
        for (const std::uint32_t v : mesh.triangles()[t]) all.piece[v] = pieces.of[t];
    }
    parallel_for(n, 1024, [&](std::size_t begin, std::size_t end) {
        CubeHolder holder(all);
        for (std::size_t v = begin; v < end; ++v) {
            if (all.piece[v] == no_index) continue;
            all.cube[v] = holder.of(all.point(static_cast<std::uint32_t>(v)));
        }
    });
    const Regions regions = find_regions(all);
    all.blocks.resize((count + block_size - 1) / block_size);
    parallel_for(all.blocks.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            all.blocks[b] =
                block_of(all, regions, b * block_size, std::min((b + 1) * block_size, count));
        }
    });
    return all;
}

bool PieceMeetings::any(std::span<const std::uint32_t> cubes, Near at_least) const
{
    return std::any_of(cubes.begin(), cubes.end(),
                       [&](std::uint32_t c) { return near[c] >= at_least; });
}

PieceMeetings find_piece_meetings(const PlacedMesh& all, std::size_t most_pairs)
{
    const Cubes& cubes = all.cubes;
    PieceMeetings out;
    out.at.assign(cubes.corner_count(), {no_index, no_index});
    std::set<PiecePair> pairs;
    std::vector<std::uint32_t> last(cubes.count(), no_index);  // piece at each cube
    for (std::size_t t = 0; t < all.mesh.triangles().size(); ++t) {
        const std::uint32_t piece = all.pieces.of[t];
        if (piece == no_index) continue;
        for (const std::uint32_t cube : all.cubes_of(t)) {
            if (std::exchange(last[cube], piece) == piece) continue;
            for (const std::uint32_t c : cubes.corners[cube]) {
                auto& [first, other] = out.at[c];
                if (first == no_index) first = piece;
                if (first == piece || other != no_index) continue;
                other = piece;
                if (pairs.size() < most_pairs) pairs.insert(pair_of(first, piece));
            }
        }
    }
    out.pairs.assign(pairs.begin(), pairs.end());
    if (!pairs.empty()) mark_near(cubes, out);
    return out;
}

std::vector<std::array<std::vector<Vec3>, 2>> points_of_pairs(const PlacedMesh& all,
                                                              const PieceMeetings& meetings)
{
    std::vector<std::array<std::vector<Vec3>, 2>> out(meetings.pairs.size());
    struct Place {
        std::uint32_t piece = no_index;
        std::vector<Vec3>* points = nullptr;
    };
    std::vector<Place> last(all.cubes.count());
    // Points of a piece in a cube go to the first of the pairs that meet at its corners.
    const auto find = [&](std::uint32_t cube, std::uint32_t piece) -> std::vector<Vec3>* {
        for (const std::uint32_t c : all.cubes.corners[cube]) {
            const auto [first, other] = meetings.at[c];
            if (other == no_index || (first != piece && other != piece)) continue;
            const PiecePair pair = pair_of(first, other);
            const auto at = std::lower_bound(meetings.pairs.begin(), meetings.pairs.end(), pair);
            if (at == meetings.pairs.end() || *at != pair) continue;
            return &out[static_cast<std::size_t>(at - meetings.pairs.begin())]
                       [pair[0] == piece ? 0 : 1];
        }
        return nullptr;
    };
    const auto add = [&](const Vec3& p, std::uint32_t cube, std::uint32_t piece) {
        if (cube == no_index || meetings.near[cube] != PieceMeetings::here) return;
        if (last[cube].piece != piece) last[cube] = {piece, find(cube, piece)};
        if (last[cube].points) last[cube].points->push_back(p);
    };
    for (std::uint32_t v = 0; v < all.cube.size(); ++v) {
        if (all.piece[v] != no_index) add(all.point(v), all.cube[v], all.piece[v]);
    }
    CubeHolder holder(all);
    for (std::size_t t = 0; t < all.mesh.triangles().size(); ++t) {
        const std::span<const std::uint32_t> cubes = all.cubes_of(t);
        if (cubes.size() < 2 || !meetings.any(cubes, PieceMeetings::here)) continue;
        const Triangle& triangle = all.mesh.triangles()[t];
        points_within(all, triangle, all.cubes.size,
                      [&](const Vec3& p) { add(p, holder.of(p), all.pieces.of[t]); });
    }
    return out;
}

}  // namespace geometry
