#include "physics/bricks/free_fall.hpp"

#include "physics/bricks/free_parts.hpp"
#include "physics/bricks/stage_touches.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

// What each part would gain of velocity as a whole in the stage; 0 along axes that hold it.
std::vector<Vec3> gained_by_parts(const Stage& stage, const std::vector<std::uint8_t>& held)
{
    const StepFrame& frame = stage.frame;
    const CornerBody& body = frame.body;
    std::vector<Vec3> out(body.parts, Vec3::Zero());
    std::vector<Vec3> inertia(body.parts, Vec3::Zero());  // kg
    for (std::size_t k = 0; k < body.corners; ++k) {
        const std::size_t part = body.part_of(k);
        for (std::size_t i = 4 * k, a = 0; a < 3; ++i, ++a) {
            const double drag = frame.damping[i] + stage.drag[i];
            const auto axis = static_cast<Eigen::Index>(a);
            out[part][axis] += stage.tau * (frame.steady[i] + stage.wind[i] - drag * stage.v0[i]);
            inertia[part][axis] += frame.mass[i] + stage.tau * drag;
        }
    }
    for (std::size_t p = 0; p < body.parts; ++p) {
        for (Eigen::Index a = 0; a < 3; ++a) {
            const double gained = out[p][a] / inertia[p][a];
            out[p][a] = (held[p] >> a & 1) == 0 && std::isfinite(gained) ? gained : 0;
        }
    }
    return out;
}

// Parts that would touch something where these velocities lead.
std::vector<std::uint8_t> met_by(Stage& stage, const std::vector<Vec3>& gained)
{
    const CornerBody& body = stage.frame.body;
    std::vector<std::uint8_t> out(body.parts, 0);
    const auto falls = [&](const PartPair& pair) {
        return !gained[pair.a].isZero(0) || !gained[pair.b].isZero(0);
    };
    if (!body.sheets && stage.colliders.empty() &&
        std::none_of(stage.near.begin(), stage.near.end(), falls)) {
        return out;
    }
    Aligned<double> w = stage.w;
    for (std::size_t k = 0; k < body.corners; ++k) {
        Eigen::Map<Vec3>(&w[4 * k]) += gained[body.part_of(k)];
    }
    for (const PointContact& c : contacts_ahead(stage, w)) {
        for (std::size_t a = 0; a < c.count; a += 8) out[body.part_of(c.corners[a])] = 1;
    }
    return out;
}

}  // namespace

void lift_free_parts(Stage& stage)
{
    stage.lifted.clear();
    if (!stage.turns_start) return;
    const CornerBody& body = stage.frame.body;
    const std::vector<Vec3> gained = gained_by_parts(stage, held_parts(stage));
    if (std::all_of(gained.begin(), gained.end(), [](const Vec3& v) { return v.isZero(0); })) {
        return;
    }
    const std::vector<std::uint8_t> meets = met_by(stage, gained);
    if (std::all_of(meets.begin(), meets.end(), [](auto m) { return m != 0; })) return;
    stage.lifted.assign(stage.frame.n, 0);
    for (std::size_t k = 0; k < body.corners; ++k) {
        const std::size_t part = body.part_of(k);
        if (meets[part] != 0) continue;
        const Vec3 by = -0.5 * stage.tau * gained[part];
        Eigen::Map<Vec3>(&stage.lifted[4 * k]) = by;
        Eigen::Map<Vec3>(&stage.x0[4 * k]) += by;
    }
}

}  // namespace physics
