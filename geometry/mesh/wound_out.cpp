#include "geometry/mesh/wound_out.hpp"

#include "geometry/base/box_tree.hpp"
#include "geometry/base/no_index.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "geometry/mesh/nested_pieces.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace geometry {
namespace {

// Two triangles that share an edge of no third; `agree`: they run it in opposite directions.
struct Neighbour {
    std::uint32_t triangle = no_index;
    bool agree = false;
};

struct WoundPiece {
    std::vector<std::uint32_t> triangles;
    Box bounds;
    double volume = 0;  // m^3, signed
    bool closed = true;
};

Box3f box_of(const WoundPiece& piece)
{
    return {piece.bounds.lo.cast<float>(), piece.bounds.hi.cast<float>()};
}

// The vertices that some triangles use, ascending.
std::vector<std::uint32_t> corners_in(const std::vector<Triangle>& all,
                                      const std::vector<std::uint32_t>& some)
{
    std::vector<std::uint32_t> out;
    out.reserve(3 * some.size());
    for (const auto t : some) out.insert(out.end(), all[t].begin(), all[t].end());
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

// Closed pieces, and which lies in which.
class ClosedPieces {
public:
    ClosedPieces(const TriMesh& mesh, const std::vector<WoundPiece>& all) : mesh_(mesh)
    {
        for (const WoundPiece& piece : all) {
            if (piece.closed && !piece.bounds.empty()) pieces_.push_back(&piece);
        }
        std::stable_sort(pieces_.begin(), pieces_.end(), [](const auto* a, const auto* b) {
            return std::abs(a->volume) > std::abs(b->volume);
        });
        std::vector<Box3f> boxes;
        for (const WoundPiece* piece : pieces_) boxes.push_back(box_of(*piece));
        if (!boxes.empty()) boxes_ = build_box_tree(boxes);
        trees_.resize(pieces_.size());
    }

    // Those to be turned over.
    std::vector<const WoundPiece*> turned()
    {
        std::vector<std::uint8_t> turned(pieces_.size(), 0);
        std::vector<const WoundPiece*> out;
        StopCheck check;
        for (std::uint32_t p = 0; p < pieces_.size(); ++p) {  // those around it come before
            check();
            const bool inward = pieces_[p]->volume < 0;
            std::vector<std::uint32_t> around = with_box_around(p);
            const auto is_turned = [&](std::uint32_t i) { return turned[i] != 0; };
            // Where the answer is one whatever it lies in, nothing needs to be looked up.
            if (!inward && std::none_of(around.begin(), around.end(), is_turned)) continue;
            const auto smallest = std::find_if(around.rbegin(), around.rend(),
                                               [&](std::uint32_t i) { return lies_in(p, i); });
            turned[p] = smallest == around.rend() ? inward : turned[*smallest];
            if (turned[p] != 0) out.push_back(pieces_[p]);
        }
        return out;
    }

private:
    // Larger ones, the largest first.
    std::vector<std::uint32_t> with_box_around(std::uint32_t piece) const
    {
        const Box& box = pieces_[piece]->bounds;
        std::vector<std::uint32_t> out;
        boxes_.overlapping(box_of(*pieces_[piece]), [&](std::uint32_t i) {
            const Box& other = pieces_[i]->bounds;
            if (i < piece && (other.lo.array() < box.lo.array()).all() &&
                (other.hi.array() > box.hi.array()).all()) {
                out.push_back(i);
            }
        });
        std::sort(out.begin(), out.end());
        return out;
    }

    bool lies_in(std::uint32_t piece, std::uint32_t other)
    {
        if (!trees_[other]) trees_[other] = std::make_unique<TriangleBvh>(mesh_of(other));
        std::vector<Vec3f> vertices;
        for (const auto v : corners_in(mesh_.triangles(), pieces_[piece]->triangles)) {
            if (v < mesh_.positions.size()) vertices.push_back(mesh_.positions[v]);
        }
        return holds(*trees_[other], vertices);
    }

    TriMesh mesh_of(std::uint32_t piece) const
    {
        TriMesh out;
        const auto vertices = corners_in(mesh_.triangles(), pieces_[piece]->triangles);
        for (const auto v : vertices) {
            out.positions.push_back(v < mesh_.positions.size()
                                        ? mesh_.positions[v]
                                        : Vec3f::Constant(std::numeric_limits<float>::quiet_NaN()));
        }
        auto topology = std::make_shared<MeshTopology>();
        for (const auto t : pieces_[piece]->triangles) {
            Triangle triangle = mesh_.triangles()[t];
            for (auto& v : triangle) {
                v = static_cast<std::uint32_t>(
                    std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin());
            }
            topology->triangles.push_back(triangle);
        }
        out.topology = std::move(topology);
        return out;
    }

    const TriMesh& mesh_;
    std::vector<const WoundPiece*> pieces_;  // the largest first
    BoxTree boxes_;
    std::vector<std::unique_ptr<TriangleBvh>> trees_;  // of each piece, where one was needed
};

class Winding {
public:
    explicit Winding(const TriMesh& mesh)
        : mesh_(mesh), triangles_(mesh.triangles()), next_(triangles_.size()),
          open_(triangles_.size(), 0), turned_(triangles_.size(), 0), seen_(triangles_.size(), 0)
    {
        const auto uses = edge_uses(triangles_, mesh.positions.size());
        StopCheck check;
        for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
            check();
            while (end < uses.size() && uses[end].a == uses[i].a && uses[end].b == uses[i].b) ++end;
            if (end - i == 2) {
                const auto &p = uses[i], &q = uses[i + 1];
                add_neighbour(p.triangle, {q.triangle, p.forward != q.forward});
                add_neighbour(q.triangle, {p.triangle, p.forward != q.forward});
            } else {
                for (std::size_t u = i; u < end; ++u) open_[uses[u].triangle] = 1;
            }
        }
    }

    WoundOut run()
    {
        WoundOut out;
        std::vector<WoundPiece> pieces;
        for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
            if (!seen_[t]) pieces.push_back(agreed_piece(t, out.one_way));
        }
        for (const WoundPiece* piece : ClosedPieces(mesh_, pieces).turned()) {
            for (const auto t : piece->triangles) turned_[t] ^= 1;
        }
        out.triangles = triangles_;
        for (std::size_t t = 0; t < triangles_.size(); ++t) {
            if (turned_[t] == 0) continue;
            std::swap(out.triangles[t][1], out.triangles[t][2]);
            ++out.turned;
        }
        return out;
    }

private:
    void add_neighbour(std::uint32_t triangle, const Neighbour& neighbour)
    {
        auto& next = next_[triangle];
        *std::find_if(next.begin(), next.end(),
                      [](const Neighbour& n) { return n.triangle == no_index; }) = neighbour;
    }

