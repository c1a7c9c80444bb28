#include "geometry/mesh/triangle_bvh.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "geometry/mesh/on_triangle.hpp"

#include <algorithm>
#include <numbers>

namespace geometry {
namespace {

constexpr double far_factor = 3;  // a cluster of radius r seen from beyond far_factor r is far

// The sum of the winding numbers of triangles as seen from the origin. The tangent of half a solid
// angle is a ratio (Van Oosterom, Strackee. The solid angle of a plane triangle. IEEE TBME 1983):
// half angles add up where complex numbers are multiplied, and the turns of the product are
// counted, so that one arc tangent does for all triangles.
class WindingSum {
public:
    void add(const Vec3& a, const Vec3& b, const Vec3& c)
    {
        const double la = a.norm(), lb = b.norm(), lc = c.norm();
        double y = a.dot(b.cross(c));
        double x = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        if (y == 0 && x <= 0) return;  // on the triangle itself: counts neither side
        const double size = std::abs(x) + std::abs(y);
        if (!std::isfinite(size)) return;
        x /= size, y /= size;
        const double re = re_ * x - im_ * y, im = re_ * y + im_ * x;
        if (im_ >= 0 && y >= 0 && im < 0) ++turns_;
        if (im_ < 0 && y < 0 && im >= 0) --turns_;
        // Factors are 0.7 to 1 long.
        const double up = std::abs(re) + std::abs(im) < small ? 1 / small : 1;
        re_ = up * re, im_ = up * im;
    }
    double total() const { return turns_ + std::atan2(im_, re_) / (2 * std::numbers::pi); }

private:
    static constexpr double small = 1e-100;

    double re_ = 1, im_ = 0;
    int turns_ = 0;
};

Vec3 unit_or_zero(const Vec3& v)
{
    const double length = v.norm();
    return length > 0 && std::isfinite(length) ? Vec3(v / length) : Vec3(Vec3::Zero());
}

}  // namespace

TriangleBvh::TriangleBvh(const TriMesh& mesh)
{
    std::vector<Box3f> boxes;
    std::vector<std::uint32_t> kept;
    boxes.reserve(mesh.triangles().size());
    kept.reserve(mesh.triangles().size());
    for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) {
        const auto& [a, b, c] = mesh.triangles()[t];
        if (std::max({a, b, c}) >= mesh.positions.size()) continue;
        Box3f box;
        bool finite = true;
        for (const std::uint32_t v : {a, b, c}) {
            finite = finite && mesh.positions[v].allFinite();
            box.add(mesh.positions[v]);
        }
        if (!finite) continue;
        boxes.push_back(box);
        kept.push_back(t);
    }
    stop_if_asked();
    tree_ = build_box_tree(boxes);
    stop_if_asked();
    triangle_.resize(kept.size());
    corners_.resize(kept.size());
    for (std::uint32_t i = 0; i < kept.size(); ++i) {
        triangle_[i] = kept[tree_.items[i]];
        const Triangle& t = mesh.triangles()[triangle_[i]];
        for (std::size_t k = 0; k < 3; ++k) corners_[i][k] = mesh.positions[t[k]];
        tree_.items[i] = i;  // corners_ stand in leaf order already
    }
    find_normals(mesh);
    find_moments();
}

