#include "physics/modal/vibrate.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/embed/embed.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/body/following_forces.hpp"
#include "physics/math/mark.hpp"
#include "physics/modal/modal_contact.hpp"
#include "physics/modal/modal_wind.hpp"
#include "physics/modal/oscillator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace physics {

namespace {

using geometry::TriMesh;

// Sum over modes of q_k times field k, at entries begin .. end: adds to `out`.
void add_modes(const std::vector<std::vector<Vec3f>>& fields, const std::vector<double>& q,
               double factor, std::size_t begin, std::size_t end, Vec3f* out)
{
    for (std::size_t k = 0; k < fields.size(); ++k) {
        const float weight = float(factor * q[k]);
        const Vec3f* const field = fields[k].data();
        for (std::size_t i = begin; i < end; ++i) out[i] += weight * field[i];
    }
}

// Weights of vertices around a place, summing to one: (1 - (d / radius)^2)^2, or the nearest
// vertex.
std::vector<std::pair<std::uint32_t, double>> around(const TriMesh& mesh, const Vec3& place,
                                                     double radius)
{
    std::vector<std::pair<std::uint32_t, double>> weights;
    double total = 0, nearest_sq = std::numeric_limits<double>::infinity();
    std::uint32_t nearest = 0;
    for (std::uint32_t i = 0; i < mesh.positions.size(); ++i) {
        const double d_sq = (mesh.positions[i].cast<double>() - place).squaredNorm();
        if (d_sq < nearest_sq) nearest_sq = d_sq, nearest = i;
        if (d_sq < radius * radius) {
            const double s = 1 - d_sq / (radius * radius);
            weights.emplace_back(i, s * s);
            total += s * s;
        }
    }
    if (weights.empty()) return {{nearest, 1.0}};
    for (auto& [vertex, weight] : weights) weight /= total;
    return weights;
}

// What a force or impulse at a place is to each mode: phi . F there.
void add_to_modes(const ModalModel& model, const Vec3& place, double radius, const Vec3& force,
                  std::vector<double>& modal)
{
    if (model.rest->positions.empty()) return;
    const auto weights = around(*model.rest, place, radius);
    for (std::size_t k = 0; k < model.count(); ++k) {
        for (const auto& [vertex, weight] : weights) {
            modal[k] += weight * model.shape[k][vertex].cast<double>().dot(force);
        }
    }
}

double damping_of(const ModalModel& model, std::size_t k, const ModalDamping& damping)
{
    switch (damping.kind) {
    case ModalDamping::Kind::material:
        return model.damping[k];
    case ModalDamping::Kind::ratio:
        return 2 * damping.ratio * std::sqrt(model.omega_sq[k]);
    case ModalDamping::Kind::rayleigh:
        return damping.mass_damping + damping.stiffness_damping * model.omega_sq[k];
    }
    throw std::logic_error("unknown kind of modal damping");
}

void check(const ModalModel& model, const ModalState& state)
{
    if (state.q.size() != model.count() || state.q_dot.size() != model.count()) {
        throw std::invalid_argument(fmt::format(
            "expected a state of {} modes, found {} modes. Does it belong to another model?",
            model.count(), state.q.size()));
    }
    if (state.mark == model.mark) return;
    throw std::invalid_argument(
        "the modes are others than those whose coordinates the state holds: what modes are made "
        "from (cubes, mesh, pins) must be the same in all frames. `on` of Pin, which lets go of a "
        "body, is for Simulate");
}

void step_modes(const ModalModel& model, std::span<const double> load, const ModalDamping& damping,
                double dt, ModalState& state)
{
    for (std::size_t k = 0; k < model.count(); ++k) {
        oscillator_step(model.omega_sq[k], damping_of(model, k, damping), dt)
            .apply(state.q[k], state.q_dot[k], load[k]);
    }
}

void require_no_radial(std::span<const Force> forces)
{
    const auto radial = [](const Force& f) { return f.kind == Force::Kind::radial; };
    if (std::none_of(forces.begin(), forces.end(), radial)) return;
    throw std::invalid_argument(
        "Vibrate takes no radial force: use a point force or gravity, or Simulate");
}

struct WindyStep {
    std::span<const Force> forces;
    const Vec3& base_velocity;        // m/s
    const std::vector<double>& load;  // of all but the wind
};

// Into how many parts to cut `left` seconds, so short that the air's drag, as it is at the start of
// each, can't turn motion around. Throws std::invalid_argument where they are too many.
double parts_in_wind(const ModalWind& wind, double left, double dt)
{
    constexpr double most = 1000;
    constexpr double share = 0.25;  // of the motion that a part may lose
    const double parts = std::max(1.0, std::ceil(left * wind.rate / share));
    if (parts <= most) return parts;
    throw std::invalid_argument(fmt::format(
        "the wind moves so light a mesh within {:.1g} s, too fast for frames of {:.3g} s. "
        "Check the density of the cubes, the wind's velocity and the air's density",
        1 / wind.rate, dt));
}

void step_in_wind(const ModalModel& model, const WindyStep& step, const ModalDamping& damping,
                  double dt, ModalState& state)
{
    for (double left = dt; left > 0;) {
        geometry::stop_if_asked();
        ModalWind wind =
            wind_on_modes({*model.rest, model.shape, state.q_dot, step.base_velocity}, step.forces);
        const double parts = parts_in_wind(wind, left, dt);
        for (std::size_t k = 0; k < model.count(); ++k) wind.load[k] += step.load[k];
        step_modes(model, wind.load, damping, left / parts, state);
        left = parts > 1 ? left - left / parts : 0;
    }
}

// Of all but the wind.
std::vector<double> load_of(const ModalModel& model, std::span<const Force> forces)
{
    std::vector<double> load(model.count(), 0);
    for (const Force& f : forces) {
        switch (f.kind) {
        case Force::Kind::gravity:
            for (std::size_t k = 0; k < model.count(); ++k) {
                load[k] += model.participation[k].dot(f.acceleration);
            }
            break;
        case Force::Kind::point:
            add_to_modes(model, f.position, f.radius, f.force, load);
            break;
        case Force::Kind::wind:  // step_in_wind()
        case Force::Kind::torque:
        case Force::Kind::radial:
        case Force::Kind::pressure:
            break;  // refused
        }
    }
    return load;
}

struct StoppedStep {
    const ModalLoads& loads;
    bool windy;
    const Vec3& base_velocity;        // m/s
    const std::vector<double>& load;  // of all but the wind
};

// In parts, in each of which the wind is as at its start.
void step_between_colliders(const ModalModel& model, const StoppedStep& step,
                            const ModalDamping& damping, double dt, ModalState& state)
{
    std::vector<double> rate;
    for (std::size_t k = 0; k < model.count(); ++k) rate.push_back(damping_of(model, k, damping));
    const double longest = dt / contact_steps(model.omega_sq, dt);
    for (double left = dt; left > 0;) {
        geometry::stop_if_asked();
        std::vector<double> load = step.load;
        double h = left > 1.001 * longest ? longest : left;
        if (step.windy) {
            const ModalWind wind = wind_on_modes(
                {*model.rest, model.shape, state.q_dot, step.base_velocity}, step.loads.forces);
            for (std::size_t k = 0; k < load.size(); ++k) load[k] += wind.load[k];
            h = std::min(h, left / parts_in_wind(wind, left, dt));
        }
        left = h < left ? left - h : 0;
        step_on_colliders({*model.rest, model.shape, model.omega_sq, rate},
                          {step.loads.colliders, dt, 1 - left / dt,
                           step.loads.base - left * step.base_velocity, h * step.base_velocity,
                           load, h, !(state.time > 0)},
                          state.q, state.q_dot);
    }
}

}  // namespace

