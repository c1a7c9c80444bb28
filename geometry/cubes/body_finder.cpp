#include "geometry/cubes/body_finder.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "geometry/cubes/components.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace geometry {
namespace {

// One point of a piece that a body holds: the piece's first vertex, and the body.
using Vote = std::pair<std::uint32_t, std::uint32_t>;

// How many points of a piece a body holds.
struct Held {
    std::uint32_t piece, body;
    std::size_t points;
};

// Piece by piece.
std::vector<Held> counted(std::vector<Vote>& votes)
{
    std::sort(votes.begin(), votes.end());
    std::vector<Held> out;
    for (const auto& [piece, body] : votes) {
        if (out.empty() || out.back().piece != piece || out.back().body != body) {
            out.push_back({piece, body, 0});
        }
        ++out.back().points;
    }
    return out;
}

// The first vertex of each vertex's piece; no_index where no triangle uses it.
std::vector<std::uint32_t> piece_roots(const TriMesh& mesh)
{
    std::vector<std::uint8_t> used(mesh.positions.size(), 0);
    for (const auto& [a, b, c] : mesh.triangles()) {
        if (std::max({a, b, c}) < used.size()) used[a] = used[b] = used[c] = 1;
    }
    std::vector<std::uint32_t> out = first_vertices(mesh);
    for (std::size_t v = 0; v < out.size(); ++v) {
        if (used[v] == 0) out[v] = no_index;
    }
    return out;
}

// Calls visit(p) for points of a triangle at most a cube apart, but for very large ones, without
// its vertices. Points are in cubes.
template <class Visit> void visit_points(const std::array<Vec3, 3>& t, const Visit& visit)
{
    constexpr double most = 16;
    const double longest =
        std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
    if (!(longest > 1)) return;
    const auto n = static_cast<int>(std::min(std::ceil(longest), most));
    for (int i = 0; i <= n; ++i) {
        for (int k = 0; k <= n - i; ++k) {
            if (i == n || k == n || i + k == 0) continue;
            visit(Vec3(t[0] + (i * (t[1] - t[0]) + k * (t[2] - t[0])) / n));
        }
    }
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
    constexpr std::size_t a_task = 4096;
    const std::vector<std::uint32_t> piece = piece_roots(mesh);
    const std::size_t n = piece.size(), triangles = mesh.triangles().size();
    const auto place = [&](std::uint32_t v) {
        return Vec3((mesh.positions[v].cast<double>() - cubes_->origin) / cubes_->size);
    };
    std::vector<std::vector<Vote>> found((std::max(n, triangles) + a_task - 1) / a_task);
    parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t> bodies;
        for (std::size_t task = begin; task < end; ++task) {
            const auto vote = [&](std::uint32_t root, const Vec3& at) {
                bodies.clear();
                visit_holders(at, [&](std::uint32_t c, double) { bodies.push_back(body_[c]); });
                std::sort(bodies.begin(), bodies.end());
                bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
                for (const auto b : bodies) found[task].emplace_back(root, b);
            };
            const std::size_t first = task * a_task, last = first + a_task;
            for (std::size_t v = first; v < std::min(last, n); ++v) {
                if (piece[v] != no_index) vote(piece[v], place(std::uint32_t(v)));
            }
            for (std::size_t t = first; t < std::min(last, triangles); ++t) {
                const auto& [a, b, c] = mesh.triangles()[t];
                if (std::max({a, b, c}) >= n) continue;
                const auto root = piece[a];
                visit_points({place(a), place(b), place(c)},
                             [&](const Vec3& at) { vote(root, at); });
            }
        }
    });
    std::vector<Vote> votes;
    for (const auto& some : found) votes.insert(votes.end(), some.begin(), some.end());
    std::vector<std::size_t> taken(size_.size(), 0);
    std::vector<std::uint32_t> body_of(n, no_index);  // of the first vertex of each piece
    const std::vector<Held> held = counted(votes);
    for (std::size_t i = 0, end = 0; i < held.size(); i = end) {
        while (end < held.size() && held[end].piece == held[i].piece) ++end;
        const auto rank = [&](const Held& h) {
            return std::tuple(std::numeric_limits<std::size_t>::max() - h.points, size_[h.body],
                              taken[h.body], h.body);
        };
        const auto best =
            std::min_element(held.begin() + std::ptrdiff_t(i), held.begin() + std::ptrdiff_t(end),
                             [&](const Held& a, const Held& b) { return rank(a) < rank(b); });
        body_of[best->piece] = best->body;
        ++taken[best->body];
    }
    std::vector<std::uint32_t> out(n, no_index);
    for (std::size_t v = 0; v < n; ++v) {
        if (piece[v] != no_index) out[v] = body_of[piece[v]];
    }
    return out;
}

std::uint32_t BodyFinder::holder(const Vec3& at, std::uint32_t body) const
{
    // A place on a face is of what holds the quarter above it, or else of its own cell.
    using Rank = std::tuple<double, bool, bool>;
    Rank best_rank{std::numeric_limits<double>::infinity(), true, true};
    std::uint32_t best = no_index;
    visit_holders(at, [&](std::uint32_t c, double d_sq) {
        if (body_[c] != body) return;
        const Vec3 in = at - cubes_->cell[c].cast<double>();
        const bool own = in.minCoeff() >= 0 && in.maxCoeff() < 1;
        const Rank rank{d_sq, !own, !quarters_hold(cubes_->part[c], in)};
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
