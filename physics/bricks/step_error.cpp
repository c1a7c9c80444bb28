#include "physics/bricks/step_error.hpp"

#include "physics/bricks/free_parts.hpp"
#include "physics/bricks/radial_on_way.hpp"
#include "physics/math/for_numbers.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace physics {
namespace {

Vec3 corner_of(const Aligned<double>& v, std::size_t k)
{
    return {v[4 * k], v[4 * k + 1], v[4 * k + 2]};
}

// Masses and velocities alone, of each part by the masses of corners.
std::vector<RigidPart> moved_parts(const CornerBody& body, const Aligned<double>& v)
{
    std::vector<RigidPart> parts(body.parts);
    for (std::size_t k = 0; k < body.corners; ++k) {
        RigidPart& part = parts[body.part_of(k)];
        part.mass += body.mass[k];
        part.velocity += body.mass[k] * corner_of(v, k);
    }
    for (RigidPart& part : parts) part.velocity /= part.mass;
    return parts;
}

// m/s^2: by how much more radial forces accelerate each part where it begins than in the stage.
std::vector<Vec3> change_of_radial(const Stage& stage, const Aligned<double>& x0)
{
    const CornerBody& body = stage.frame.body;
    std::vector<Vec3> out(body.parts, Vec3::Zero());
    const Aligned<double> more = radial_beyond_stage(stage, x0);
    if (more.empty()) return out;
    for (std::size_t k = 0; k < body.corners; ++k) out[body.part_of(k)] += corner_of(more, k);
    for (std::size_t p = 0; p < body.parts; ++p) out[p] /= stage.frame.part_mass[p];
    return out;
}

}  // namespace

double error_of_step(const Stage& stage, const Aligned<double>& x0, const Aligned<double>& v0,
                     const Aligned<double>& x1, const Aligned<double>& v1, double dt)
{
    const CornerBody& body = stage.frame.body;
    const auto held = held_parts(stage);
    const bool any_turns =
        !stage.rigid.none() || std::find(held.begin(), held.end(), 0) != held.end();
    const auto parts = any_turns ? rigid_parts(stage, x0, v0) : moved_parts(body, v0);
    const auto ends = any_turns ? rigid_parts(stage, x1, v1) : parts;
    std::vector<std::uint8_t> turns(body.parts, 0);  // by itself
    for (std::size_t i = 0; i < stage.rigid.count(); ++i) turns[stage.rigid.part(i)] = 1;
    std::vector<Mat3> turn(body.parts, Mat3::Identity());
    for (std::size_t p = 0; p < body.parts; ++p) {
        if (held[p] == 0 || turns[p] != 0) turn[p] = turn_freely(parts[p], dt).by;
    }
    const std::vector<Vec3> change = change_of_radial(stage, x0);
    return greatest_over(body.corners, [&](std::size_t k) {
        const std::size_t p = body.part_of(k);
        const RigidPart &part = parts[p], &end = ends[p];
        Vec3 before = corner_of(v0, k) - part.velocity, after = corner_of(v1, k) - part.velocity;
        if (held[p] == 0) {
            before -= part.spin.cross(corner_of(x0, k) - part.centre);
            after = corner_of(v1, k) - end.velocity - end.spin.cross(corner_of(x1, k) - end.centre);
        }
        Vec3 off = 0.5 * dt * (after - turn[p] * before);
        if (held[p] == 0) off += dt * dt / 6 * change[p];
        if (held[p] != 0 && !stage.lifted.empty()) off += corner_of(stage.lifted, k);
        return off.norm() / body.edge_at(k);
    });
}

int halvings_of(int steps)
{
    int out = 0;
    while (out < finest_by_error && steps >> (out + 1) > 0) ++out;
    const bool even = out > 0 && steps == 1 << out;  // none was taken back
    return even ? out - 1 : out;
}

}  // namespace physics
