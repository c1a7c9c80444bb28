#include "geometry/embed/cut_caps.hpp"

#include "geometry/base/parallel.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace geometry {
namespace {

// In a cube's plane, 0..1 each way; convex and counter-clockwise.
using Point = Eigen::Vector2d;
using Piece = std::vector<Point>;

constexpr double near = 1e-9;              // cubes: on a line, or no length
constexpr double beside = 1e-4;            // cubes: where both sides of a plane are looked at
constexpr std::size_t most_pieces = 4096;  // of one plane, whatever the mesh has there

// How far p lies to the left of the line from a to b.
double left_of(const Point& a, const Point& b, const Point& p)
{
    const Point along = b - a, to = p - a;
    return (along.x() * to.y() - along.y() * to.x()) / along.norm();
}

// Whether some of the edge lies inside the piece, and not only along its border.
bool passes(const Piece& piece, const Point& a, const Point& b)
{
    double from = 0, to = 1;
    for (std::size_t k = 0; k < piece.size(); ++k) {
        const Point &p = piece[k], &q = piece[k + 1 < piece.size() ? k + 1 : 0];
        const double at_a = left_of(p, q, a), at_b = left_of(p, q, b);
        if (at_a <= near && at_b <= near) return false;
        if (at_a < 0) from = std::max(from, at_a / (at_a - at_b));
        if (at_b < 0) to = std::min(to, at_a / (at_a - at_b));
    }
    return (to - from) * (b - a).norm() > near;
}

// The parts on both sides of the line from a to b.
void split(const Piece& piece, const Point& a, const Point& b, Piece& left, Piece& right)
{
    left.clear();
    right.clear();
    for (std::size_t k = 0; k < piece.size(); ++k) {
        const Point &p = piece[k], &q = piece[k + 1 < piece.size() ? k + 1 : 0];
        const double at_p = left_of(a, b, p), at_q = left_of(a, b, q);
        if (at_p >= -near) left.push_back(p);
        if (at_p <= near) right.push_back(p);
        if ((at_p > near && at_q < -near) || (at_p < -near && at_q > near)) {
            const Point between = p + at_p / (at_p - at_q) * (q - p);
            left.push_back(between);
            right.push_back(between);
        }
    }
}

// A step through 0 .. n - 1, over and over, that comes to all of them: near the golden section of
// n, and prime to it.
std::size_t stride_through(std::size_t n)
{
    auto stride = std::max<std::size_t>(1, std::size_t(0.618 * double(n)));
    while (std::gcd(stride, n) > 1) ++stride;
    return stride;
}

// The pieces that edges cut a convex piece into, found by the lines that have cut it so far.
class Pieces {
public:
    explicit Pieces(Piece whole) : pieces_{std::move(whole)} {}

    void cut(const Point& a, const Point& b) { cut(0, a, b); }
    const std::vector<Piece>& all() const { return pieces_; }

private:
    // A leaf, of a piece, or where that was split.
    struct Node {
        std::size_t piece = 0;
        Point a, b;
        std::size_t left = 0, right = 0;  // nodes; 0: a leaf
    };

    void cut(std::size_t at, Point a, const Point& b)
    {
        while (nodes_[at].left != 0) {
            const Node& node = nodes_[at];
            const double at_a = left_of(node.a, node.b, a), at_b = left_of(node.a, node.b, b);
            if (std::abs(at_a) <= near && std::abs(at_b) <= near) return;
            if (at_a >= -near && at_b >= -near) {
                at = node.left;
            } else if (at_a <= near && at_b <= near) {
                at = node.right;
            } else {
                const Point between = a + at_a / (at_a - at_b) * (b - a);
                const std::size_t other = at_a > 0 ? node.left : node.right;
                at = at_a > 0 ? node.right : node.left;
                cut(other, a, between);
                a = between;
            }
        }
        const std::size_t piece = nodes_[at].piece;
        if (pieces_.size() >= most_pieces || !passes(pieces_[piece], a, b)) return;
        Piece left, right;
        split(pieces_[piece], a, b, left, right);
        if (left.size() < 3 || right.size() < 3) return;
        pieces_[piece] = std::move(left);
        pieces_.push_back(std::move(right));
        nodes_[at] = {0, a, b, nodes_.size(), nodes_.size() + 1};
        nodes_.push_back({piece, {}, {}, 0, 0});
        nodes_.push_back({pieces_.size() - 1, {}, {}, 0, 0});
    }

