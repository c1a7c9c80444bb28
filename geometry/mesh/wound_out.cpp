#include "geometry/mesh/wound_out.hpp"

#include "geometry/base/box_tree.hpp"
#include "geometry/base/no_index.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"

#include <algorithm>
#include <array>

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

// Closed pieces, by where they are.
struct ClosedBoxes {
    explicit ClosedBoxes(const std::vector<WoundPiece>& all)
    {
        std::vector<Box3f> boxes;
        for (const WoundPiece& piece : all) {
            if (!piece.closed || piece.bounds.empty()) continue;
            pieces.push_back(&piece);
            boxes.push_back(box_of(piece));
        }
        if (!boxes.empty()) tree = build_box_tree(boxes);
    }

    std::vector<const WoundPiece*> pieces;
    BoxTree tree;
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
        const ClosedBoxes closed(pieces);
        for (const WoundPiece& piece : pieces) {
            if (piece.closed && piece.volume < 0 && !lies_in_another(piece, closed)) {
                for (const auto t : piece.triangles) turned_[t] ^= 1;
            }
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

    static bool lies_in_another(const WoundPiece& piece, const ClosedBoxes& closed)
    {
        bool found = false;
        closed.tree.overlapping(box_of(piece), [&](std::uint32_t i) {
            const Box& other = closed.pieces[i]->bounds;
            found = found || ((other.lo.array() < piece.bounds.lo.array()).all() &&
                              (other.hi.array() > piece.bounds.hi.array()).all());
        });
        return found;
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
