#include "physics/layered_bodies/inner_motion.hpp"

#include "geometry/fields/field.hpp"
#include "geometry/fields/skeleton_mesh.hpp"
#include "geometry/mesh/same_triangles.hpp"
#include "physics/layers/velocity_at.hpp"

#include <algorithm>
#include <numeric>

namespace physics {
namespace {

using geometry::Skeleton;

using Points = Eigen::Matrix3Xd;

Points matrix_of(const std::vector<Vec3>& points)
{
    Points all(3, static_cast<Eigen::Index>(points.size()));
    for (std::size_t i = 0; i < points.size(); ++i)
        all.col(static_cast<Eigen::Index>(i)) = points[i];
    return all;
}

// The rigid motion that takes points nearest to others. Of those in a line, without a turn about
// it.
Transform fitted(const std::vector<Vec3>& from, const std::vector<Vec3>& to)
{
    const Points p = matrix_of(from), q = matrix_of(to);
    const Vec3 centre_p = p.rowwise().mean(), centre_q = q.rowwise().mean();
    const Eigen::JacobiSVD<Points> spread(p.colwise() - centre_p);
    const auto& size = spread.singularValues();
    Transform by = Transform::Identity();
    if (from.size() > 2 && size[1] > 1e-6 * size[0]) {
        by.matrix() = Eigen::umeyama(p, q, false);
        return by;
    }
    by.translate(centre_q);
    const Vec3 along_p = from.back() - from.front(), along_q = to.back() - to.front();
    if (from.size() > 1 && along_p.norm() > 0 && along_q.norm() > 0) {
        by.rotate(Eigen::Quaterniond::FromTwoVectors(along_p, along_q));
    }
    by.translate(-centre_p);
    return by;
}

bool same_shape(const Skeleton& p, const Skeleton& q)
{
    if (p.kind != q.kind || p.points.size() != q.points.size()) return false;
    return p.mesh == q.mesh ||
           (p.mesh && q.mesh && geometry::same_triangles(p.mesh->mesh, q.mesh->mesh) &&
            p.mesh->mesh.positions == q.mesh->mesh.positions);
}

// What a still body's skeletons did; empty where nothing moved inside.
std::vector<InnerMotion> motions(const LayeredBody& before, const LayeredBody& now)
{
    if (&before == &now || now.base.kind != BaseKind::still || now.samples.count() == 0) return {};
    std::vector<InnerMotion> all;
    bool any = false;
    for (std::size_t s = 0; s < now.layer.skeletons.size(); ++s) {
        const Skeleton &p = before.layer.skeletons[s], &q = now.layer.skeletons[s];
        all.push_back(same_shape(p, q) ? inner_motion(p, q) : InnerMotion{});
        any |= all.back().rest > 0 || !all.back().by.isApprox(Transform::Identity());
    }
    if (!any) all.clear();
    return all;
}

// A skeleton moved by a rigid motion.
Skeleton moved(Skeleton skeleton, const Transform& by)
{
    for (Vec3& p : skeleton.points) p = by * p;
    skeleton.place = by * skeleton.place;
    return skeleton;
}

// What is left where the rigid motions are taken off; null where nothing is.
std::shared_ptr<const ShapeChange> change_of(const LayeredBody& before, const LayeredBody& now,
                                             const std::vector<InnerMotion>& motions, double dt)
{
    auto change = std::make_shared<ShapeChange>();
    change->seconds = dt;
    bool any = false;
    for (std::size_t s = 0; s < motions.size(); ++s) {
        const bool changes = motions[s].rest > 0;
        any |= changes;
        const Skeleton& after = now.layer.skeletons[s];
        change->after.push_back(after);
        change->before.push_back(changes ? moved(before.layer.skeletons[s], motions[s].by) : after);
        change->before.back().place = after.place;
    }
    return any ? change : nullptr;
}

}  // namespace

InnerMotion inner_motion(const Skeleton& before, const Skeleton& now)
{
    InnerMotion motion;
    if (!geometry::has_points(now.kind)) {
        motion.rest = (before.half_size - now.half_size).norm();
        if (!before.place.isApprox(now.place, 1e-12))
            motion.by = now.place * before.place.inverse();
        return motion;
    }
    if (before.points == now.points) return motion;
    if (now.stretches() || before.stretches()) {  // whose axes do not turn with its points
        motion.by.translation() =
            matrix_of(now.points).rowwise().mean() - matrix_of(before.points).rowwise().mean();
    } else {
        motion.by = fitted(before.points, now.points);
    }
    for (std::size_t i = 0; i < now.points.size(); ++i) {
        const double off = (motion.by * before.points[i] - now.points[i]).norm();
        if (off > 1e-9) motion.rest = std::max(motion.rest, off);
    }
    return motion;
}

void split_moved_frames(const LayeredScene& before, double dt, LayeredScene& now)
{
    for (std::size_t b = 0; b < now.parts.size(); ++b) {
        const auto moved = motions(*before.parts[b].body, *now.parts[b].body);
        if (moved.empty()) continue;
        LayeredPart& part = now.parts[b];
        part.change = change_of(*before.parts[b].body, *part.body, moved, dt);
        LayeredState& state = now.states[b];
        const std::vector<Transform> told = told_frames(part);
        const std::vector<std::uint32_t> frame_of = part.body->layer.frame;
        const std::size_t count = frame_of.size();
        const LayeredState old = state;
        LayeredBody body = *part.body;
        std::iota(body.layer.frame.begin(), body.layer.frame.end(), 0u);
        body.samples.frame = body.layer.frame;
        body.base.mass.assign(count, 0);
        body.base.inertia.assign(count, Mat3::Identity());
        body.base.springs.clear();
        body.base.hinges.clear();
        body.base.joints.clear();
        part.frames.clear();
        body.base.frames.clear();
        state.position.clear();
        state.rotation.clear();
        for (std::size_t s = 0; s < count; ++s) {
            const std::uint32_t f = frame_of[s];
            part.frames.push_back(told[f]);
            body.base.frames.push_back(part.body->base.frames[f]);
            Transform at = Transform::Identity();
            at.translate(old.position[f]).rotate(Eigen::Quaterniond(old.rotation[f]));
            at = at * moved[s].by.inverse();
            state.position.push_back(at.translation());
            state.rotation.push_back(Eigen::Quaterniond(at.linear()).normalized().coeffs());
        }
        state.velocity.assign(count, Vec3::Zero());
        state.spin.assign(count, Vec3::Zero());
        part.body = std::make_shared<const LayeredBody>(std::move(body));
    }
}

void change_shapes(const std::vector<LayeredPart>& told, double share, LayeredScene& now)
{
    for (std::size_t b = 0; b < now.parts.size(); ++b) {
        LayeredPart& part = now.parts[b];
        if (!part.change) continue;
        LayeredBody body = *part.body;
        const SurfaceSamples& samples = told[b].body->samples;
        for (std::size_t s = 0; s < body.layer.skeletons.size(); ++s) {
            const Skeleton &before = part.change->before[s], &after = part.change->after[s];
            Skeleton& skeleton = body.layer.skeletons[s];
            for (std::size_t i = 0; i < after.points.size(); ++i) {
                skeleton.points[i] =
                    before.points[i] + share * (after.points[i] - before.points[i]);
            }
            skeleton.half_size = before.half_size + share * (after.half_size - before.half_size);
            for (std::size_t i = samples.first[s]; i < samples.first[s + 1]; ++i) {
                const Vec3& origin = samples.origin[i];
                body.samples.origin[i] =
                    origin - (1 - share) * way_of(after, before, after, origin);
            }
        }
        part.body = std::make_shared<const LayeredBody>(std::move(body));
    }
}

}  // namespace physics