    std::vector<Piece> pieces_;
    std::vector<Node> nodes_{1};
};

// The pieces that edges cut a rectangle into.
std::vector<Piece> pieces_of(const Point& low, const Point& high, std::span<const CutEdge> edges,
                             const Vec3& cell)
{
    Pieces pieces({low, Point(high.x(), low.y()), high, Point(low.x(), high.y())});
    // Not one beside the other, as they mostly come: lines that part much cut first.
    const std::size_t n = edges.size(), stride = stride_through(n);
    for (std::size_t k = 0, i = 0; k < n; ++k, i = (i + stride) % n) {
        const CutEdge& e = edges[i];
        const int u = (e.axis + 1) % 3, v = (e.axis + 2) % 3;
        const Point a(e.from[u] - cell[u], e.from[v] - cell[v]);
        const Point b(e.to[u] - cell[u], e.to[v] - cell[v]);
        if ((b - a).norm() > near) pieces.cut(a, b);
    }
    return pieces.all();
}

// The order of edges, by the planes they lie in.
bool by_plane(const CutEdge& a, const CutEdge& b)
{
    return std::tie(a.parted, a.axis) < std::tie(b.parted, b.axis);
}

class Capper {
public:
    Capper(const Cubes& cubes, std::span<const PartedCube> parted, std::span<const CutEdge> edges,
           const TriangleBvh& mesh)
        : cubes_(cubes), parted_(parted), edges_(edges), mesh_(mesh)
    {}

    void add(std::uint32_t parted, std::vector<Cap>& caps) const
    {
        const PartedCube& cube = parted_[parted];
        for (int d = 0; d < 3; ++d) {
            const unsigned u = 1u << (d + 1) % 3, v = 1u << (d + 2) % 3, across = 1u << d;
            bool alike = true;  // one pair of parts all over the plane
            for (const unsigned a : {u, v, u | v}) {
                alike &= cube.part[a] == cube.part[0] && cube.part[a | across] == cube.part[across];
            }
            if (alike) {
                add_between(parted, d, 0, {0, 0}, {1, 1}, caps);
                continue;
            }
            for (const unsigned a : {0u, u, v, u | v}) {
                const Point low(a & u ? 0.5 : 0, a & v ? 0.5 : 0);
                add_between(parted, d, a, low, low + Point(0.5, 0.5), caps);
            }
        }
    }

private:
    // Between this octant and the one on along d, over a rectangle of the plane between them.
    void add_between(std::uint32_t parted, int d, unsigned octant, const Point& low,
                     const Point& high, std::vector<Cap>& caps) const
    {
        const PartedCube& cube = parted_[parted];
        const std::uint8_t below = cube.part[octant], above = cube.part[octant | 1u << d];
        if (below == above) return;
        const auto [first, last] =
            std::equal_range(edges_.begin(), edges_.end(), CutEdge{parted, d, {}, {}}, by_plane);
        const Vec3 cell = cubes_.cell[cube.cube].cast<double>();
        for (const Piece& piece : pieces_of(low, high, {first, last}, cell)) {
            Cap cap{8 * parted + below, Vec3::Unit(d), {}};
            Vec3 middle = Vec3::Zero();
            for (const Point& p : piece) {
                Vec3 at = cell;
                at[(d + 1) % 3] += p.x();
                at[(d + 2) % 3] += p.y();
                at[d] += 0.5;
                cap.corners.push_back(at);
                middle += at / double(piece.size());
            }
            // A plane that a face of the mesh lies in is inside on one side only.
            const auto [under, over] = winding_beside(cubes_, mesh_, middle, d);
            if (std::abs(under) <= 0.5 || std::abs(over) <= 0.5 || under * over < 0) continue;
            Cap other{8 * parted + above, -cap.outward, {cap.corners.rbegin(), cap.corners.rend()}};
            if (under < 0) {  // the mesh is inside out
                std::swap(cap.corners, other.corners);
                std::swap(cap.outward, other.outward);
            }
            caps.push_back(std::move(cap));
            caps.push_back(std::move(other));
        }
    }

    const Cubes& cubes_;
    std::span<const PartedCube> parted_;
    std::span<const CutEdge> edges_;
    const TriangleBvh& mesh_;
};

}  // namespace

std::array<double, 2> winding_beside(const Cubes& cubes, const TriangleBvh& mesh, const Vec3& at,
                                     int axis)
{
    const auto winding = [&](double off) {
        return mesh.winding_number(cubes.origin + cubes.size * (at + off * Vec3::Unit(axis)));
    };
    return {winding(-beside), winding(beside)};
}

std::vector<Cap> find_caps(const Cubes& cubes, std::span<const PartedCube> parted,
                           std::vector<CutEdge> edges, const TriangleBvh& mesh)
{
    std::stable_sort(edges.begin(), edges.end(), by_plane);
    const Capper capper(cubes, parted, edges, mesh);
    std::vector<std::vector<Cap>> of(parted.size());
    parallel_for(parted.size(), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) capper.add(std::uint32_t(c), of[c]);
    });
    std::vector<Cap> all;
    for (auto& caps : of) {
        all.insert(all.end(), std::make_move_iterator(caps.begin()),
                   std::make_move_iterator(caps.end()));
    }
    return all;
}

}  // namespace geometry
