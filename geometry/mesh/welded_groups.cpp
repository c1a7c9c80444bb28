#include "geometry/mesh/welded_groups.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/pieces.hpp"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

namespace geometry {
namespace {

// An edge of a face of one group in one piece, from the lower vertex to the higher or back.
struct Side {
    std::uint32_t part, low, high;
    int way;

    auto edge() const { return std::tie(part, low, high); }
};

}  // namespace

WeldedGroups find_welded_groups(const TriMesh& mesh)
{
    const std::vector<std::uint16_t>& group = mesh.topology->group;
    if (mesh.topology->groups.size() < 2 || group.empty()) return {};
    const Pieces pieces = find_pieces(mesh);
    using Part = std::pair<std::uint32_t, std::uint16_t>;  // piece, group
    std::map<Part, std::uint32_t> number;
    std::vector<std::uint32_t> piece_of;
    std::vector<Side> sides;
    for (std::size_t t = 0; t < group.size(); ++t) {
        if (pieces.of[t] == no_index) continue;
        const auto next = static_cast<std::uint32_t>(piece_of.size());
        const auto [found, is_new] = number.try_emplace({pieces.of[t], group[t]}, next);
        if (is_new) piece_of.push_back(pieces.of[t]);
        const Triangle& face = mesh.triangles()[t];
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [low, high] = std::minmax({face[k], face[(k + 1) % 3]});
            sides.push_back({found->second, low, high, face[k] == low ? 1 : -1});
        }
    }
    if (piece_of.size() == pieces.count()) return {};  // each piece is of one group
    std::sort(sides.begin(), sides.end(),
              [](const Side& a, const Side& b) { return a.edge() < b.edge(); });
    std::vector<bool> open(piece_of.size(), false);
    for (std::size_t i = 0; i < sides.size();) {
        const Side& first = sides[i];
        int sum = 0;
        for (; i < sides.size() && sides[i].edge() == first.edge(); ++i) sum += sides[i].way;
        if (sum != 0) open[first.part] = true;
    }
    std::vector<std::size_t> closed(pieces.count(), 0);
    for (std::size_t part = 0; part < piece_of.size(); ++part) {
        if (!open[part]) ++closed[piece_of[part]];
    }
    WeldedGroups out;
    for (const std::size_t n : closed) {
        if (n > 1) out.groups += n, ++out.pieces;
    }
    return out;
}

}  // namespace geometry
