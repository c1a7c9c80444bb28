#include "physics/state/measure.hpp"

#include "geometry/mesh/measure.hpp"
#include "physics/state/cube_mass.hpp"
#include "physics/state/hold_matter.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <stdexcept>

namespace physics {

double largest_speed(const State& state)
{
    double largest = 0;
    for (const Vec3& v : state.v) {
        const double speed = v.norm();
        if (geometry::exceeds(speed, largest)) largest = speed;
    }
    return largest;
}

namespace {

void check_corners(const State& state, const geometry::Cubes& cubes)
{
    if (state.v.size() == cubes.corner_count()) return;
    throw std::invalid_argument(fmt::format(
        "expected a state of {} corners, found {} corners. Was it made with other cubes?",
        cubes.corner_count(), state.v.size()));
}

// M times a field, by corner.
std::vector<Vec3> times_mass(const State& state, const geometry::Cubes& cubes,
                             const std::vector<Vec3>& field)
{
    if (state.brick_mass) return brick_momenta(cubes, field);
    const std::vector<double> mass = geometry::corner_masses(cubes);
    std::vector<Vec3> out(field.size());
    for (std::size_t k = 0; k < out.size(); ++k) out[k] = mass[k] * field[k];
    return out;
}

}  // namespace

double kinetic_energy(const State& state, const geometry::Cubes& cubes)
{
    check_corners(state, cubes);
    const std::vector<Vec3> momentum = times_mass(state, cubes, state.v);
    double sum = 0;
    for (std::size_t i = 0; i < momentum.size(); ++i) sum += 0.5 * momentum[i].dot(state.v[i]);
    return sum;
}

MassMoments mass_moments(const State& state, const geometry::Cubes& cubes)
{
    check_corners(state, cubes);
    MassMoments out;
    out.mass = geometry::total_mass(cubes);
    const std::vector<Vec3> moved = times_mass(state, cubes, state.v);
    for (const Vec3& p : moved) out.momentum += p;
    for (const Vec3& p : times_mass(state, cubes, state.x)) out.centre += p;
    out.centre /= out.mass;
    std::vector<Vec3> away = state.x;
    for (Vec3& x : away) x -= out.centre;
    const std::vector<Vec3> moment = times_mass(state, cubes, away);
    geometry::Mat3 spread = geometry::Mat3::Zero();
    for (std::size_t k = 0; k < away.size(); ++k) {
        out.angular += away[k].cross(moved[k]);
        spread += away[k] * moment[k].transpose();
    }
    out.inertia = spread.trace() * geometry::Mat3::Identity() - spread;
    return out;
}

std::vector<Vec3> forces_of(const HeldMatter& matter, const std::vector<Vec3>& off)
{
    std::vector<Vec3> out(matter.corner.size(), Vec3::Zero());
    for (const HeldCube& cube : matter.cubes) {
        for (std::size_t a = 0; a < 8; ++a) {
            Vec3 sum = Vec3::Zero();
            for (std::size_t b = 0; b < 8; ++b) {
                sum += stiffness_at(cube, a, b) * off[cube.corner[b]];
            }
            for (int axis = 0; axis < 3; ++axis) {
                if ((cube.axes >> axis & 1) != 0) out[cube.corner[a]][axis] += sum[axis];
            }
        }
    }
    return out;
}

namespace {

// The axes of the world along which springs hold each of a matter's corners, as bits.
std::vector<std::uint32_t> axes_of(const HeldMatter& matter)
{
    std::vector<std::uint32_t> out(matter.corner.size(), 0);
    for (const HeldCube& cube : matter.cubes) {
        for (const auto at : cube.corner) out[at] |= cube.axes;
    }
    return out;
}

// The forces of a pin's springs in the step to a state, among those of all: its corners stand there
// as they are in the pin, one after another. Another pin may hold the same corners: to other
// targets, or along other axes, which leaves no force along these. Empty: it was not held.
std::span<const Reaction> forces_in(const State& state, const HeldMatter& matter)
{
    const std::size_t count = matter.corner.size();
    const std::span<const Reaction> all = state.held_forces;
    const bool told = state.held.size() == all.size();
    const std::vector<std::uint32_t> axes = axes_of(matter);
    std::span<const Reaction> out;
    double most = -1;
    for (std::size_t first = 0; count > 0 && first + count <= all.size(); ++first) {
        const auto own = all.subspan(first, count);
        double sum = 0;
        bool fits = true;
        for (std::size_t i = 0; i < count && fits; ++i) {
            fits = own[i].corner == matter.corner[i] &&
                   (!told || state.held[first + i] == matter.target[i]);
            for (int a = 0; a < 3; ++a) {
                fits = fits && ((axes[i] >> a & 1) != 0 || own[i].force[a] == 0);
            }
            sum += double(own[i].force.norm());
        }
        if (fits && sum > most) out = own, most = sum;
    }
    return out;
}

}  // namespace

PinForce pin_force(const State& state, const Pins* of, const Vec3& point)
{
    PinForce out;
    const auto add = [&](std::uint32_t corner, const Vec3& force) {
        out.force += force;
        out.torque += (state.x[corner] - point).cross(force);
        ++out.pins;
    };
    std::span<const Reaction> held = state.held_forces;
    if (of) held = forces_in(state, of->matter);
    for (const Reaction& one : held) add(one.corner, one.force.cast<double>());
    for (const Reaction& reaction : state.reactions) {
        Vec3 force = reaction.force.cast<double>();
        if (of) {
            const auto found =
                std::lower_bound(of->corner.begin(), of->corner.end(), reaction.corner);
            if (found == of->corner.end() || *found != reaction.corner) continue;
            const auto axes = held_axes(*of, static_cast<std::size_t>(found - of->corner.begin()));
            for (int a = 0; a < 3; ++a) {
                if ((axes >> a & 1) == 0) force[a] = 0;
            }
        }
        add(reaction.corner, force);
    }
    return out;
}

namespace {

bool has(const StateModel* model, std::uint32_t corner)
{
    if (corner == Grip::no_corner) return false;
    return !model || (corner >= model->corner && corner - model->corner < model->corners);
}

}  // namespace

Vec3 contact_force(const State& state, const ContactOf& of)
{
    Vec3 out = Vec3::Zero();
    const auto add = [&](const Grip& grip) {
        const auto [own, other] = grip.corners;
        const Vec3 force = grip.force.cast<double>();
        if (other == Grip::no_corner) {
            if (!of.another && has(of.body, own)) out += force;
            return;
        }
        if (has(of.body, own) && has(of.another, other)) out += force;
        if (has(of.body, other) && has(of.another, own)) out -= force;
    };
    for (const Grip& grip : state.holds) {  // of colliders, and behind these of solids by sheets
        const bool is_other = grip.other + 1 != static_cast<std::uint32_t>(of.collider);
        if (of.collider == 0 || !is_other) add(grip);
    }
    if (of.collider == 0) std::for_each(state.grips.begin(), state.grips.end(), add);
    return out;
}

}  // namespace physics
