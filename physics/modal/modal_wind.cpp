#include "physics/modal/modal_wind.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/state/gusts.hpp"

#include <cmath>

namespace physics {
namespace {

using geometry::Vec3;
using geometry::Vec3f;

std::vector<Vec3> velocities(const MovingModes& modes)
{
    std::vector<Vec3> v(modes.rest.positions.size(), modes.base_velocity);
    geometry::parallel_for(v.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = 0; k < modes.shape.size(); ++k) {
            const Vec3f* const phi = modes.shape[k].data();
            for (std::size_t i = begin; i < end; ++i) {
                v[i] += modes.q_dot[k] * phi[i].cast<double>();
            }
        }
    });
    return v;
}

// On the vertices.
struct Drag {
    std::vector<Vec3> force;   // N
    std::vector<double> drag;  // N s/m
};

void add_drag(const geometry::TriMesh& mesh, const std::vector<Vec3>& v, const Force& wind,
              Drag& out)
{
    const Air air(wind);
    for (const auto& [a, b, c] : mesh.triangles()) {
        const Vec3 p = mesh.positions[a].cast<double>();
        const Vec3 area =
            0.5 *
            (mesh.positions[b].cast<double>() - p).cross(mesh.positions[c].cast<double>() - p);
        const Vec3 u = air.at(p) - (v[a] + v[b] + v[c]) / 3;
        const double flow = std::abs(area.dot(u));
        if (!std::isfinite(flow)) continue;
        const double share = 0.25 * wind.air_density * wind.drag * flow / 3;
        for (const auto i : {a, b, c}) {
            out.force[i] += share * u;
            out.drag[i] += 2 * share;  // the flow grows with u, too
        }
    }
}

}  // namespace

ModalWind wind_on_modes(const MovingModes& modes, std::span<const Force> forces)
{
    const std::size_t count = modes.shape.size();
    ModalWind out{std::vector<double>(count, 0)};
    const std::vector<Vec3> v = velocities(modes);
    Drag drag{std::vector<Vec3>(v.size(), Vec3::Zero()), std::vector<double>(v.size(), 0)};
    for (const Force& force : forces) {
        if (force.kind == Force::Kind::wind) add_drag(modes.rest, v, force, drag);
    }
    std::vector<double> rate(count, 0);
    geometry::parallel_for(count, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            for (std::size_t i = 0; i < v.size(); ++i) {
                const Vec3 phi = modes.shape[k][i].cast<double>();
                out.load[k] += phi.dot(drag.force[i]);
                rate[k] += drag.drag[i] * phi.squaredNorm();
            }
        }
    });
    for (const double r : rate)
        out.rate += r;  // the trace of a matrix without negative eigenvalues
    return out;
}

}  // namespace physics
