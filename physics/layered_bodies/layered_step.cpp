#include "physics/layered_bodies/layered_step.hpp"

#include "geometry/base/stop.hpp"
#include "physics/body/external_forces.hpp"
#include "physics/body/following_forces.hpp"
#include "physics/layered_bodies/inner_motion.hpp"
#include "physics/layered_bodies/layered_bullet.hpp"
#include "physics/layered_bodies/layered_fall.hpp"
#include "physics/layered_bodies/layered_forces.hpp"
#include "physics/layered_bodies/layered_loads.hpp"
#include "physics/layered_bodies/layered_motion.hpp"
#include "physics/layered_bodies/layered_solve.hpp"
#include "physics/layered_bodies/layered_volume.hpp"
#include "physics/layered_bodies/net_base.hpp"
#include "physics/layered_bodies/step_length.hpp"
#include "physics/layered_bodies/substance_parts.hpp"
#include "physics/state/pins.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace physics {

// Turns cubes about the middle of them.
static void spin_up_cubes(const LayeredBody& body, const Vec3& spin, LayeredState& state)
{
    if (spin.isZero(0)) return;
    const auto& cubes = body.base.cubes->source().cubes.corners;
    Vec3 centre = Vec3::Zero();
    for (const auto& corners : cubes) {
        for (const std::uint32_t k : corners) centre += state.cubes.x[k];
    }
    centre /= static_cast<double>(8 * cubes.size());
    for (std::size_t k = 0; k < state.cubes.x.size(); ++k) {
        state.cubes.v[k] += spin.cross(state.cubes.x[k] - centre);
    }
}

static void keep_held(const LayeredPart& part, LayeredState& state)
{
    if (part.held.empty()) return;
    const std::vector<Transform> told = told_frames(part);
    for (const HeldFrame& held : part.held) {
        const Transform& at = told[held.frame];
        state.position[held.frame] = at.translation() + held.way;
        state.rotation[held.frame] = Eigen::Quaterniond(at.linear()).normalized().coeffs();
    }
}

static LayeredState start(const LayeredPart& part)
{
    const LayeredBody& body = *part.body;
    LayeredState state;
    const std::vector<Transform> at = told_frames(part);
    for (const Transform& frame : at) {
        state.position.push_back(frame.translation());
        state.rotation.push_back(Eigen::Quaterniond(frame.linear()).coeffs());
    }
    state.velocity = first_velocities(part, at);
    const bool turns = body.base.kind == BaseKind::rigid;
    state.spin.assign(body.base.frames.size(), turns ? part.spin : Vec3::Zero());
    if (body.base.cubes) {
        state.cubes = rest_state(body.base.cubes->bricks());
        for (Vec3& x : state.cubes.x) x = part.pose * x;
        state.cubes.v.assign(state.cubes.x.size(), part.velocity);
        spin_up_cubes(body, part.spin, state);
        follow_cubes(body, state);
    }
    keep_held(part, state);
    follow_masses(body, state);
    state.translation.assign(body.layer.skeletons.size(), 0);
    state.part = body.layer.blend.part;
    if (state.part.empty() && body.layer.blend.rule != geometry::BlendRule::sum) {
        state.part.resize(body.layer.skeletons.size());
        std::iota(state.part.begin(), state.part.end(), 0u);
    }
    state.links = body.layer.blend.links;
    return state;
}

LayeredScene start(std::vector<LayeredPart> parts)
{
    LayeredScene scene;
    for (const LayeredPart& part : parts) scene.states.push_back(start(part));
    scene.parts = std::move(parts);
    settle_volumes(scene, 0);
    return scene;
}