std::uint64_t mark_of(const ModalModel& model)
{
    Mark mark;
    for (const double omega_sq : model.omega_sq) mark.add(omega_sq);
    for (const auto& shape : model.shape) {
        for (const Vec3f& moved : shape) {
            for (const float x : moved) mark.add(x);
        }
    }
    return mark.value();
}

ModalModel make_modal_model(const Modes& modes, const geometry::Cubes& cubes,
                            std::shared_ptr<const TriMesh> mesh)
{
    const geometry::Binding binding = geometry::bind(*mesh, cubes);
    const std::vector<double> mass = geometry::corner_masses(cubes);
    const std::vector<Vec3> rest = geometry::corner_positions(cubes);
    ModalModel model;
    model.omega_sq = modes.omega_sq;
    model.damping = modes.damping;
    model.warnings = modes.report.warnings;
    const std::string strays = geometry::warning_of_strays(binding);
    if (!strays.empty()) model.warnings.push_back(strays);
    for (const auto& phi : modes.shape) {
        Vec3 participation = Vec3::Zero();
        double largest = 0;
        for (std::size_t i = 0; i < phi.size(); ++i) {
            participation += mass[i] * phi[i];
            largest = std::max(largest, phi[i].norm());
        }
        model.participation.push_back(participation);

        model.shape.push_back(geometry::carried_vectors(binding, cubes, phi));

        // Normals as they change when the mode moves corners by a hundredth of a cube.
        const double small = largest > 0 ? 0.01 * cubes.size / largest : 0;
        std::vector<Vec3> moved = rest;
        for (std::size_t i = 0; i < phi.size(); ++i) moved[i] += small * phi[i];
        std::vector<Vec3f> change = geometry::embed(binding, *mesh, cubes, moved).normals;
        for (std::size_t i = 0; i < change.size(); ++i) {
            change[i] = small > 0 ? Vec3f((change[i] - mesh->normals[i]) / float(small))
                                  : Vec3f(Vec3f::Zero());
        }
        model.normal_change.push_back(std::move(change));
    }
    model.rest = std::move(mesh);
    model.mark = mark_of(model);
    return model;
}

