#include "render/trail.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/mesh/pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <stdexcept>

namespace render {
namespace {

constexpr std::uint32_t sides = 8;
constexpr std::size_t shades = 48;  // materials from new to old

Vec3f mean_of(const Vec3& sum, std::size_t count)
{
    return (sum / double(std::max<std::size_t>(1, count))).cast<float>();
}

std::vector<Vec3f> middles_of_pieces(const TriMesh& mesh)
{
    const geometry::Pieces pieces = geometry::find_pieces(mesh);
    std::vector<Vec3> sums(pieces.count(), Vec3::Zero());
    std::vector<std::size_t> counts(pieces.count(), 0);
    std::vector<bool> seen(mesh.positions.size(), false);
    for (std::size_t f = 0; f < pieces.of.size(); ++f) {
        const std::uint32_t piece = pieces.of[f];
        if (piece == geometry::no_index) continue;
        for (const std::uint32_t v : mesh.triangles()[f]) {
            if (seen[v]) continue;
            seen[v] = true;
            sums[piece] += mesh.positions[v].cast<double>();
            ++counts[piece];
        }
    }
    std::vector<Vec3f> middles;
    for (std::size_t p = 0; p < sums.size(); ++p) middles.push_back(mean_of(sums[p], counts[p]));
    return middles;
}

[[noreturn]] void no_such_part(const geometry::MeshTopology& topology, const std::string& part)
{
    std::set<std::string> names(topology.groups.begin(), topology.groups.end());
    for (const auto& material : topology.materials) names.insert(material.name);
    std::string has;
    for (const std::string& name : names) {
        if (!name.empty()) has += (has.empty() ? "" : ", ") + name;
    }
    throw std::invalid_argument("expected the name of a material or group in `part`, found \"" +
                                part + "\"; the mesh has " + (has.empty() ? "none" : has));
}

// Whether each vertex belongs to a face of the material or group `part`.
std::vector<bool> vertices_of(const TriMesh& mesh, const std::string& part)
{
    const geometry::MeshTopology& t = *mesh.topology;
    std::vector<bool> in(mesh.positions.size(), part.empty());
    if (part.empty()) return in;
    const auto named = [&](std::size_t f) {
        const std::size_t m = t.material.empty() ? 0 : t.material[f];
        if (m < t.materials.size() && t.materials[m].name == part) return true;
        return !t.group.empty() && t.group[f] < t.groups.size() && t.groups[t.group[f]] == part;
    };
    bool some = false;
    for (std::size_t f = 0; f < t.triangles.size(); ++f) {
        if (!named(f)) continue;
        for (const std::uint32_t v : t.triangles[f]) {
            if (v < in.size()) in[v] = some = true;
        }
    }
    // What has the name and no face now, because it is hidden or torn off, has no places.
    const auto is_named = [&](const auto& material) { return material.name == part; };
    const bool known = std::any_of(t.materials.begin(), t.materials.end(), is_named) ||
                       std::find(t.groups.begin(), t.groups.end(), part) != t.groups.end();
    if (!some && !known) no_such_part(t, part);
    return in;
}

const std::vector<float>* values_of(const TriMesh& cloud, const char* name)
{
    for (const auto& a : cloud.attributes) {
        if (a.name == name && a.values.size() == cloud.positions.size()) return &a.values;
    }
    return nullptr;
}

// How many points of remember() are of one frame.
std::size_t places_in(const TriMesh& points)
{
    const auto* ages = values_of(points, "age");
    return ages ? std::size_t(std::count(ages->begin(), ages->end(), 0.0f)) : 0;
}

struct PathPoint {
    Vec3 at;
    float age, speed;  // s; m/s on the way here
};

// Of one place, newest first, without those that it stayed at.
std::vector<PathPoint> path_of(const TriMesh& points, std::size_t place, std::size_t per_frame)
{
    const auto& ages = *values_of(points, "age");
    std::vector<PathPoint> path;
    float arrived = 0;  // s, at the last of the path
    for (std::size_t end = points.positions.size(); end >= per_frame; end -= per_frame) {
        const std::size_t i = end - per_frame + place;
        const Vec3f& p = points.positions[i];
        if (!p.allFinite()) break;
        const Vec3 at = p.cast<double>();
        if (!path.empty()) {
            const double way = (at - path.back().at).norm();
            if (!(way > 1e-6 * (1e-3 + at.norm()))) {
                arrived = ages[i];
                continue;
            }
            path.back().speed = float(way) / std::max(ages[i] - arrived, 1e-9f);
        }
        arrived = ages[i];
        path.push_back({at, ages[i], 0});
    }
    if (path.size() > 1) path.back().speed = path[path.size() - 2].speed;
    return path;
}

Vec3 direction_at(const std::vector<PathPoint>& path, std::size_t i)
{
    const Vec3 in = i > 0 ? Vec3((path[i].at - path[i - 1].at).normalized()) : Vec3::Zero();
    const Vec3 out =
        i + 1 < path.size() ? Vec3((path[i + 1].at - path[i].at).normalized()) : Vec3::Zero();
    const Vec3 both = in + out;
    if (both.norm() > 1e-3) return both.normalized();
    return i > 0 ? in : out;  // it turns back
}

class Tubes {
public:
    Tubes(const TrailLook& look, float diameter) : look_(look), radius_(0.5 * double(diameter))
    {
        for (std::size_t k = 0; k < shades; ++k) {
            const double old = (double(k) + 0.5) / shades;
            const auto share = static_cast<float>(look.fade * old);
            geometry::Material m;
            m.name = "trail " + std::to_string(k + 1);
            m.colour = linear_from_srgb(Vec3f((1 - share) * srgb_from_linear(look.colour) +
                                              share * srgb_from_linear(look.pale)));
            m.opacity = static_cast<float>(1 - (1 - look.opacity) * old);
            topology_.materials.push_back(m);
        }
        mesh_.attributes = {{"age", "s", {}}, {"speed", "m/s", {}}};
    }