void check_rigid_bodies(std::span<const LayeredPart> parts, RigidBodies rigid_bodies)
{
    if (rigid_bodies == RigidBodies::implicit) return;
    for (std::size_t b = 0; b < parts.size(); ++b) {
        if (!parts[b].held.empty()) {
            throw std::invalid_argument(fmt::format(
                "rigid_bodies = bullet can't hold frames, but body {} has pins. Set rigid_bodies "
                "to implicit, or hold the body by a joint with the world (Figure, a = -1).",
                b));
        }
        const BaseKind kind = parts[b].body->base.kind;
        if (kind == BaseKind::rigid || kind == BaseKind::still) continue;
        throw std::invalid_argument(fmt::format(
            "rigid_bodies = bullet supports rigid and still bodies only; body {} is {}. Set "
            "rigid_bodies to implicit, or move that body in a Layered node of its own.",
            b,
            kind == BaseKind::particles ? "made of particles"
            : kind == BaseKind::net     ? "a net"
                                        : "carried by cubes"));
    }
}

namespace {

// A frame of the film, that starts as `scene` is and ends as `told`.
struct FilmFrame {
    const LayeredScene& scene;
    const std::vector<LayeredPart>& told;
    const LayeredWorld& world;
    double dt;
    double asked;  // s, longest step
    Vec3 fall;     // m/s^2, by weight

    LayeredScene begin() const
    {
        LayeredScene now{told, scene.states};
        for (std::size_t b = 0; b < now.states.size(); ++b) {
            LayeredState& state = now.states[b];
            state.report = {};
            state.penetration = 0;
            // A mesh that moves is sampled anew: the walk of each sample begins at its skeleton.
            if (state.distance.size() == told[b].body->samples.count()) continue;
            state.distance.clear();
            state.pressed.clear();
        }
        return now;
    }
};

// What is seen of all bodies in a step, and what their controllers do in it. `done`, `size`: steps.
void watch(const FilmFrame& frame, const LayeredMoment& moment, double done, double size, int steps,
           LayeredScene& now)
{
    const double h = frame.dt / steps * size;
    for (std::uint32_t b = 0; b < now.parts.size(); ++b) {
        const LayeredBody& body = *now.parts[b].body;
        LayeredState& state = now.states[b];
        const auto inflation = [&](double at) {
            return sought(frame.scene.parts[b], frame.told[b], at / steps);
        };
        keep_seen(moment, b, state);
        state.inflation = inflation(done);
        keep_volume(body, body.control, moment.walks[b], inflation(done + size), h, state);
        if (body.base.kind == BaseKind::particles &&
            body.layer.blend.rule != geometry::BlendRule::sum) {
            update_parts(body, b, moment, h, state);
        }
        state.time += h;
        state.report.steps += 1;
    }
}

// Volumes that nothing controls are told of the last step alone.
Drawn drawn_in(double done, double size, int steps)
{
    return done + size >= steps ? Drawn::all : Drawn::controlled;
}

void move_all(const LayeredSystem& system, const std::vector<Vec6>& dv,
              const std::vector<Vec3>& lifts, const Report& report, LayeredScene& now)
{
    for (std::size_t b = 0; b < now.parts.size(); ++b) {
        const LayeredBody& body = *now.parts[b].body;
        LayeredState& state = now.states[b];
        for (std::size_t f = 0; f < state.position.size(); ++f) {
            state.position[f] += lifts[system.frame(b, f)];
        }
        if (body.base.cubes) {
            for (std::size_t k = 0; k < state.cubes.x.size(); ++k) {
                state.cubes.x[k] += lifts[system.corner(b, k)];
            }
            state.cubes.rotation = cube_rotations(system, b);
            move_cubes(body, std::span(dv).subspan(system.corner(b, 0)), system.dt, state);
        } else {
            move(body, std::span(dv).subspan(system.frame(b, 0), state.position.size()), system.dt,
                 state);
            follow_masses(body, state);
        }
        state.report.iterations += report.iterations;
        state.report.converged &= report.converged;
    }
}

// Steps of a frame of the film, that get shorter by halves where layers bounce. `size` is of the
// step to come, `done` what is done, in steps of whole length.
class ImplicitSteps {
public:
    ImplicitSteps(const FilmFrame& frame, int steps, LayeredScene& now)
        : frame_(frame), steps_(steps), whole_(frame.dt / steps), now_(now), last_(whole_),
          changes_(std::any_of(now.parts.begin(), now.parts.end(),
                               [](const LayeredPart& part) { return part.change != nullptr; }))
    {}

