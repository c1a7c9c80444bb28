#include "physics/layered_bodies/layered_volume.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace physics {

static std::vector<float> pressed_distances(const LayeredMoment& moment, std::uint32_t body)
{
    const SampleWalk& walk = moment.walks[body];
    std::vector<float> pressed(walk.distance.size());
    for (std::size_t i = 0; i < pressed.size(); ++i) {
        pressed[i] = static_cast<float>(walk.valid[i] ? walk.distance[i] : -1);
    }
    for (const LayerContact& contact : moment.contacts.contacts) {
        if (contact.body == body) pressed[contact.sample] = static_cast<float>(contact.distance);
    }
    for (const DrawnSample& drawn : moment.contacts.drawn) {
        if (drawn.body == body) pressed[drawn.sample] = static_cast<float>(drawn.distance);
    }
    return pressed;
}

void keep_seen(const LayeredMoment& moment, std::uint32_t b, LayeredState& state)
{
    state.distance = moment.walks[b].distance;
    state.pressed = pressed_distances(moment, b);
    state.volume = local_volumes(moment.bodies, b, moment.contacts);
    state.penetration = std::max(state.penetration, moment.contacts.penetration[b]);
}

std::vector<double> sought(const LayeredPart& from, const LayeredPart& to, double share)
{
    std::vector<double> result;
    for (std::size_t s = 0; s < to.body->layer.skeletons.size(); ++s) {
        result.push_back(from.sought(s) + (to.sought(s) - from.sought(s)) * share);
    }
    return result;
}

void keep_volume(const LayeredBody& body, const VolumeControl& control, const SampleWalk& walk,
                 const std::vector<double>& after, double dt, LayeredState& state)
{
    if (!(control.proportional > 0)) return;
    std::vector<double> target, target_after, thickness;
    for (std::size_t s = 0; s < state.volume.size(); ++s) {
        target.push_back(state.inflation[s] * body.volume[s]);
        target_after.push_back(after[s] * body.volume[s]);
        thickness.push_back(body.layer.contributions[s].thickness);
    }
    control_volume(control,
                   {state.volume, target, target_after, walk.volume_slope, state.part, thickness},
                   dt, state.translation, state.expected_error);
}

// Warns where a body has not the volume that it seeks, with both.
static void warn_of_miss(std::size_t number, const LayeredBody& body, LayeredState& state)
{
    constexpr double tolerable = 0.005;
    if (!(volume_error(body, state) > tolerable)) return;
    double rest = 0, found = 0, wanted = 0;
    for (std::size_t s = 0; s < body.volume.size(); ++s) {
        rest += body.volume[s];
        found += state.volume[s];
        wanted += state.inflation[s] * body.volume[s];
    }
    bool at_limit = false;
    for (std::size_t s = 0; s < state.translation.size(); ++s) {
        at_limit |=
            !(std::abs(state.translation[s]) < 0.499 * body.layer.contributions[s].thickness);
    }
    state.report.warnings.push_back(fmt::format(
        "Body {} has {:.3g} times its rest volume instead of {:.3g}{}.", number, found / rest,
        wanted / rest,
        at_limit ? ": the surface moves by at most half the layer's thickness. Ask for less "
                   "inflation, or make the layer thicker"
                 : ": its contacts take more volume than volume control can give back"));
}

void settle_volumes(LayeredScene& now, double mesh_seconds)
{
    constexpr int most_rounds = 8;
    constexpr double enough = 1e-3;
    if (std::none_of(now.parts.begin(), now.parts.end(),
                     [](const LayeredPart& part) { return part.body->control.proportional > 0; })) {
        return;
    }
    for (int round = 0;; ++round) {
        const LayeredMoment moment(now, mesh_seconds);
        double worst = 0;
        for (std::uint32_t b = 0; b < now.parts.size(); ++b) {
            keep_seen(moment, b, now.states[b]);
            now.states[b].inflation = sought(now.parts[b], now.parts[b], 1);
            worst = std::max(worst, volume_error(*now.parts[b].body, now.states[b]));
        }
        if (!(worst > enough) || round == most_rounds) break;
        for (std::size_t b = 0; b < now.parts.size(); ++b) {
            if (!(volume_error(*now.parts[b].body, now.states[b]) > enough)) continue;
            constexpr double at_once = std::numeric_limits<double>::infinity();
            keep_volume(*now.parts[b].body, {at_once, 0}, moment.walks[b], now.states[b].inflation,
                        1, now.states[b]);
        }
    }
    for (std::size_t b = 0; b < now.parts.size(); ++b) {
        if (now.parts[b].body->control.proportional > 0) {
            warn_of_miss(b, *now.parts[b].body, now.states[b]);
        }
    }
}

}  // namespace physics
