#include "geometry/mesh/triangulate.hpp"

namespace geometry {
namespace {

using Vec2 = Eigen::Vector2d;

// Above 0 when a, b, c turn left: twice the triangle's area.
double turn(const Vec2& a, const Vec2& b, const Vec2& c)
{
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

// The polygon's corners in the plane of its mean normal (Newell's sum of cross products), wound to
// the left. Empty when it has no normal.
std::vector<Vec2> flattened(std::span<const std::uint32_t> corner, std::span<const Vec3f> positions)
{
    const Vec3 origin = positions[corner[0]].cast<double>();
    std::vector<Vec3> p;
    for (const auto c : corner) p.push_back(positions[c].cast<double>() - origin);
    Vec3 normal = Vec3::Zero();
    for (std::size_t i = 0; i < p.size(); ++i) normal += p[i].cross(p[(i + 1) % p.size()]);
    const double length = normal.norm();
    if (!(length > 0) || !std::isfinite(length)) return {};
    normal /= length;
    const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
    std::vector<Vec2> flat;
    for (const Vec3& q : p) flat.emplace_back(q.dot(u), q.dot(v));
    return flat;
}

void fan(std::span<const std::uint32_t> corner, std::vector<Triangle>& out)
{
    for (std::size_t i = 2; i < corner.size(); ++i) {
        out.push_back({corner[0], corner[i - 1], corner[i]});
    }
}

void cut_quad(std::span<const std::uint32_t> c, const std::vector<Vec2>& p,
              std::vector<Triangle>& out)
{
    const auto inside = [&](std::size_t i) {  // whether the diagonal from corner i stays inside
        return turn(p[i], p[i + 1], p[i + 2]) > 0 && turn(p[i], p[i + 2], p[(i + 3) % 4]) > 0;
    };
    const bool from_0 = inside(0);
    const bool from_1 = turn(p[1], p[2], p[3]) > 0 && turn(p[1], p[3], p[0]) > 0;
    const bool longer = (p[2] - p[0]).squaredNorm() > (p[3] - p[1]).squaredNorm();
    if (from_1 && (!from_0 || longer)) {
        out.push_back({c[1], c[2], c[3]});
        out.push_back({c[1], c[3], c[0]});
    } else {
        fan(c, out);
    }
}

// Clips ears until a triangle is left; false, with nothing added, when it gets stuck.
bool clip_ears(std::span<const std::uint32_t> corner, const std::vector<Vec2>& p,
               std::vector<Triangle>& out)
{
    const std::size_t n = corner.size(), before = out.size();
    std::vector<std::uint32_t> next(n), previous(n);
    for (std::uint32_t i = 0; i < n; ++i) {
        next[i] = (i + 1) % static_cast<std::uint32_t>(n);
        previous[next[i]] = i;
    }
    const auto turns_right = [&](std::uint32_t i) {
        return turn(p[previous[i]], p[i], p[next[i]]) <= 0;
    };
    std::vector<std::uint32_t> reflex;  // only these can lie in an ear; some no longer are reflex
    for (std::uint32_t i = 0; i < n; ++i) {
        if (turns_right(i)) reflex.push_back(i);
    }
    if (n > 5000 && !reflex.empty()) return false;

    const auto is_ear = [&](std::uint32_t i) {
        const std::uint32_t a = previous[i], b = next[i];
        if (turn(p[a], p[i], p[b]) <= 0) return false;
        for (const auto r : reflex) {
            if (r == a || r == i || r == b || next[r] == r) continue;
            if (p[r] == p[a] || p[r] == p[i] || p[r] == p[b]) continue;
            if (turn(p[a], p[i], p[r]) >= 0 && turn(p[i], p[b], p[r]) >= 0 &&
                turn(p[b], p[a], p[r]) >= 0) {
                return false;
            }
        }
        return true;
    };
    std::size_t left = n, tried = 0;
    for (std::uint32_t i = 0; left > 3;) {
        if (!is_ear(i)) {
            i = next[i];
            if (++tried <= left) continue;
            out.resize(before);
            return false;
        }
        const std::uint32_t a = previous[i], b = next[i];
        out.push_back({corner[a], corner[i], corner[b]});
        next[a] = b;
        previous[b] = a;
        next[i] = i;  // gone
        std::erase_if(reflex, [&](std::uint32_t r) {
            return r == i || ((r == a || r == b) && !turns_right(r));
        });
        --left;
        tried = 0;
        i = next[b];  // ears from all round rather than one long fan
    }
    std::uint32_t i = 0;
    while (next[i] == i) ++i;
    out.push_back({corner[previous[i]], corner[i], corner[next[i]]});
    return true;
}

}  // namespace

void triangulate(std::span<const std::uint32_t> corner, std::span<const Vec3f> positions,
                 std::vector<Triangle>& out)
{
    if (corner.size() < 3) return;
    if (corner.size() == 3) {
        out.push_back({corner[0], corner[1], corner[2]});
        return;
    }
    for (const auto c : corner) {
        if (c >= positions.size() || !positions[c].allFinite()) return fan(corner, out);
    }
    const std::vector<Vec2> flat = flattened(corner, positions);
    if (flat.empty()) return fan(corner, out);
    if (corner.size() == 4) return cut_quad(corner, flat, out);
    if (!clip_ears(corner, flat, out)) fan(corner, out);
}

}  // namespace geometry