ModalState rest_state(const ModalModel& model)
{
    ModalState state;
    state.q.assign(model.count(), 0);
    state.q_dot.assign(model.count(), 0);
    state.mark = model.mark;
    return state;
}

ModalState advance(const ModalModel& model, ModalState state, const ModalLoads& loads,
                   const ModalDamping& damping, double dt)
{
    check(model, state);
    if (!(dt > 0) || !std::isfinite(dt)) {
        throw std::invalid_argument(fmt::format("expected a step above 0 s, found {}", dt));
    }
    require_no_following(loads.forces, "Vibrate");
    require_no_radial(loads.forces);
    const std::vector<double> load = load_of(model, loads.forces);
    const Vec3 base_velocity = (loads.base - state.base) / dt;
    for (std::size_t k = 0; k < model.count(); ++k) {
        state.q_dot[k] -= model.participation[k].dot(base_velocity - state.base_velocity);
    }
    const bool windy = std::any_of(loads.forces.begin(), loads.forces.end(),
                                   [](const Force& f) { return f.kind == Force::Kind::wind; });
    if (!loads.colliders.empty()) {
        step_between_colliders(model, {loads, windy, base_velocity, load}, damping, dt, state);
    } else if (windy) {
        step_in_wind(model, {loads.forces, base_velocity, load}, damping, dt, state);
    } else {
        step_modes(model, load, damping, dt, state);
    }
    state.base = loads.base;
    state.base_velocity = base_velocity;
    state.time += dt;
    return state;
}

ModalState struck(const ModalModel& model, ModalState state, const Kick& kick)
{
    check(model, state);
    add_to_modes(model, kick.position, kick.radius, kick.impulse, state.q_dot);
    return state;
}

TriMesh deformed(const ModalModel& model, const ModalState& state, double amplitude)
{
    check(model, state);
    TriMesh mesh = *model.rest;
    const std::size_t n = mesh.positions.size();
    geometry::Attribute displacement{"displacement", "m", std::vector<float>(n)};
    geometry::Attribute speed{"speed", "m/s", std::vector<float>(n)};
    std::vector<Vec3f> velocity(n, state.base_velocity.cast<float>());
    const Vec3f base = state.base.cast<float>();
    constexpr std::size_t grain = 1024;  // vertices whose sums stay in the first-level cache
    geometry::parallel_for((n + grain - 1) / grain, 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t piece = first; piece < last; ++piece) {
            const std::size_t begin = piece * grain, end = std::min(n, begin + grain);
            std::vector<Vec3f> moved(end - begin, base);
            for (std::size_t k = 0; k < model.count(); ++k) {
                const float q = float(amplitude * state.q[k]);
                const Vec3f* const phi = model.shape[k].data() + begin;
                for (std::size_t i = 0; i < moved.size(); ++i) moved[i] += q * phi[i];
            }
            add_modes(model.shape, state.q_dot, amplitude, begin, end, velocity.data());
            for (std::size_t i = begin; i < end; ++i) {
                mesh.positions[i] += moved[i - begin];
                displacement.values[i] = moved[i - begin].norm();
                speed.values[i] = velocity[i].norm();
            }
        }
    });
    const std::size_t normals = mesh.normals.size();
    geometry::parallel_for(
        (normals + grain - 1) / grain, 1, [&](std::size_t first, std::size_t last) {
            const std::size_t begin = first * grain, end = std::min(normals, last * grain);
            add_modes(model.normal_change, state.q, amplitude, begin, end, mesh.normals.data());
            for (std::size_t i = begin; i < end; ++i) {
                const float length = mesh.normals[i].norm();
                mesh.normals[i] =
                    length > 0 ? Vec3f(mesh.normals[i] / length) : model.rest->normals[i];
            }
        });
    mesh.attributes.push_back(std::move(displacement));
    mesh.attributes.push_back(std::move(speed));
    return mesh;
}

double energy(const ModalModel& model, const ModalState& state)
{
    check(model, state);
    double sum = 0;
    for (std::size_t k = 0; k < model.count(); ++k) {
        sum += state.q_dot[k] * state.q_dot[k] + model.omega_sq[k] * state.q[k] * state.q[k];
    }
    return sum / 2;
}

}  // namespace physics
