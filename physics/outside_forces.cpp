#include "physics/outside_forces.hpp"

#include <cmath>
#include <stdexcept>

namespace physics {
namespace {

Vec3 at(const double* field, std::size_t slot)
{
    return Eigen::Map<const Vec3>(field + 4 * slot);
}

void add(Aligned<double>& field, std::size_t slot, const Vec3& value)
{
    for (std::size_t i = 0; i < 3; ++i) field[4 * slot + i] += value[static_cast<Eigen::Index>(i)];
}

void add_point_force(const CornerBody& body, const Force& force, Aligned<double>& f)
{
    const double radius_sq = force.radius * force.radius;
    const auto share = [&](std::size_t slot) {
        const double d_sq = (at(body.rest.data(), slot) - force.position).squaredNorm();
        const double s = d_sq < radius_sq ? 1 - d_sq / radius_sq : 0;
        return body.mass[slot] * s * s;
    };
    double total = 0;
    std::size_t nearest = 0;
    double nearest_sq = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < body.corners; ++k) {
        total += share(k);
        const double d_sq = (at(body.rest.data(), k) - force.position).squaredNorm();
        if (d_sq < nearest_sq) nearest_sq = d_sq, nearest = k;
    }
    if (total == 0) return add(f, nearest, force.force);
    for (std::size_t k = 0; k < body.corners; ++k) add(f, k, share(k) / total * force.force);
}

}  // namespace

void check_forces(std::span<const Force> forces)
{
    const auto fail = [](const char* what) {
        throw std::invalid_argument(std::string("force: ") + what);
    };
    for (const Force& f : forces) {
        if (!f.acceleration.allFinite()) fail("expected a finite acceleration");
        if (!f.velocity.allFinite()) fail("expected a finite wind velocity");
        if (!f.force.allFinite() || !f.position.allFinite()) {
            fail("expected a finite force and position");
        }
        if (!(std::isfinite(f.radius) && f.radius >= 0)) fail("expected a radius of at least 0 m");
        if (!(std::isfinite(f.air_density) && f.air_density >= 0 && std::isfinite(f.drag) &&
              f.drag >= 0)) {
            fail("expected an air density and a drag coefficient of at least 0");
        }
    }
}

void add_steady_forces(const CornerBody& body, std::span<const Force> forces, Aligned<double>& f)
{
    for (const Force& force : forces) {
        if (force.kind == Force::Kind::gravity) {
            for (std::size_t k = 0; k < body.corners; ++k) {
                add(f, k, body.mass[k] * force.acceleration);
            }
        } else if (force.kind == Force::Kind::point) {
            add_point_force(body, force, f);
        }
    }
}

void add_wind(const CornerBody& body, std::span<const Force> forces, const double* x,
              const double* v, Aligned<double>& f, Aligned<double>& drag)
{
    const Skin& skin = body.skin;
    for (const Force& wind : forces) {
        if (wind.kind != Force::Kind::wind) continue;
        for (std::size_t c = 0; c < skin.corners.size(); ++c) {
            if (skin.area_at[c] == skin.area_at[c + 1]) continue;
            // Columns of the mean deformation gradient; area turns and stretches by its cofactors.
            Vec3 column[3] = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
            Vec3 speed = Vec3::Zero();
            for (unsigned a = 0; a < 8; ++a) {
                const Vec3 p = at(x, skin.corners[c][a]) / (4 * body.h);
                for (unsigned j = 0; j < 3; ++j) column[j] += (a >> j & 1) ? p : Vec3(-p);
                speed += double(skin.share[c][a]) * at(v, skin.corners[c][a]);
            }
            const Vec3 u = wind.velocity - speed;
            const Vec3f seen =
                Vec3(column[1].cross(column[2]).dot(u), column[2].cross(column[0]).dot(u),
                     column[0].cross(column[1]).dot(u))
                    .cast<float>();
            double flow = 0;  // m^3/s
            for (auto i = skin.area_at[c]; i < skin.area_at[c + 1]; ++i) {
                flow += static_cast<double>(std::abs(skin.area[i].dot(seen)));
            }
            const double resistance = 0.25 * wind.air_density * wind.drag * flow;
            for (std::size_t a = 0; a < 8; ++a) {
                const double part = resistance * double(skin.share[c][a]);
                const std::size_t k = skin.corners[c][a];
                add(f, k, part * wind.velocity);
                add(drag, k, Vec3::Constant(part));
            }
        }
    }
}

}  // namespace physics
