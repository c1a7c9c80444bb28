#include "geometry/cubes/body_finder.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/base/union_find.hpp"
#include "geometry/cells/voxel_grid.hpp"
#include "geometry/cubes/components.hpp"
#include "geometry/mesh/mesh.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <tuple>

namespace geometry {
namespace {

// A piece's vertices in a body.
struct Held {
    std::uint32_t body;
    std::size_t vertices;
};

std::vector<std::uint32_t> piece_roots(const TriMesh& mesh)
{
    UnionFind sets(mesh.positions.size());
    for (const auto& [a, b, c] : mesh.triangles()) {
        if (std::max({a, b, c}) >= mesh.positions.size()) continue;
        sets.join(a, b);
        sets.join(a, c);
    }
    return sets.roots();
}

void count_one(std::vector<Held>& held, std::uint32_t body)
{
    const auto at =
        std::find_if(held.begin(), held.end(), [&](const Held& h) { return h.body == body; });
    if (at == held.end())
        held.push_back({body, 1});
    else
        ++at->vertices;
}

}  // namespace

BodyFinder::BodyFinder(const Cubes& cubes) : cubes_(&cubes), all_(cubes)
{
    if (cubes.part.empty() || cubes.is_sheet()) return;
    Components bodies = find_components(cubes, Connectivity::corner);
    if (bodies.count() < 2) return;
    body_ = std::move(bodies.label);
    size_ = std::move(bodies.cubes);
}

// Cubes whose quarters are within the slack of a place, and the square of how far, in cubes.
template <class Visit> void BodyFinder::visit_holders(const Vec3& at, const Visit& visit) const
{
    constexpr double slack = 1e-3;  // cubes
    if (!at.allFinite() || at.cwiseAbs().maxCoeff() >= CellSet::extent) return;
    const Vec3i lo = (at.array() - slack).floor().cast<int>(),
                hi = (at.array() + slack).floor().cast<int>();
    for (int z = lo.z(); z <= hi.z(); ++z) {
        for (int y = lo.y(); y <= hi.y(); ++y) {
            for (int x = lo.x(); x <= hi.x(); ++x) {
                const auto found = all_.in_cell({x, y, z});
                for (std::uint32_t c = found.begin; c < found.end; ++c) {
                    const double d_sq =
                        quarters_distance_sq(cubes_->part[c], at - cubes_->cell[c].cast<double>());
                    if (d_sq <= slack * slack) visit(c, d_sq);
                }
            }
        }
    }
}

std::vector<std::uint32_t> BodyFinder::bodies_of(const TriMesh& mesh) const
{
    if (body_.empty()) return {};
    const std::size_t n = mesh.positions.size();
    std::vector<std::vector<std::uint32_t>> holders(n);
    parallel_for(n, 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const Vec3 at = (mesh.positions[v].cast<double>() - cubes_->origin) / cubes_->size;
            visit_holders(at, [&](std::uint32_t c, double) {
                if (std::find(holders[v].begin(), holders[v].end(), body_[c]) == holders[v].end()) {
                    holders[v].push_back(body_[c]);
                }
            });
        }
    });
    const std::vector<std::uint32_t> piece = piece_roots(mesh);
    std::map<std::uint32_t, std::vector<Held>> held;
    for (std::size_t v = 0; v < n; ++v) {
        std::vector<Held>& of_piece = held[piece[v]];
        for (const auto body : holders[v]) count_one(of_piece, body);
    }
    std::vector<std::size_t> taken(size_.size(), 0);
    std::map<std::uint32_t, std::uint32_t> body_of;
    for (const auto& [root, bodies] : held) {
        std::uint32_t best = no_index;
        const auto rank = [&](const Held& h) {
            return std::tuple(std::numeric_limits<std::size_t>::max() - h.vertices, size_[h.body],
                              taken[h.body], h.body);
        };
        const auto first =
            std::min_element(bodies.begin(), bodies.end(),
                             [&](const Held& a, const Held& b) { return rank(a) < rank(b); });
        if (first != bodies.end()) best = first->body, ++taken[best];
        body_of[root] = best;
    }
    std::vector<std::uint32_t> out(n);
    for (std::size_t v = 0; v < n; ++v) out[v] = body_of[piece[v]];
    return out;
}

std::uint32_t BodyFinder::holder(const Vec3& at, std::uint32_t body) const
{
    // A place on a face is of what holds the quarter above it, or else of its own cell.
    using Rank = std::tuple<double, bool, bool>;
    Rank best_rank{std::numeric_limits<double>::infinity(), true, true};
    std::uint32_t best = no_index;
    const Vec3i cell = cell_of(at);
    visit_holders(at, [&](std::uint32_t c, double d_sq) {
        if (body_[c] != body) return;
        const Vec3 in = at - cubes_->cell[c].cast<double>();
        const Rank rank{d_sq, cubes_->cell[c] != cell, !quarters_hold(cubes_->part[c], in)};
        if (rank < best_rank) best = c, best_rank = rank;
    });
    return best;
}

std::uint32_t BodyFinder::find(const Vec3& at, std::uint32_t body) const
{
    const std::uint32_t own = body == no_index ? no_index : holder(at, body);
    return own != no_index ? own : all_.find(at);
}

std::uint32_t BodyFinder::find_near(const Vec3& at, std::uint32_t body) const
{
    const std::uint32_t own = body == no_index ? no_index : holder(at, body);
    return own != no_index ? own : all_.find_near(at);
}

}  // namespace geometry
