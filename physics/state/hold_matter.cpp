#include "physics/state/hold_matter.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/cubes/cube_finder.hpp"
#include "geometry/cubes/trilinear.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/state/choose_corners.hpp"
#include "physics/state/state_models.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bitset>
#include <cmath>
#include <map>
#include <stdexcept>

namespace physics {
namespace {

using geometry::Cubes;

constexpr int across = 8;  // points along a cube's edge
constexpr std::size_t points = across * across * across;
using Points = std::bitset<points>;

struct PointOfCube {
    Vec3 at;  // 0..1
    std::array<double, 8> weight;
};

std::vector<PointOfCube> points_of_cube()
{
    std::vector<PointOfCube> out;
    for (int i = 0; i < static_cast<int>(points); ++i) {
        const geometry::Vec3i place(i % across, i / across % across, i / (across * across));
        const Vec3 at = (place.cast<double>() + Vec3::Constant(0.5)) / across;
        out.push_back({at, geometry::trilinear_weights(at)});
    }
    return out;
}

// Which points of each cube are material.
class Material {
public:
    Material(const Cubes& cubes, const geometry::TriangleBvh* mesh)
        : point(points_of_cube()), cubes_(cubes), mesh_(mesh)
    {}

    Points of(std::size_t c) const
    {
        Points all;
        all.set();
        for (std::size_t q = 0; q < points && !cubes_.part.empty(); ++q) {
            all[q] = geometry::quarters_hold(cubes_.part[c], point[q].at);
        }
        if (!mesh_ || cubes_.fill[c] >= 1) return all;
        Points inside;
        for (std::size_t q = 0; q < points; ++q) inside[q] = all[q] && mesh_->inside(place(c, q));
        return inside.any() ? inside : all;
    }

    Vec3 place(std::size_t c, std::size_t q) const
    {
        return cubes_.origin + cubes_.size * (cubes_.cell[c].cast<double>() + point[q].at);
    }

    const std::vector<PointOfCube> point;

private:
    const Cubes& cubes_;
    const geometry::TriangleBvh* mesh_;
};

// What of cube c is held; nothing: a stiffness of 0.
HeldCube held_cube(const Cubes& cubes, std::uint32_t c, const Outside& outside,
                   const Material& material)
{
    HeldCube out;
    const Vec3 centre =
        cubes.origin + cubes.size * (cubes.cell[c].cast<double>() + Vec3::Constant(0.5));
    const double away = outside(centre), reach = 0.5 * std::sqrt(3.0) * cubes.size;
    if (!(away <= reach)) return out;
    const Points matter = material.of(c);
    std::array<double, 36> sum{};
    for (std::size_t q = 0; q < points; ++q) {
        if (!matter[q] || (away > -reach && !(outside(material.place(c, q)) <= 0))) continue;
        const auto& w = material.point[q].weight;
        for (std::size_t a = 0, i = 0; a < 8; ++a) {
            for (std::size_t b = 0; b <= a; ++b) sum[i++] += w[a] * w[b];
        }
    }
    // E V / h^2 of a point.
    const double each =
        held_stiffness * cubes.young[c] * cubes.size * cubes.fill[c] / double(matter.count());
    for (std::size_t i = 0; i < 36; ++i) out.stiffness[i] = static_cast<float>(each * sum[i]);
    out.cube = c;
    return out;
}

Pins pins_of(const Cubes& cubes, HeldMatter matter)
{
    Pins out;
    out.matter = std::move(matter);
    out.cubes = mark_of(cubes);
    return out;
}

}  // namespace

Outside outside_box(const geometry::Box& box)
{
    return [box](const Vec3& p) {
        const Vec3 over = (box.lo - p).cwiseMax(p - box.hi);
        return over.maxCoeff() > 0 ? over.cwiseMax(0).norm() : over.maxCoeff();
    };
}

Outside outside_sphere(const Vec3& centre, double radius)
{
    return [centre, radius](const Vec3& p) { return (p - centre).norm() - radius; };
}

Outside outside_below(double height)
{
    return [height](const Vec3& p) { return p.y() - height; };
}

Outside outside_of_material(const geometry::TriMesh& mesh, const std::string& name, double distance)
{
    auto tree = std::make_shared<const geometry::TriangleBvh>(faces_of(mesh, name));
    return [tree, distance](const Vec3& p) { return tree->closest(p).distance - distance; };
}

Outside outside_end(const Cubes& cubes, int axis, End end, int layers)
{
    double lo = 0, hi = 0;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const double at = cubes.cell[c][axis];
        lo = c == 0 ? at : std::min(lo, at);
        hi = c == 0 ? at : std::max(hi, at);
    }
    const double low = cubes.origin[axis] + cubes.size * (lo + layers);
    const double high = cubes.origin[axis] + cubes.size * (hi + 1 - layers);
    return [=](const Vec3& p) {
        if (end == End::low) return p[axis] - low;
        if (end == End::high) return high - p[axis];
        return std::min(p[axis] - low, high - p[axis]);
    };
}