    void run()
    {
        const double fast = 2 * frame_.asked * frame_.fall.norm();
        while (done_ < steps_ || (last_ > smallest * whole_ && comes_on(now_, last_, fast))) {
            geometry::stop_if_asked();
            if (!step()) break;
        }
        spent_.tell(now_.states);
    }

private:
    static constexpr double smallest = 1.0 / 64;

    // Returns whether there is more to do.
    bool step()
    {
        const double left = done_ < steps_ ? steps_ - done_ : smallest;
        size_ = left - size_ < 0.5 * smallest ? left : size_;
        if (done_ < steps_) drive_all(frame_.dt - whole_ * done_, now_);
        move_meshes(now_, frame_.scene, frame_.told, static_cast<float>(done_), steps_);
        std::optional<Seen> seen;
        look(seen);
        if (before_ && last_ > smallest * whole_ && too_deep(seen->impacts, last_)) {
            again();
            return true;
        }
        if (!(done_ < steps_)) return false;
        const double most = longest_step(seen->impacts);
        const double size = size_;
        while (0.5 * size_ >= smallest && size_ * whole_ > most) size_ *= 0.5;
        if (size_ < size && changes_) {
            look(seen);
        } else if (size_ < size) {
            seen->system = make_system(now_, seen->moment, whole_ * size_);
        }
        go(seen->moment, seen->impacts, seen->system);
        return true;
    }

    // What is seen where a step of size_ begins.
    struct Seen {
        LayeredMoment moment;
        LayeredSystem system;
        Impacts impacts;

        Seen(const ImplicitSteps& steps, Drawn drawn)
            : moment(steps.now_, steps.whole_, drawn),
              system(make_system(steps.now_, moment, steps.whole_ * steps.size_)),
              impacts(find_impacts(steps.now_, moment, system, steps.frame_.fall,
                                   {steps.frame_.asked, steps.lags()}))
        {}
    };

    void look(std::optional<Seen>& seen)
    {
        // As they are at the step's end: forces there meet what backward Euler makes of frames.
        change_shapes(frame_.told, std::min(1.0, (done_ + size_) / steps_), now_);
        seen.emplace(*this, drawn_in(done_, size_, steps_));
    }

    // Takes the last step back, to take it in four.
    void again()
    {
        careful_until_ = done_;
        now_.states = before_->states;
        done_ = before_->done;
        size_ = std::max(smallest, 0.25 * last_ / whole_);
        last_ = before_->last;
        before_.reset();
    }

    void go(const LayeredMoment& moment, Impacts& impacts, LayeredSystem& system)
    {
        before_ = Before{now_.states, done_, last_};
        system.longest = whole_;
        add_forces(now_, moment, frame_.world, impacts, system);
        const std::vector<char> lags = will_lag(now_, moment, impacts, frame_.fall, system.dt);
        add_lag(now_, lags, frame_.fall, system);
        add_radial_fields(now_, moment, frame_.world.forces,
                          half_ways(now_, lags, frame_.fall, system), system);
        aim(impacts, system);
        Report report;
        const std::vector<Vec6> dv = solve(system, report);
        spent_.take(system);
        keep(impacts, system, dv, now_);
        watch(frame_, moment, done_, size_, steps_, now_);
        move_all(system, dv, lifts(now_, lags, frame_.fall, system, dv), report, now_);
        for (std::size_t b = 0; b < lags.size(); ++b) {
            now_.states[b].lag = lags[b] != 0 ? system.dt : 0;
        }
        done_ += size_;
        last_ = system.dt;
        if (done_ >= careful_until_) size_ = std::min(1.0, 2 * size_);
    }

    std::vector<double> lags() const
    {
        std::vector<double> out;
        for (const LayeredState& state : now_.states) out.push_back(state.lag);
        return out;
    }

    struct Before {
        std::vector<LayeredState> states;
        double done = 0, last = 0;
    };