void TriangleBvh::find_normals(const TriMesh& mesh)
{
    const std::size_t n = triangle_.size();
    std::vector<Triangle> triangles(n);
    std::vector<Vec3> unit(n), at_vertex(mesh.positions.size(), Vec3::Zero());
    StopCheck check;
    for (std::size_t i = 0; i < n; ++i) {
        check();
        const std::array<Vec3, 3> p{corners_[i][0].cast<double>(), corners_[i][1].cast<double>(),
                                    corners_[i][2].cast<double>()};
        triangles[i] = mesh.triangles()[triangle_[i]];
        unit[i] = unit_or_zero((p[1] - p[0]).cross(p[2] - p[0]));
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 u = p[(k + 1) % 3] - p[k], v = p[(k + 2) % 3] - p[k];
            at_vertex[triangles[i][k]] += std::atan2(u.cross(v).norm(), u.dot(v)) * unit[i];
        }
    }
    normals_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        check();
        normals_[i].fill(unit[i].cast<float>());
        for (std::size_t k = 0; k < 3; ++k) {
            normals_[i][OnTriangle::corner_a + k] =
                unit_or_zero(at_vertex[triangles[i][k]]).cast<float>();
        }
    }
    const std::vector<EdgeUse> uses = edge_uses(triangles, mesh.positions.size());
    for (std::size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
        check();
        Vec3 sum = Vec3::Zero();
        for (; end < uses.size() && uses[end].a == uses[begin].a && uses[end].b == uses[begin].b;
             ++end) {
            sum += unit[uses[end].triangle];
        }
        const Vec3f normal = unit_or_zero(sum).cast<float>();
        for (std::size_t u = begin; u < end; ++u) {
            normals_[uses[u].triangle][OnTriangle::side_ab + uses[u].side] = normal;
        }
    }
}

void TriangleBvh::find_moments()
{
    // Children stand behind their parents, so one sweep backwards meets them first.
    moments_.resize(tree_.nodes.size());
    std::vector<double> area(tree_.nodes.size(), 0.0);
    for (std::size_t n = tree_.nodes.size(); n-- > 0;) {
        const BoxTree::Node& node = tree_.nodes[n];
        Moments& m = moments_[n];
        Vec3 weighted = Vec3::Zero();
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            const Vec3 a = corners_[i][0].cast<double>(), b = corners_[i][1].cast<double>(),
                       c = corners_[i][2].cast<double>();
            const double s = 0.5 * (b - a).cross(c - a).norm();
            area[n] += s;
            weighted += s * (a + b + c) / 3;
        }
        if (node.count == 0) {
            for (const std::uint32_t k : {node.first, node.first + 1}) {
                area[n] += area[k];
                weighted += area[k] * moments_[k].centre;
            }
        }
        const Vec3 lo = node.box.lo.cast<double>(), hi = node.box.hi.cast<double>();
        m.centre = area[n] > 0 ? Vec3(weighted / area[n]).cwiseMax(lo).cwiseMin(hi)
                               : Vec3(0.5 * (lo + hi));
        m.radius = (hi - m.centre).cwiseMax(m.centre - lo).norm();
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            const Vec3 a = corners_[i][0].cast<double>(), b = corners_[i][1].cast<double>(),
                       c = corners_[i][2].cast<double>();
            const Vec3 normal = 0.5 * (b - a).cross(c - a);
            m.dipole += normal;
            m.quadrupole += ((a + b + c) / 3 - m.centre) * normal.transpose();
        }
        if (node.count == 0) {
            for (const std::uint32_t k : {node.first, node.first + 1}) {
                m.dipole += moments_[k].dipole;
                m.quadrupole += moments_[k].quadrupole +
                                (moments_[k].centre - m.centre) * moments_[k].dipole.transpose();
            }
        }
    }
}

TriangleBvh::Hit TriangleBvh::closest(const Vec3& p, double max_distance) const
{
    Hit hit;
    if (!p.allFinite() || !(max_distance > 0)) return hit;
    double best_sq = max_distance * max_distance;
    std::uint32_t nearest = no_index;
    OnTriangle where{};
    tree_.nearest(p, best_sq, [&](std::uint32_t i, double& best) {
        const Vec3 a = corners_[i][0].cast<double>() - p, b = corners_[i][1].cast<double>() - p,
                   c = corners_[i][2].cast<double>() - p;
        const OnTriangle on = on_triangle(a, b, c);
        const double d_sq =
            (on.barycentric[0] * a + on.barycentric[1] * b + on.barycentric[2] * c).squaredNorm();
        if (d_sq < best) best = d_sq, nearest = i, where = on;
    });
    if (nearest == no_index) return hit;
    hit.distance = std::sqrt(best_sq);
    hit.triangle = triangle_[nearest];
    hit.barycentric = where.barycentric;
    for (int k = 0; k < 3; ++k) {
        hit.point +=
            where.barycentric[k] * corners_[nearest][static_cast<std::size_t>(k)].cast<double>();
    }
    hit.normal = normals_[nearest][where.feature].cast<double>();
    hit.behind = (p - hit.point).dot(hit.normal) < 0;
    return hit;
}

