#include "geometry/mesh/nested_pieces.hpp"

#include "geometry/base/box_tree.hpp"
#include "geometry/base/no_index.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/split.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

#include <algorithm>
#include <memory>

namespace geometry {
namespace {

// Looks up what lies in which piece, by meshes and trees that are made when they are asked for.
class PieceInsides {
public:
    PieceInsides(const TriMesh& mesh, const Pieces& pieces) : mesh_(mesh), pieces_(pieces) {}

    bool holds(std::uint32_t outer, std::uint32_t inner)
    {
        if (parts_.empty()) {
            parts_ = split(mesh_, pieces_.of, pieces_.count());
            trees_.resize(parts_.size());
        }
        if (!trees_[outer]) trees_[outer] = std::make_unique<TriangleBvh>(parts_[outer].mesh);
        return geometry::holds(*trees_[outer], parts_[inner].mesh.positions);
    }

private:
    const TriMesh& mesh_;
    const Pieces& pieces_;
    std::vector<SplitMesh> parts_;
    std::vector<std::unique_ptr<TriangleBvh>> trees_;
};

std::vector<Box3f> boxes_of_pieces(const TriMesh& mesh, const Pieces& pieces)
{
    std::vector<Box3f> out(pieces.count());
    for (std::size_t t = 0; t < pieces.of.size(); ++t) {
        if (pieces.of[t] == no_index) continue;
        for (const auto v : mesh.triangles()[t]) out[pieces.of[t]].add(mesh.positions[v]);
    }
    return out;
}

int way_of(double volume)
{
    return volume > 0 ? 1 : -1;
}

}  // namespace

bool holds(const TriangleBvh& outer, std::span<const Vec3f> vertices)
{
    constexpr std::size_t most = 256;
    const std::size_t step = (vertices.size() + most - 1) / most;
    for (std::size_t v = 0; v < vertices.size(); v += step) {
        if (!outer.inside(vertices[v].cast<double>())) return false;
    }
    return !vertices.empty();
}

std::vector<NestedPiece> nested_pieces(const TriMesh& mesh, const Pieces& pieces)
{
    const std::vector<Box3f> boxes = boxes_of_pieces(mesh, pieces);
    std::vector<std::uint32_t> closed;
    std::vector<Box3f> closed_boxes;
    for (std::uint32_t p = 0; p < pieces.count(); ++p) {
        if (pieces.encloses[p] == 0 || pieces.volume[p] == 0) continue;
        closed.push_back(p);
        closed_boxes.push_back(boxes[p]);
    }
    if (closed.size() < 2) return {};
    const BoxTree tree = build_box_tree(closed_boxes);
    PieceInsides insides(mesh, pieces);
    std::vector<NestedPiece> out;
    StopCheck check;
    for (const auto piece : closed) {
        check();
        std::vector<std::uint32_t> outer;
        tree.overlapping(boxes[piece], [&](std::uint32_t i) {
            const Box3f& other = boxes[closed[i]];
            if ((other.lo.array() < boxes[piece].lo.array()).all() &&
                (other.hi.array() > boxes[piece].hi.array()).all()) {
                outer.push_back(closed[i]);
            }
        });
        std::sort(outer.begin(), outer.end());
        NestedPiece nested{piece, no_index, 0, 0};
        for (const auto o : outer) {
            if (!insides.holds(o, piece)) continue;
            ++nested.depth, nested.winding += way_of(pieces.volume[o]);
            if (nested.around == no_index ||
                std::abs(pieces.volume[o]) < std::abs(pieces.volume[nested.around])) {
                nested.around = o;
            }
        }
        if (nested.depth > 0) out.push_back(nested);
    }
    return out;
}

bool is_wound_as_around(const Pieces& pieces, const NestedPiece& nested)
{
    return way_of(pieces.volume[nested.piece]) * nested.winding > 0;
}

void wind_by_parity(TriMesh& mesh)
{
    const Pieces pieces = find_pieces(mesh);
    std::vector<std::uint8_t> turned(pieces.count(), 0);
    bool any = false;
    for (const NestedPiece& nested : nested_pieces(mesh, pieces)) {
        const int wanted = nested.depth % 2 == 0 ? 1 : -1;
        turned[nested.piece] = way_of(pieces.volume[nested.piece]) != wanted;
        any = any || turned[nested.piece];
    }
    if (!any) return;
    auto topology = std::make_shared<MeshTopology>(*mesh.topology);
    for (std::size_t t = 0; t < pieces.of.size(); ++t) {
        if (pieces.of[t] == no_index || !turned[pieces.of[t]]) continue;
        std::swap(topology->triangles[t][1], topology->triangles[t][2]);
    }
    mesh.topology = std::move(topology);
}

}  // namespace geometry