    const FilmFrame& frame_;
    int steps_;
    double whole_;  // s
    LayeredScene& now_;
    double last_;   // s, of the last step
    bool changes_;  // shapes, within a step
    double done_ = 0, size_ = 1, careful_until_ = 0;
    std::optional<Before> before_;
    SpentLayers spent_;
};

// By how much velocities differ from those that the system was made of.
std::vector<Vec6> changes(const LayeredSystem& system, const LayeredScene& now)
{
    std::vector<Vec6> dv(system.velocity.size(), Vec6::Zero());
    for (std::size_t b = 0; b < now.parts.size(); ++b) {
        const LayeredState& state = now.states[b];
        for (std::size_t f = 0; f < state.position.size(); ++f) {
            Vec6& change = dv[system.frame(b, f)];
            change << state.velocity[f], state.spin[f];
            change -= system.velocity[system.frame(b, f)];
        }
    }
    return dv;
}

// Rigid bodies by Bullet, under forces found in the middle of each step. Returns `steps`, or how
// many more to begin the frame again with: as soon as contact has become so stiff that they are too
// few, but no more than `most`. With so many it goes on: forces that are too stiff even so lose of
// their strength what they must to stay stable, and the report warns. What it leaves is looked at
// too, or the frame's last half step could come into a layer unseen and the next one's first come
// out of it, with energy made or lost: the state says how many steps it wants.
int step_with_bullet(const FilmFrame& frame, int steps, int most, LayeredScene& now)
{
    const double h = frame.dt / steps;
    BulletBodies bodies(now, frame.world);
    const auto drift = [&] {
        bodies.drift(now, 0.5 * h);
        for (std::size_t b = 0; b < now.parts.size(); ++b) {
            const LayeredBody& body = *now.parts[b].body;
            if (body.base.kind == BaseKind::still) coast(body, 0.5 * h, now.states[b]);
        }
    };
    const auto begin_again = [&](const ExplicitSteps& wanted) {
        // One step too long has gone too deep and sees too much: by threes at most.
        const double enough = std::min({1.1 * wanted.steps, 3.0 * steps, double(most)});
        return std::max(steps + 1, static_cast<int>(enough));
    };
    const std::vector<double> lag(now.parts.size(), h);  // from the middle of the last step
    ExplicitSteps hardest;
    for (int step = 0; step <= steps; ++step) {
        geometry::stop_if_asked();
        const bool end = step == steps;  // what the last half step came into, or is to come out of
        if (!end) {
            drive_all(frame.dt - h * step, now);
            drift();
        }
        const float at = static_cast<float>(step) + (end ? 0 : 0.5f);
        move_meshes(now, frame.scene, frame.told, at, steps);
        change_shapes(frame.told, static_cast<double>(at) / steps, now);
        const LayeredMoment moment(now, h, drawn_in(step, 1, steps));
        LayeredSystem system = make_system(now, moment, h, RigidBodies::bullet);
        Impacts impacts = find_impacts(now, moment, system, frame.fall, {frame.asked, lag});
        add_forces(now, moment, frame.world, impacts, system);
        add_radial_fields(now, moment, frame.world.forces, {}, system);
        const ExplicitSteps wanted = explicit_steps(now, system, frame.dt);
        if (wanted.steps > steps && steps < most) return begin_again(wanted);
        for (LayeredState& state : now.states) state.steps_per_second = 0;
        now.states[wanted.part].steps_per_second = wanted.steps / frame.dt;
        if (end) break;
        if (wanted.steps > hardest.steps) hardest = wanted;
        const double share = std::min(1.0, steps / wanted.steps);
        aim(impacts, system);
        bodies.push(now, moment, system, share * share, h);
        for (Impact& impact : impacts.all) impact.push *= share * share;
        keep(impacts, system, changes(system, now), now);
        watch(frame, moment, step, 1, steps, now);
        drift();
    }
    if (hardest.steps > steps) {
        Report& report = now.states[hardest.part].report;
        report.converged = false;
        report.warnings.push_back(fmt::format(
            "Body {} needs {:.0f} steps per frame to stay stable with Bullet, and gets {}: its "
            "contact forces were weakened. Set rigid_bodies to implicit, raise substeps, or "
            "lower the layers' stiffness.",
            hardest.part, std::ceil(hardest.steps), steps));
    }
    return steps;
}

bool same_cubes(const LayeredPart& part, const LayeredState& state)
{
    const auto& cubes = part.body->base.cubes;
    return state.cubes.x.size() == (cubes ? cubes->source().cubes.corner_count() : 0) &&
           state.cubes.v.size() == state.cubes.x.size();
}

bool same_bodies(const LayeredScene& scene, const std::vector<LayeredPart>& parts)
{
    bool same = parts.size() == scene.states.size();
    for (std::size_t b = 0; same && b < parts.size(); ++b) {
        same = parts[b].body->base.frames.size() == scene.states[b].position.size() &&
               parts[b].body->layer.skeletons.size() == scene.states[b].translation.size() &&
               told_frames(parts[b]).size() == scene.states[b].position.size() &&
               same_cubes(parts[b], scene.states[b]) &&
               (parts[b].muscle.empty() ||
                parts[b].muscle.size() == scene.states[b].translation.size()) &&
               (scene.states[b].distance.empty() || parts[b].body->base.kind == BaseKind::still ||
                scene.states[b].distance.size() == parts[b].body->samples.count());
    }
    return same;
}

// Exactly there; skeletons that had frames of their own are back in those of their body.
void keep_told(const std::vector<Transform>& at, LayeredState& state)
{
    for (auto* of_frames : {&state.position, &state.velocity, &state.spin}) {
        of_frames->resize(at.size(), Vec3::Zero());
    }
    state.rotation.resize(at.size());
    for (std::size_t f = 0; f < at.size(); ++f) {
        state.position[f] = at[f].translation();
        state.rotation[f] = Eigen::Quaterniond(at[f].linear()).normalized().coeffs();
    }
}

}  // namespace