    Vec3 at(std::uint32_t vertex) const { return mesh_.positions[vertex].cast<double>(); }

    bool is_sound(const Triangle& t) const
    {
        return std::max({t[0], t[1], t[2]}) < mesh_.positions.size();
    }

    // What hangs together with a triangle, wound as the most of its area.
    WoundPiece agreed_piece(std::uint32_t first, std::size_t& one_way)
    {
        WoundPiece out;
        out.triangles = {first};
        seen_[first] = 1;
        double area[2] = {0, 0};
        StopCheck check;
        for (std::size_t i = 0; i < out.triangles.size(); ++i) {
            check();
            const auto t = out.triangles[i];
            out.closed &= open_[t] == 0;
            const Triangle& v = triangles_[t];
            if (is_sound(v)) {
                area[turned_[t]] += (at(v[1]) - at(v[0])).cross(at(v[2]) - at(v[0])).norm();
            }
            for (const Neighbour& n : next_[t]) {
                if (n.triangle == no_index) break;
                const auto wanted = static_cast<std::uint8_t>(turned_[t] ^ (n.agree ? 0 : 1));
                if (!seen_[n.triangle]) {
                    seen_[n.triangle] = 1;
                    turned_[n.triangle] = wanted;
                    out.triangles.push_back(n.triangle);
                } else if (turned_[n.triangle] != wanted && t < n.triangle) {
                    ++one_way;
                }
            }
        }
        for (const auto t : out.triangles) {
            if (area[1] > area[0]) turned_[t] ^= 1;
            const Triangle& v = triangles_[t];
            if (!is_sound(v)) continue;
            for (const auto k : v) out.bounds.add(at(k));
            const double volume = at(v[0]).dot(at(v[1]).cross(at(v[2]))) / 6;
            out.volume += turned_[t] != 0 ? -volume : volume;
        }
        return out;
    }

    const TriMesh& mesh_;
    const std::vector<Triangle>& triangles_;
    std::vector<std::array<Neighbour, 3>> next_;  // as many as there are, first
    std::vector<std::uint8_t> open_, turned_, seen_;
};

}  // namespace

WoundOut wound_out(const TriMesh& mesh)
{
    return Winding(mesh).run();
}

}  // namespace geometry
