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
constexpr std::size_t most_points = 256;  // of a piece of a pair
constexpr double touching = 0.05;         // cubes: what is nearer than this is one body

using Pair = std::array<std::uint32_t, 2>;

// Calls visit(point) for points of a triangle, at most half of `size` apart, or for a large one 32
// a side.
template <class Visit>
void points_of(const TriMesh& mesh, const Triangle& t, double size, const Visit& visit)
{
    const Vec3 a = mesh.positions[t[0]].cast<double>(),
               ab = mesh.positions[t[1]].cast<double>() - a,
               ac = mesh.positions[t[2]].cast<double>() - a;
    const double longest = std::max({ab.norm(), ac.norm(), (ac - ab).norm()});
    const int n = static_cast<int>(std::clamp(std::ceil(2 * longest / size), 1.0, 32.0));
    for (int i = 0; i <= n; ++i) {
        for (int j = 0; i + j <= n; ++j) visit(Vec3(a + (i * ab + j * ac) / n));
    }
}

// Points of the first piece of a pair and of the second one where they come together in the cubes.
using Meetings = std::map<Pair, std::array<std::vector<Vec3>, 2>>;

Pair pair_of(std::uint32_t a, std::uint32_t b)
{
    return {std::min(a, b), std::max(a, b)};
}

Meetings meetings(const TriMesh& mesh, const Pieces& pieces, const Cubes& cubes)
{
    const CellIndex index(cubes.cell);
    // The first piece at each corner, and the first other one.
    std::vector<Pair> at(cubes.corner_count(), {no_index, no_index});
    const auto each_point = [&](const auto& visit) {
        for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
            if (pieces.of[t] == no_index) continue;
            points_of(mesh, mesh.triangles()[t], cubes.size, [&](const Vec3& p) {
                const Vec3 lattice = (p - cubes.origin) / cubes.size;
                auto found = index.find(cell_of(lattice));
                // A face between two cubes may be of the lower one.
                if (!found) found = index.find(cell_of(lattice - Vec3::Constant(1e-5)));
                if (found) visit(p, pieces.of[t], cubes.corners[found.begin]);
            });
        }
    };
    Meetings out;
    each_point([&](const Vec3&, std::uint32_t piece, const std::array<std::uint32_t, 8>& corners) {
        for (const std::uint32_t c : corners) {
            auto& [first, other] = at[c];
            if (first == no_index) first = piece;
            if (first == piece || other != no_index) continue;
            other = piece;
            if (out.size() < most_pairs) out[pair_of(first, piece)];
        }
    });
    if (out.empty()) return out;
    each_point(
        [&](const Vec3& p, std::uint32_t piece, const std::array<std::uint32_t, 8>& corners) {
            for (const std::uint32_t c : corners) {
                const auto [first, other] = at[c];
                if (other == no_index || (first != piece && other != piece)) continue;
                const auto found = out.find(pair_of(first, other));
                if (found == out.end()) continue;
                found->second[found->first[0] == piece ? 0 : 1].push_back(p);
                return;
            }
        });
    return out;
}

// The triangles of each piece that is looked at, as a tree.
class Trees {
public:
    Trees(const TriMesh& mesh, const Pieces& pieces) : mesh_(mesh), triangles_(pieces.count())
    {
        for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
            if (pieces.of[t] != no_index) triangles_[pieces.of[t]].push_back(mesh.triangles()[t]);
        }
    }

    const TriangleBvh& of(std::uint32_t piece)
    {
        const auto known = trees_.find(piece);
        if (known != trees_.end()) return known->second;
        std::map<std::uint32_t, std::uint32_t> number;
        MeshTopology topology;
        TriMesh out;
        for (Triangle triangle : triangles_[piece]) {
            for (std::uint32_t& v : triangle) {
                const auto [at, fresh] =
                    number.try_emplace(v, static_cast<std::uint32_t>(out.positions.size()));
                if (fresh) out.positions.push_back(mesh_.positions[v]);
                v = at->second;
            }
            topology.triangles.push_back(triangle);
        }
        out.topology = std::make_shared<const MeshTopology>(std::move(topology));
        return trees_.emplace(piece, TriangleBvh(out)).first->second;
    }

private:
    const TriMesh& mesh_;
    std::vector<std::vector<Triangle>> triangles_;
    std::map<std::uint32_t, TriangleBvh> trees_;
};

// The shortest way between two pieces.
struct Gap {
    double distance = std::numeric_limits<double>::infinity();  // m; 0: they overlap
    double along = 0;                                           // m, its largest part along an axis
    Vec3 where = Vec3::Zero();
};

// From some of the points to the piece in the tree, until the gap is below `enough` (m).
void shorten(const std::vector<Vec3>& points, const TriangleBvh& tree, bool encloses,
             bool inside_out, double enough, Gap& gap)
{
    const std::size_t step = points.size() / most_points + 1;
    for (std::size_t i = 0; i < points.size() && gap.distance >= enough; i += step) {
        const TriangleBvh::Hit hit = tree.closest(points[i], gap.distance);
        if (!hit) continue;
        const bool inside = encloses && hit.behind != inside_out;
        gap.distance = inside ? 0 : hit.distance;
        gap.where = 0.5 * (hit.point + points[i]);
        gap.along = (hit.point - points[i]).cwiseAbs().maxCoeff();
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
    const double enough = touching * cubes.size;
    Trees trees(mesh, pieces);
    UnionFind bodies(pieces.count());
    std::vector<std::pair<Pair, Gap>> apart;
    for (const auto& [pair, points] : meetings(mesh, pieces, cubes)) {
        if (bodies.root(pair[0]) == bodies.root(pair[1])) continue;
        Gap gap;
        for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
            if (points[k].empty()) continue;
            const std::uint32_t to = pair[1 - k];
            shorten(points[k], trees.of(to), pieces.encloses[to] != 0, pieces.volume[to] < 0,
                    enough, gap);
        }
        if (gap.distance < enough) {
            bodies.join(pair[0], pair[1]);
        } else if (std::isfinite(gap.distance)) {
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