void TriangleBvh::closest(std::span<const Vec3> points, double max_distance,
                          std::span<Hit> hits) const
{
    parallel_for(points.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) hits[i] = closest(points[i], max_distance);
    });
}

Vec3 TriangleBvh::Motion::way(std::uint32_t triangle, const Vec3& barycentric) const
{
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
        const auto k = triangles[triangle][i];
        sum += barycentric[static_cast<Eigen::Index>(i)] * (after[k] - before[k]).cast<double>();
    }
    return sum;
}

namespace {

// A box around a segment, wider by what single precision rounds and by `more` (m).
Box3f box_along(const Vec3& from, const Vec3& to, double more = 0)
{
    Box3f box;
    for (const Vec3& p : {from, to}) {
        const float margin =
            4 * std::numeric_limits<float>::epsilon() * float(p.norm()) + float(more);
        box.add(Vec3f(p.cast<float>() - Vec3f::Constant(margin)));
        box.add(Vec3f(p.cast<float>() + Vec3f::Constant(margin)));
    }
    return box;
}

enum class Crossing : std::int8_t { out = -1, none, in, unclear };

// Where the segment that starts at `start`, seen from corner a, passes a triangle.
Crossing crossing_of(const Vec3& start, const Vec3& way, const Vec3& ab, const Vec3& ac)
{
    constexpr double near = 1e-9;  // of the way, and of the triangle's sides
    const Vec3 normal = ab.cross(ac);
    const double height = start.dot(normal), down = -way.dot(normal);
    const double rounding = near * std::abs(down), area = normal.norm();
    if (area == 0) return Crossing::none;
    if (std::min(height, height - down) > rounding || std::max(height, height - down) < -rounding) {
        return Crossing::none;
    }
    const bool needle = !(area > 1e-6 * ab.norm() * ac.norm());
    if (needle || !(std::abs(down) > 1e-9 * way.norm() * area)) return Crossing::unclear;
    const Vec3 turn = way.cross(start);  // barycentric by Cramer's rule
    const double v = -ac.dot(turn) / down, w = ab.dot(turn) / down;
    const double inside = std::min({v, w, 1 - v - w});
    if (inside < -near) return Crossing::none;
    const bool ends = std::min(std::abs(height), std::abs(height - down)) <= rounding;
    if (ends || !(inside > near)) return Crossing::unclear;
    return down > 0 ? Crossing::in : Crossing::out;
}

}  // namespace

std::vector<std::uint32_t> TriangleBvh::triangles_in(const Box3f& box) const
{
    std::vector<std::uint32_t> out;
    tree_.overlapping(box, [&](std::uint32_t i) { out.push_back(triangle_[i]); });
    std::sort(out.begin(), out.end());
    return out;
}

std::optional<int> TriangleBvh::crossings(const Vec3& from, const Vec3& to) const
{
    if (!from.allFinite() || !to.allFinite()) return std::nullopt;
    int sum = 0;
    bool clear = true;
    const Vec3 way = to - from;
    tree_.overlapping(box_along(from, to), [&](std::uint32_t i) {
        const Vec3 a = corners_[i][0].cast<double>(), ab = corners_[i][1].cast<double>() - a,
                   ac = corners_[i][2].cast<double>() - a;
        const Crossing crossing = crossing_of(from - a, way, ab, ac);
        clear &= crossing != Crossing::unclear;
        sum += static_cast<int>(crossing);
    });
    return clear ? std::optional(sum) : std::nullopt;
}