    void add(const std::vector<PathPoint>& path)
    {
        if (path.size() < 2) return;
        Vec3 ahead = direction_at(path, 0), side = ahead.unitOrthogonal();
        add_vertex(path[0], path[0].at);
        const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
        for (std::size_t i = 0; i < path.size(); ++i) {
            const Vec3 next = direction_at(path, i);
            side = Eigen::Quaterniond::FromTwoVectors(ahead, next) * side;
            side = (side - side.dot(next) * next).normalized();
            ahead = next;
            add_ring(path[i], side, ahead.cross(side));
            if (i > 0) join(static_cast<std::uint32_t>(i - 1), first, shade(path[i - 1], path[i]));
        }
        add_vertex(path.back(), path.back().at);
        close(first, path, shade(path.back(), path.back()));
    }

    TriMesh take()
    {
        mesh_.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology_));
        return std::move(mesh_);
    }

private:
    double old(float age) const
    {
        return look_.longest > 0 ? std::clamp(double(age) / look_.longest, 0.0, 1.0) : 0;
    }
    std::uint16_t shade(const PathPoint& a, const PathPoint& b) const
    {
        const double middle = old(0.5f * (a.age + b.age));
        return static_cast<std::uint16_t>(std::min(shades - 1, std::size_t(middle * shades)));
    }
    void add_vertex(const PathPoint& p, const Vec3& at)
    {
        mesh_.positions.push_back(at.cast<float>());
        mesh_.attributes[0].values.push_back(p.age);
        mesh_.attributes[1].values.push_back(p.speed);
    }
    void add_ring(const PathPoint& p, const Vec3& u, const Vec3& v)
    {
        const double r = radius_ * std::max(0.02, 1 - look_.taper * old(p.age));
        for (std::uint32_t k = 0; k < sides; ++k) {
            const double angle = 2 * std::numbers::pi * k / sides;
            add_vertex(p, p.at + r * (std::cos(angle) * u + std::sin(angle) * v));
        }
    }
    void add_face(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint16_t material)
    {
        topology_.triangles.push_back({a, b, c});
        topology_.material.push_back(material);
    }
    // Ring i with the next.
    void join(std::uint32_t i, std::uint32_t first, std::uint16_t material)
    {
        const std::uint32_t low = first + i * sides, high = low + sides;
        for (std::uint32_t k = 0; k < sides; ++k) {
            const std::uint32_t l = (k + 1) % sides;
            add_face(low + k, low + l, high + l, material);
            add_face(low + k, high + l, high + k, material);
        }
    }
    void close(std::uint32_t first, const std::vector<PathPoint>& path, std::uint16_t oldest)
    {
        const auto last = static_cast<std::uint32_t>(mesh_.positions.size() - 1 - sides);
        const std::uint16_t newest = shade(path[0], path[0]);
        for (std::uint32_t k = 0; k < sides; ++k) {
            const std::uint32_t l = (k + 1) % sides;
            add_face(first - 1, first + l, first + k, newest);
            add_face(last + sides, last + k, last + l, oldest);
        }
    }