HeldMatter matter_within(const Cubes& cubes, const Outside& outside,
                         const geometry::TriangleBvh* mesh, std::uint8_t axes)
{
    const Material material(cubes, mesh);
    std::vector<HeldCube> of(cubes.count());
    geometry::parallel_for(cubes.count(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            of[c] = held_cube(cubes, static_cast<std::uint32_t>(c), outside, material);
        }
    });
    HeldMatter out;
    for (HeldCube& cube : of) {
        // The last corner's own: each point has a part in it.
        if (!(cube.stiffness[35] > 0)) continue;
        cube.axes = axes;
        cube.corner = cubes.corners[cube.cube];
        out.corner.insert(out.corner.end(), cube.corner.begin(), cube.corner.end());
        out.cubes.push_back(cube);
    }
    std::sort(out.corner.begin(), out.corner.end());
    out.corner.erase(std::unique(out.corner.begin(), out.corner.end()), out.corner.end());
    for (HeldCube& cube : out.cubes) {
        for (auto& k : cube.corner) {
            const auto found = std::lower_bound(out.corner.begin(), out.corner.end(), k);
            k = static_cast<std::uint32_t>(found - out.corner.begin());
        }
    }
    return out;
}

void check_held(const geometry::Cubes& cubes, const HeldMatter& matter)
{
    for (const HeldCube& held : matter.cubes) {
        bool same = held.cube < cubes.count();
        for (std::size_t a = 0; same && a < 8; ++a) {
            same = held.corner[a] < matter.corner.size() &&
                   matter.corner[held.corner[a]] == cubes.corners[held.cube][a];
        }
        if (same) continue;
        throw std::invalid_argument(
            fmt::format("pins hold points in cubes that are not those of `cubes` (cube {} of {}): "
                        "link Pin to the node that `cubes` is linked to",
                        held.cube, cubes.count()));
    }
}

Vec3 middle_of(const HeldMatter& matter, const HeldCube& cube)
{
    // Weights sum to 1: rows of the stiffness sum to the stiffness times the corners' weights.
    Vec3 sum = Vec3::Zero();
    double whole = 0;
    for (std::size_t a = 0; a < 8; ++a) {
        for (std::size_t b = 0; b < 8; ++b) {
            sum += stiffness_at(cube, a, b) * matter.target[cube.corner[a]];
            whole += stiffness_at(cube, a, b);
        }
    }
    return sum / whole;
}

Pins matter_at(const Cubes& cubes, HeldMatter matter, const Transform& motion,
               const std::optional<Vec3>& pivot)
{
    matter.pivot.clear();
    if (pivot) matter.pivot.assign(matter.corner.size(), motion * *pivot);
    matter.target.clear();
    for (const auto k : matter.corner) matter.target.push_back(motion * cubes.corner_position(k));
    return pins_of(cubes, std::move(matter));
}

Pins matter_on(const Cubes& cubes, HeldMatter matter, const std::vector<geometry::Vec3f>& places)
{
    require_a_place_a_corner(cubes, places);
    matter.target.clear();
    for (const auto k : matter.corner) matter.target.push_back(places[k].cast<double>());
    return pins_of(cubes, std::move(matter));
}

std::vector<Vec3> targets_before(const HeldMatter& matter, const State& state)
{
    std::multimap<std::uint32_t, std::size_t> known;  // by corner, in their order
    for (std::size_t i = 0; i < std::min(state.held.size(), state.held_forces.size()); ++i) {
        known.emplace(state.held_forces[i].corner, i);
    }
    std::vector<Vec3> out;
    for (const auto k : matter.corner) {
        const auto found = known.lower_bound(k);
        if (found == known.end() || found->first != k) {
            out.push_back(state.x[k]);
        } else {
            out.push_back(state.held[found->second]);
            known.erase(found);
        }
    }
    return out;
}

}  // namespace physics