TriangleBvh::Hit TriangleBvh::entry(const Vec3& from, const Vec3& to, Faces faces,
                                    const Motion* motion) const
{
    Hit hit;
    if (!from.allFinite() || !to.allFinite()) return hit;
    double first = 1;  // share of the way
    tree_.overlapping(box_along(from, to, motion ? motion->longest : 0), [&](std::uint32_t i) {
        const Vec3 a = corners_[i][0].cast<double>(), ab = corners_[i][1].cast<double>() - a,
                   ac = corners_[i][2].cast<double>() - a;
        Vec3 start = from - a, way = to - from;  // as the triangle sees it
        if (motion) {
            const Vec3 p = a - to;
            const auto near = on_triangle(p, ab + p, ac + p).barycentric;
            const Vec3 shift = motion->way(triangle_[i], near);
            start += (1 - motion->begin) * shift;
            way -= (motion->end - motion->begin) * shift;
        }
        const Vec3 normal = ab.cross(ac);
        const double down = -way.dot(normal), height = start.dot(normal);
        const bool front = down > 0 && height >= 0 && height <= first * down;
        const bool back = faces == Faces::both && down < 0 && height < 0 && height >= first * down;
        if (!front && !back) return;
        const Vec3 turn = way.cross(start);  // barycentric by Cramer's rule
        const double v = -ac.dot(turn) / down, w = ab.dot(turn) / down;
        constexpr double rim = 1e-9;  // a segment through a side misses neither triangle
        if (v < -rim || w < -rim || v + w > 1 + rim) return;
        first = height / down;
        hit.triangle = triangle_[i];
        hit.barycentric = Vec3(1 - v - w, v, w);
        hit.normal = (front ? 1 : -1) * normal.normalized();
        hit.point = a + start + first * way;
        hit.distance = first * way.norm();
    });
    return hit;
}

double TriangleBvh::winding_number(const Vec3& p) const
{
    if (tree_.nodes.empty() || !p.allFinite()) return 0;
    double w = 0;
    WindingSum near;
    std::array<std::uint32_t, BoxTree::max_depth + 1> stack;
    int top = 0;
    stack[0] = 0;
    while (top >= 0) {
        const std::uint32_t n = stack[static_cast<std::size_t>(top--)];
        const BoxTree::Node& node = tree_.nodes[n];
        const Moments& m = moments_[n];
        const Vec3 r = m.centre - p;
        const double d_sq = r.squaredNorm();
        if (d_sq > far_factor * far_factor * m.radius * m.radius) {
            // r.n / |r|^3 and its derivative, contracted with the two moments.
            const double inv = 1 / d_sq, inv3 = inv / std::sqrt(d_sq);
            w += inv3 *
                 (m.dipole.dot(r) + m.quadrupole.trace() - 3 * inv * r.dot(m.quadrupole * r)) /
                 (4 * std::numbers::pi);
        } else if (node.count == 0) {
            stack[static_cast<std::size_t>(++top)] = node.first + 1;
            stack[static_cast<std::size_t>(++top)] = node.first;
        } else {
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
                near.add(corners_[i][0].cast<double>() - p, corners_[i][1].cast<double>() - p,
                         corners_[i][2].cast<double>() - p);
            }
        }
    }
    return w + near.total();
}

std::size_t TriangleBvh::bytes() const
{
    return tree_.nodes.capacity() * sizeof(BoxTree::Node) +
           tree_.items.capacity() * sizeof(std::uint32_t) +
           triangle_.capacity() * sizeof(std::uint32_t) +
           corners_.capacity() * sizeof(corners_[0]) + normals_.capacity() * sizeof(normals_[0]) +
           moments_.capacity() * sizeof(Moments);
}

}  // namespace geometry