    TrailLook look_;
    double radius_;
    TriMesh mesh_;
    geometry::MeshTopology topology_;
};

}  // namespace

std::vector<Vec3f> trail_places(const TriMesh& mesh, TrailOf of, int every, const std::string& part)
{
    if (of == TrailOf::pieces) return middles_of_pieces(mesh);
    std::vector<Vec3f> places;
    if (of == TrailOf::centre) {
        Vec3 sum = Vec3::Zero();
        for (const Vec3f& p : mesh.positions) sum += p.cast<double>();
        if (!mesh.positions.empty()) places.push_back(mean_of(sum, mesh.positions.size()));
        return places;
    }
    const std::vector<bool> in = vertices_of(mesh, part);
    std::size_t count = 0;
    for (std::size_t v = 0; v < in.size(); ++v) {
        if (in[v] && count++ % std::size_t(std::max(1, every)) == 0) {
            places.push_back(mesh.positions[v]);
        }
    }
    return places;
}

TriMesh remember(const TriMesh* before, std::span<const Vec3f> places, int frames,
                 double frame_seconds, float diameter)
{
    TriMesh cloud;
    cloud.attributes = {{"age", "s", {}}, {"diameter", "m", {}}};
    auto& ages = cloud.attributes[0].values;
    if (before && !places.empty() && places_in(*before) == places.size()) {
        const std::size_t had = before->positions.size() / places.size();
        const std::size_t held = std::min(had, std::size_t(std::max(0, frames)));
        cloud.positions.assign(before->positions.end() - std::ptrdiff_t(held * places.size()),
                               before->positions.end());
        for (std::size_t k = held; k > 0; --k) {  // no sum of rounding from frame to frame
            ages.insert(ages.end(), places.size(), float(double(k) * frame_seconds));
        }
        if (const auto* had_diameter = values_of(*before, "diameter")) {
            diameter = had_diameter->back();
        }
    }
    cloud.positions.insert(cloud.positions.end(), places.begin(), places.end());
    ages.resize(cloud.positions.size(), 0);
    cloud.attributes[1].values.assign(cloud.positions.size(), diameter);
    return cloud;
}

TriMesh trail_tubes(const TriMesh& points, const TrailLook& look)
{
    const auto* diameter = values_of(points, "diameter");
    const std::size_t per_frame = places_in(points);
    Tubes tubes(look, diameter && !diameter->empty() ? diameter->back() : 0);
    for (std::size_t place = 0; place < per_frame; ++place) {
        if (place % 256 == 0) geometry::stop_if_asked();
        tubes.add(path_of(points, place, per_frame));
    }
    return tubes.take();
}

}  // namespace render
