#include "geometry/cubes/glued_pieces.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/union_find.hpp"
#include "geometry/cells/cell_set.hpp"
#include "geometry/cells/voxel_grid.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace geometry {
namespace {

constexpr std::size_t most_pairs = 256;
constexpr double touching = 0.05;  // cubes: what is nearer than this is one body

using Pair = std::array<std::uint32_t, 2>;

// Calls visit(point) for points of a triangle, at most a third of `size` apart, or for a large one
// 64 a side.
template <class Visit>
void points_of(const TriMesh& mesh, const Triangle& t, double size, const Visit& visit)
{
    const Vec3 a = mesh.positions[t[0]].cast<double>(),
               ab = mesh.positions[t[1]].cast<double>() - a,
               ac = mesh.positions[t[2]].cast<double>() - a;
    const double longest = std::max({ab.norm(), ac.norm(), (ac - ab).norm()});
    const int n = static_cast<int>(std::clamp(std::ceil(3 * longest / size), 1.0, 64.0));
    for (int i = 0; i <= n; ++i) {
        for (int j = 0; i + j <= n; ++j) visit(Vec3(a + (i * ab + j * ac) / n));
    }
}

// Where pieces come together in the cubes.
struct Meetings {
    std::set<Pair> pairs;
    std::map<std::uint32_t, std::vector<Vec3>> points;  // of a piece, near another one
};

Meetings meetings(const TriMesh& mesh, const Pieces& pieces, const Cubes& cubes)
{
    const CellIndex index(cubes.cell);
    std::vector<std::uint32_t> owner(cubes.corner_count(), no_index);
    std::vector<std::uint8_t> shared(cubes.corner_count(), 0);
    const auto each_point = [&](const auto& visit) {
        for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
            if (pieces.of[t] == no_index) continue;
            points_of(mesh, mesh.triangles()[t], cubes.size, [&](const Vec3& p) {
                const Vec3 at = (p - cubes.origin) / cubes.size;
                auto found = index.find(cell_of(at));
                // A face between two cubes may be of the lower one.
                if (!found) found = index.find(cell_of(at - Vec3::Constant(1e-5)));
                if (found) visit(p, pieces.of[t], cubes.corners[found.begin]);
            });
        }
    };
    Meetings out;
    each_point([&](const Vec3&, std::uint32_t piece, const std::array<std::uint32_t, 8>& corners) {
        for (const std::uint32_t c : corners) {
            if (owner[c] == no_index) owner[c] = piece;
            if (owner[c] == piece) continue;
            shared[c] = 1;
            if (out.pairs.size() < most_pairs) {
                out.pairs.insert({std::min(owner[c], piece), std::max(owner[c], piece)});
            }
        }
    });
    if (out.pairs.empty()) return out;
    each_point(
        [&](const Vec3& p, std::uint32_t piece, const std::array<std::uint32_t, 8>& corners) {
            if (std::any_of(corners.begin(), corners.end(),
                            [&](std::uint32_t c) { return shared[c]; })) {
                out.points[piece].push_back(p);
            }
        });
    return out;
}

TriMesh one_piece(const TriMesh& mesh, const Pieces& pieces, std::uint32_t piece)
{
    std::map<std::uint32_t, std::uint32_t> number;
    MeshTopology topology;
    TriMesh out;
    for (std::size_t t = pieces.first[piece]; t < mesh.triangles().size(); ++t) {
        if (pieces.of[t] != piece) continue;
        Triangle triangle = mesh.triangles()[t];
        for (std::uint32_t& v : triangle) {
            const auto [at, fresh] =
                number.try_emplace(v, static_cast<std::uint32_t>(out.positions.size()));
            if (fresh) out.positions.push_back(mesh.positions[v]);
            v = at->second;
        }
        topology.triangles.push_back(triangle);
    }
    out.topology = std::make_shared<const MeshTopology>(std::move(topology));
    return out;
}

// The shortest way between two pieces.
struct Gap {
    double distance = std::numeric_limits<double>::infinity();  // m; 0: they overlap
    double along = 0;                                           // m, its largest part along an axis
    Vec3 where = Vec3::Zero();
};

// From points to the piece in the tree.
void shorten(const std::vector<Vec3>& points, const TriangleBvh& tree, bool encloses,
             bool inside_out, Gap& gap)
{
    std::vector<TriangleBvh::Hit> hits(points.size());
    tree.closest(points, std::numeric_limits<double>::infinity(), hits);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (!hits[i]) continue;
        const bool inside = encloses && hits[i].behind != inside_out;
        const double distance = inside ? 0 : hits[i].distance;
        if (distance >= gap.distance) continue;
        gap.distance = distance;
        gap.where = 0.5 * (hits[i].point + points[i]);
        gap.along = (hits[i].point - points[i]).cwiseAbs().maxCoeff();
    }
}

double two_digits_below(double x)
{
    const double digit = std::pow(10, std::floor(std::log10(x)) - 1);
    return std::floor(x / digit) * digit;
}

}  // namespace

GluedPieces find_glued_pieces(const TriMesh& mesh, const Pieces& pieces, const Cubes& cubes)
{
    GluedPieces out;
    if (pieces.count() < 2) return out;
    const Meetings meet = meetings(mesh, pieces, cubes);
    std::map<std::uint32_t, TriangleBvh> trees;
    for (const Pair& pair : meet.pairs) {
        for (const std::uint32_t p : pair) {
            if (!trees.contains(p)) trees.emplace(p, TriangleBvh(one_piece(mesh, pieces, p)));
        }
    }
    UnionFind bodies(pieces.count());
    std::vector<std::pair<Pair, Gap>> apart;
    for (const Pair& pair : meet.pairs) {
        Gap gap;
        for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
            const std::uint32_t to = pair[1 - k];
            shorten(meet.points.at(pair[k]), trees.at(to), pieces.encloses[to] != 0,
                    pieces.volume[to] < 0, gap);
        }
        if (gap.distance < touching * cubes.size) {
            bodies.join(pair[0], pair[1]);
        } else {
            apart.emplace_back(pair, gap);
        }
    }
    std::set<std::uint32_t> glued;
    for (const auto& [pair, gap] : apart) {
        if (bodies.root(pair[0]) == bodies.root(pair[1])) continue;
        glued.insert(pair.begin(), pair.end());
        if (out.size > 0 && gap.distance >= out.gap) continue;
        out.pair = pair;
        out.gap = gap.distance;
        out.where = gap.where;
        out.size = two_digits_below(0.95 * gap.along / 2);  // a plane of corners lies between them
    }
    out.count = glued.size();
    return out;
}

}  // namespace geometry
