#include "physics/body/external_forces.hpp"

#include "geometry/cubes/sheet.hpp"
#include "physics/body/force_shares.hpp"
#include "physics/state/gusts.hpp"
#include "physics/state/radial_force.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace physics {
namespace {

Vec3 value_at(const double* field, std::size_t slot)
{
    return Eigen::Map<const Vec3>(field + 4 * slot);
}

void add(Aligned<double>& field, std::size_t slot, const Vec3& value)
{
    for (std::size_t i = 0; i < 3; ++i) field[4 * slot + i] += value[static_cast<Eigen::Index>(i)];
}

void add_point_force(const CornerBody& body, const Force& force, Aligned<double>& f)
{
    for (const auto& [slot, share] : force_shares(body, force)) add(f, slot, share * force.force);
}

}  // namespace

void check_forces(std::span<const Force> forces)
{
    const auto fail = [](const char* what) {
        throw std::invalid_argument(std::string("force: ") + what);
    };
    const auto check = [&](const Force& f) {
        if (!f.acceleration.allFinite()) fail("expected a finite acceleration");
        if (!f.velocity.allFinite()) fail("expected a finite wind velocity");
        if (!(std::isfinite(f.gusts.speed) && f.gusts.speed >= 0)) {
            fail("expected gusts of at least 0 m/s");
        }
        if (f.gusts.speed > 0 && !(std::isfinite(f.gusts.size) && f.gusts.size > 0)) {
            fail("expected gusts of a size above 0 m");
        }
        if (!f.force.allFinite() || !f.position.allFinite()) {
            fail("expected a finite force and position");
        }
        if (!f.swirl.allFinite() || !std::isfinite(f.outward)) {
            fail("expected a finite swirl and acceleration outward");
        }
        if (!f.torque.allFinite() || !std::isfinite(f.pressure)) {
            fail("expected a finite torque and pressure");
        }
        if (!(std::isfinite(f.radius) && f.radius >= 0)) fail("expected a radius of at least 0 m");
        if (!(std::isfinite(f.air_density) && f.air_density >= 0 && std::isfinite(f.drag) &&
              f.drag >= 0)) {
            fail("expected an air density and a drag coefficient of at least 0");
        }
    };
    for (const Force& f : forces) check(f), check(f.at(0));
}

void add_steady_forces(const CornerBody& body, std::span<const Force> forces, Aligned<double>& f)
{
    for (const Force& force : forces) {
        if (force.kind == Force::Kind::gravity) {
            for (std::size_t k = 0; k < body.corners; ++k) {
                add(f, k, body.mass[k] * force.acceleration);
            }
        } else if (force.kind == Force::Kind::point && !force.follow) {
            add_point_force(body, force, f);
        }
    }
}

void add_wind(const CornerBody& body, std::span<const Force> forces, const double* x,
              const double* v, Aligned<double>& f, Aligned<double>& drag)
{
    const ContactSurface& surface = body.skin;
    for (const Force& wind : forces) {
        if (wind.kind != Force::Kind::wind) continue;
        const Air air(wind);
        surface.corners.for_each(
            0, surface.corners.size(), [&](std::size_t c, const auto& corners) {
                const SurfacePatch& patch = surface.on(c);
                if (patch.area == patch.areas_end) return;
                // Columns of the mean deformation gradient; area turns and stretches by its
                // cofactors.
                Vec3 column[3] = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
                Vec3 speed = Vec3::Zero(), place = Vec3::Zero();
                const double h = body.edge_at(corners[0]);
                for (unsigned a = 0; a < 8; ++a) {
                    const Vec3 p = value_at(x, corners[a]) / (4 * h);
                    for (unsigned j = 0; j < 3; ++j) column[j] += (a >> j & 1) ? p : Vec3(-p);
                    speed += double(patch.share[a]) * value_at(v, corners[a]);
                    place += double(patch.share[a]) * value_at(x, corners[a]);
                }
                const Vec3 blows = air.at(place), u = blows - speed;
                const Vec3f seen =
                    Vec3(column[1].cross(column[2]).dot(u), column[2].cross(column[0]).dot(u),
                         column[0].cross(column[1]).dot(u))
                        .cast<float>();
                double flow = 0;  // m^3/s
                for (auto i = patch.area; i < patch.areas_end; ++i) {
                    flow += static_cast<double>(std::abs(surface.area[i].dot(seen)));
                }
                const double resistance = 0.25 * wind.air_density * wind.drag * flow;
                for (std::size_t a = 0; a < 8; ++a) {
                    const double part = resistance * double(patch.share[a]);
                    add(f, corners[a], part * blows);
                    add(drag, corners[a], Vec3::Constant(part));
                }
            });
    }
}

void add_radial(const CornerBody& body, std::span<const Force> forces, const double* x,
                Aligned<double>& f)
{
    for (const Force& force : forces) {
        if (force.kind != Force::Kind::radial) continue;
        for (std::size_t k = 0; k < body.corners; ++k) {
            add(f, k, body.mass[k] * radial_acceleration(force, value_at(x, k)));
        }
    }
}

bool varies_by_place(const Force& force)
{
    return force.kind == Force::Kind::wind || force.kind == Force::Kind::radial;
}

// Whether a cube lies within the force's radius and a cube's diagonal.
static bool acts_near(const geometry::Cubes& cubes, const Force& force)
{
    if (cubes.is_sheet()) {
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            const Vec3 middle = geometry::cell_middle(cubes, c);
            double size = 0;
            for (const auto k : geometry::sheet_triangle(cubes, c)) {
                size = std::max(size, (cubes.place[k] - middle).norm());
            }
            if ((force.position - middle).norm() <= force.radius + 1.5 * size) return true;
        }
        return false;
    }
    const double reach = force.radius + std::sqrt(3.0) * cubes.size;
    const Vec3 at = (force.position - cubes.origin) / cubes.size;  // in cubes
    return std::any_of(cubes.cell.begin(), cubes.cell.end(), [&](const auto& cell) {
        double away_sq = 0;
        for (int d = 0; d < 3; ++d) {
            const double away = std::max({cell[d] - at[d], at[d] - cell[d] - 1, 0.0}) * cubes.size;
            away_sq += away * away;
        }
        return away_sq <= reach * reach;
    });
}

std::vector<std::string> far_forces(ModelsOfState models, std::span<const Force> forces)
{
    std::vector<std::string> out;
    for (std::size_t i = 0; i < forces.size(); ++i) {
        const Force& force = forces[i];
        const bool point = force.kind == Force::Kind::point && !force.force.isZero(0);
        if (!point) continue;
        const auto near = [&](const auto& cubes) { return acts_near(*cubes, force); };
        if (std::any_of(models.begin(), models.end(), near)) continue;
        out.push_back(fmt::format(
            "Point force {} of {} has no material within its radius: all of it acts on the corner "
            "nearest to its position. Positions are those of the rest shape; move the force there, "
            "or increase its radius.",
            i + 1, forces.size()));
    }
    return out;
}

}  // namespace physics
