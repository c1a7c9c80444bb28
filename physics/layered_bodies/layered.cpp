#include "physics/layered_bodies/layered.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace physics {

std::size_t LayeredBody::bytes() const
{
    const std::size_t each_sample = 2 * sizeof(Vec3) + 3 * sizeof(double) + sizeof(std::uint32_t);
    return samples.count() * each_sample + 2 * samples.faces.size() * sizeof(geometry::Triangle) +
           layer.skeletons.size() *
               (sizeof(geometry::Skeleton) + sizeof(geometry::Contribution) + 32) +
           base.frames.size() * (sizeof(Transform) + sizeof(Mat3)) +
           base.springs.size() * sizeof(LayerSpring) +
           base.spans.size() * (sizeof(NetSpan) + 3 * sizeof(std::uint32_t)) +
           (base.cubes ? base.cubes->bytes() : 0);
}

std::size_t LayeredState::bytes() const
{
    return position.size() * (3 * sizeof(Vec3) + sizeof(Eigen::Vector4d)) +
           (translation.size() + volume.size() + inflation.size() + expected_error.size() +
            distance.size()) *
               sizeof(double) +
           pressed.size() * sizeof(float) + links.size() * sizeof(geometry::BlendLink) +
           part.size() * sizeof(std::uint32_t) + bounces.size() * sizeof(LayerBounce) +
           2 * cubes.x.size() * sizeof(Vec3) + cubes.rotation.size() * sizeof(float);
}

std::size_t LayeredScene::bytes() const
{
    std::size_t sum = 0;
    for (const LayeredState& state : states) sum += sizeof(state) + state.bytes();
    if (!presses) return sum;
    const LayeredBody* last = nullptr;
    for (const LayeredPart& part : parts) {
        if (part.body.get() != last) sum += part.body->bytes();
        last = part.body.get();
    }
    return sum;
}

std::vector<Transform> told_frames(const LayeredPart& part)
{
    if (!part.frames.empty()) return part.frames;
    std::vector<Transform> frames = part.body->base.frames;
    for (Transform& frame : frames) frame = part.pose * frame;
    return frames;
}

std::vector<Vec3> first_velocities(const LayeredPart& part, const std::vector<Transform>& at)
{
    if (!part.velocities.empty()) return part.velocities;
    const Base& base = part.body->base;
    std::vector<Vec3> all(at.size(), part.velocity);
    if (base.cubes || part.spin.isZero(0) || is_told(base.kind)) return all;
    double mass = 0;
    Vec3 moment = Vec3::Zero();
    for (std::size_t f = 0; f < at.size(); ++f) {
        mass += base.mass[f];
        moment += base.mass[f] * at[f].translation();
    }
    for (std::size_t f = 0; f < at.size(); ++f) {
        all[f] += part.spin.cross(at[f].translation() - moment / mass);
    }
    return all;
}

std::vector<std::vector<std::uint32_t>> skeletons_on_frames(const LayeredBody& body)
{
    std::vector<std::vector<std::uint32_t>> on_frame(body.base.frames.size());
    for (std::uint32_t i = 0; i < body.layer.frame.size(); ++i) {
        on_frame[body.layer.frame[i]].push_back(i);
    }
    return on_frame;
}

double volume_error(const LayeredBody& body, const LayeredState& state)
{
    if (!(body.control.proportional > 0) || state.volume.empty()) return 0;
    const double target =
        std::inner_product(body.volume.begin(), body.volume.end(), state.inflation.begin(), 0.0);
    const double now = std::accumulate(state.volume.begin(), state.volume.end(), 0.0);
    return std::abs(now / target - 1);
}

double volume_error(const LayeredScene& scene)
{
    double worst = 0;
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        worst = std::max(worst, volume_error(*scene.parts[b].body, scene.states[b]));
    }
    return worst;
}

double interpenetration(const LayeredScene& scene)
{
    double worst = 0;
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        double thinnest = std::numeric_limits<double>::infinity();
        for (const geometry::Contribution& c : scene.parts[b].body->layer.contributions) {
            thinnest = std::min(thinnest, c.thickness);
        }
        worst = std::max(worst, scene.states[b].penetration / thinnest);
    }
    return worst;
}

double fastest(const LayeredScene& scene)
{
    double most = 0;
    for (const LayeredState& state : scene.states) {
        for (const Vec3& v : state.velocity) most = std::max(most, v.norm());
    }
    return most;
}

}  // namespace physics