LayeredScene advance(const LayeredScene& scene, std::vector<LayeredPart> parts,
                     const LayeredWorld& world, double dt, int substeps)
{
    for (const LayeredPart& part : parts) {
        check_pins(part.pins, part.body->base.cubes
                                  ? part.body->base.cubes->source().cubes.corner_count()
                                  : 0);
    }
    if (!same_bodies(scene, parts)) {
        throw std::invalid_argument(fmt::format(
            "the layered bodies changed between frames: a scene of {} bodies must keep its "
            "bodies, frames and skeletons, got {} bodies. A mesh that moves needs base = still",
            scene.states.size(), parts.size()));
    }
    check_rigid_bodies(parts, world.rigid_bodies);
    keep_first_poses(scene, parts);
    check_forces(world.forces);
    require_no_following(world.forces, "Layered");
    const FilmFrame frame{scene, parts, world, dt, dt / std::max(1, substeps), free_fall(world)};
    LayeredScene now = frame.begin();
    if (!(dt > 0) || now.states.empty()) return now;
    split_moved_frames(scene, dt, now);
    int steps = choose_steps(now, frame.fall, dt, std::max(1, substeps));
    if (world.rigid_bodies == RigidBodies::implicit) {
        ImplicitSteps(frame, steps, now).run();
    } else {
        const int most = std::max(steps, most_steps(std::max(1, substeps)));
        for (const LayeredState& state : now.states) {
            const double enough =
                std::min<double>(most, std::ceil(1.1 * dt * state.steps_per_second));
            steps = std::max(steps, static_cast<int>(enough));
        }
        const std::vector<LayeredState> begin = now.states;
        for (int more = step_with_bullet(frame, steps, most, now); more > steps;
             more = step_with_bullet(frame, steps, most, now)) {
            steps = more;
            now.states = begin;
        }
    }
    now.parts = frame.told;
    // Still frames end exactly where they were told to, and so do held ones.
    for (std::size_t b = 0; b < now.parts.size(); ++b) {
        keep_held(now.parts[b], now.states[b]);
        follow_masses(*now.parts[b].body, now.states[b]);
        if (now.parts[b].body->base.kind != BaseKind::still) continue;
        keep_told(told_frames(now.parts[b]), now.states[b]);
    }
    settle_volumes(now, dt);
    return now;
}

}  // namespace physics
