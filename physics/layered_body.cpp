// What a layered body is made of; how it moves is in layered.cpp.

#include "physics/layered.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace physics {

using geometry::Skeleton;
using geometry::SkeletonKind;

namespace {

// Volume, first and second moments about the origin, of unit density.
struct Moments {
    double volume = 0;
    Vec3 first = Vec3::Zero();
    Mat3 second = Mat3::Zero();  // sum x x^T

    void add(const Vec3& p, double v)
    {
        volume += v;
        first += v * p;
        second += v * p * p.transpose();
    }
};

void add_core(const Skeleton& s, double volume, Moments& m)
{
    if (!(volume > 0)) return;
    const Vec3 centre = s.place.translation();
    m.add(centre, volume);
    if (s.kind == SkeletonKind::mesh) {
        // Tetrahedra from the mesh's origin, four points each: exact for second moments.
        m.add(centre, -volume);
        const geometry::TriMesh& mesh = s.mesh->mesh;
        for (const geometry::Triangle& t : mesh.triangles()) {
            const Vec3 a = mesh.positions[t[0]].cast<double>(),
                       b = mesh.positions[t[1]].cast<double>(),
                       c = mesh.positions[t[2]].cast<double>();
            const double v = a.dot(b.cross(c)) / 24;
            constexpr double near = 0.58541019662496845, far = 0.13819660112501051;
            const Vec3 sum = far * (a + b + c);
            for (const Vec3& p : {sum, Vec3(sum + (near - far) * a), Vec3(sum + (near - far) * b),
                                  Vec3(sum + (near - far) * c)}) {
                m.add(s.place * p, v);
            }
        }
        return;
    }
    const double share = s.kind == SkeletonKind::box ? 1.0 / 3 : 1.0 / 5;
    const Mat3 turn = s.place.linear();
    const Vec3 own = volume * share * s.half_size.cwiseAbs2();
    m.second += turn * own.asDiagonal() * turn.transpose();
}

// What a frame's territories hold, from the rays of their seeds; three Gauss points a ray are
// exact.
std::vector<Moments> moments_of_frames(const ImplicitLayer& layer, const Seeds& seeds,
                                       const SeedWalk& walk, std::size_t frames)
{
    std::vector<Moments> moments(frames);
    const double g = std::sqrt(0.6);
    const double at[] = {0.5 * (1 - g), 0.5, 0.5 * (1 + g)},
                 weight[] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    for (std::size_t s = 0; s < layer.skeletons.size(); ++s) {
        Moments& m = moments[layer.frame[s]];
        for (std::size_t i = seeds.first[s]; i < seeds.first[s + 1]; ++i) {
            const double d = walk.distance[i];
            for (int k = 0; k < 3; ++k) {
                const double t = at[k] * d;
                const double across = seeds.a0[i] + t * (seeds.a1[i] + t * seeds.a2[i]);
                m.add(seeds.origin[i] + t * seeds.direction[i], weight[k] * d * across);
            }
        }
        add_core(layer.skeletons[s], seeds.core[s], m);
    }
    return moments;
}

}  // namespace

LayeredBody make_layered_body(ImplicitLayer layer, BaseKind kind, double density,
                              double seed_spacing)
{
    if (!(density > 0) || !std::isfinite(density)) {
        throw std::invalid_argument(
            fmt::format("a layered body needs a density above 0 kg/m^3, got {}", density));
    }
    std::size_t frames = 0;
    for (const std::uint32_t f : layer.frame) frames = std::max<std::size_t>(frames, f + 1);
    const std::vector<Transform> drawn(frames, Transform::Identity());

    LayeredBody body;
    const Field field = geometry::make_field(layer, drawn);
    body.seeds = make_seeds(layer, seed_spacing);
    const SeedWalk walk = physics::walk(field, body.seeds, drawn);
    body.volume = walk.local_volume;
    body.base.kind = kind;
    body.base.frames = drawn;
    body.base.mass.assign(frames, 0);
    body.base.inertia.assign(frames, Mat3::Identity());
    body.matter.rigid = false;
    if (!is_told(kind)) {
        const std::vector<Moments> moments = moments_of_frames(layer, body.seeds, walk, frames);
        for (std::size_t f = 0; f < frames; ++f) {
            const Moments& m = moments[f];
            if (!(m.volume > 0)) {
                throw std::invalid_argument(fmt::format(
                    "frame {} of a layered body holds no volume of its own: all of its skeletons "
                    "lie inside others' territories, or are planes; make the body still, or move "
                    "them apart",
                    f));
            }
            const Vec3 centre = m.first / m.volume;
            body.base.frames[f].translation() = centre;
            body.base.mass[f] = density * m.volume;
            const Mat3 second = density * (m.second - m.volume * centre * centre.transpose());
            body.base.inertia[f] = second.trace() * Mat3::Identity() - second;
        }
        if (kind == BaseKind::particles) {  // a particle is where its skeleton is
            for (std::size_t s = layer.skeletons.size(); s-- > 0;) {
                const Skeleton& skeleton = layer.skeletons[s];
                if (skeleton.kind != SkeletonKind::point) {
                    throw std::invalid_argument(
                        fmt::format("particles carry point skeletons only: make skeleton {}, "
                                    "counted from 0, a point, or take another base",
                                    s));
                }
                body.base.frames[layer.frame[s]].translation() = skeleton.points[0];
            }
        }
        for (std::size_t s = 0; s < layer.skeletons.size(); ++s) {
            const Vec3 to = -body.base.frames[layer.frame[s]].translation();
            for (Vec3& p : layer.skeletons[s].points) p += to;
            layer.skeletons[s].place.pretranslate(to);
            for (std::size_t i = body.seeds.first[s]; i < body.seeds.first[s + 1]; ++i) {
                body.seeds.origin[i] += to;
            }
        }
    }
    body.layer = std::move(layer);
    return body;
}

bool is_told(BaseKind kind)
{
    return kind == BaseKind::still || kind == BaseKind::led;
}

void check_rigid_bodies(std::span<const LayeredPart> parts, RigidBodies rigid_bodies)
{
    if (rigid_bodies == RigidBodies::implicit) return;
    for (std::size_t b = 0; b < parts.size(); ++b) {
        const BaseKind kind = parts[b].body->base.kind;
        if (kind == BaseKind::rigid || kind == BaseKind::still) continue;
        throw std::invalid_argument(fmt::format(
            "Bullet moves rigid bodies beside still ones only, and body {} is {}: set rigid_bodies "
            "to implicit, which moves all kinds together, or give that body a Layered of its own",
            b, kind == BaseKind::particles ? "of particles" : "carried by cubes"));
    }
}

std::vector<Transform> told_frames(const LayeredPart& part)
{
    if (!part.frames.empty()) return part.frames;
    std::vector<Transform> frames = part.body->base.frames;
    for (Transform& frame : frames) frame = part.pose * frame;
    return frames;
}

std::vector<std::vector<std::uint32_t>> skeletons_on_frames(const LayeredBody& body)
{
    std::vector<std::vector<std::uint32_t>> on_frame(body.base.frames.size());
    for (std::uint32_t i = 0; i < body.layer.frame.size(); ++i) {
        on_frame[body.layer.frame[i]].push_back(i);
    }
    return on_frame;
}

void set_on_cubes(LayeredBody& body, geometry::Cubes cubes, const BrickOptions& options)
{
    if (body.base.kind != BaseKind::still) {
        throw std::invalid_argument(
            "cubes carry a layer that has no masses of its own: make its base still");
    }
    CubeBase::Source source{std::move(cubes), options, {}};
    source.frames = bind_frames(body.base.frames, body.seeds, source.cubes);
    body.base.cubes = std::make_shared<const CubeBase>(std::move(source));
    body.base.kind = BaseKind::cubes;
}

Hinge& add_hinge(Base& base, std::uint32_t a, std::uint32_t b, const Vec3& point, const Vec3& axis)
{
    if (base.kind != BaseKind::rigid || a >= base.frames.size() || b >= base.frames.size() ||
        a == b) {
        throw std::invalid_argument(
            fmt::format("a hinge joins two frames of a rigid body; got frames {} and {} of {}{}", a,
                        b, base.frames.size(), base.kind == BaseKind::rigid ? "" : ", not rigid"));
    }
    if (!(axis.norm() > 0) || !axis.allFinite() || !point.allFinite()) {
        throw std::invalid_argument("a hinge needs a point and an axis with a direction");
    }
    const Vec3 along = axis.normalized(), square = along.unitOrthogonal();
    Hinge hinge{.a = a, .b = b};
    hinge.point_a = base.frames[a].inverse() * point;
    hinge.point_b = base.frames[b].inverse() * point;
    hinge.axis_a = base.frames[a].linear().transpose() * along;
    hinge.axis_b = base.frames[b].linear().transpose() * along;
    hinge.zero_a = base.frames[a].linear().transpose() * square;
    hinge.zero_b = base.frames[b].linear().transpose() * square;
    base.hinges.push_back(hinge);
    return base.hinges.back();
}

double hinge_angle(const Hinge& hinge, const Transform& a, const Transform& b)
{
    const Vec3 axis = a.linear() * hinge.axis_a;
    const Vec3 za = a.linear() * hinge.zero_a, zb = b.linear() * hinge.zero_b;
    return std::atan2(za.cross(zb).dot(axis), za.dot(zb));
}

void add_spring_network(Base& base, double reach, double stiffness, double damping)
{
    const std::size_t before = base.springs.size();
    for (std::uint32_t a = 0; a < base.frames.size(); ++a) {
        for (std::uint32_t b = a + 1; b < base.frames.size(); ++b) {
            const double rest =
                (base.frames[a].translation() - base.frames[b].translation()).norm();
            if (rest < reach) base.springs.push_back({a, b, rest, stiffness, damping});
        }
    }
    if (base.springs.size() == before) {
        throw std::invalid_argument(fmt::format(
            "no two of {} frames are nearer than {} m: reach farther", base.frames.size(), reach));
    }
    base.substance.stiffness = base.substance.friction = 0;
}

LayeredPart rigid_part(const Collider& collider)
{
    // Rounded by a tenth of its size; only f = c and its slope there matter to others.
    Skeleton skeleton{.kind = SkeletonKind::plane, .points = {}};
    double e = 0.1;
    switch (collider.kind) {
    case Collider::Kind::plane:
        skeleton.place.translate(Vec3(0, collider.thickness - e, 0));
        break;
    case Collider::Kind::sphere:
        skeleton = {.kind = SkeletonKind::point};
        e = collider.radius + collider.thickness;
        break;
    case Collider::Kind::box: {
        skeleton.kind = SkeletonKind::box;
        e = 0.1 * collider.half_size.minCoeff();
        skeleton.half_size = collider.half_size.array() - e;
        e += collider.thickness;
        break;
    }
    case Collider::Kind::mesh:
        if (!collider.mesh) throw std::invalid_argument("a mesh collider without a mesh");
        skeleton.kind = SkeletonKind::mesh;
        skeleton.mesh = std::make_shared<const geometry::SkeletonMesh>(*collider.mesh);
        e = std::max(collider.thickness, 1e-3 * geometry::bounds(*collider.mesh).diagonal());
    }
    LayeredBody body;
    body.layer.skeletons = {skeleton};
    body.layer.contributions = {{.thickness = e, .stiffness = 1 / e, .radius = 3 * e}};
    body.layer.frame = {0};
    body.seeds.first = {0, 0};
    body.seeds.core = {0};
    body.seeds.frame = {0};
    body.volume = {0};
    body.base.kind = BaseKind::still;
    body.base.frames = {Transform::Identity()};
    body.base.mass = {0};
    body.base.inertia = {Mat3::Identity()};
    body.matter.rigid = true;
    body.matter.grip = collider.friction;
    geometry::make_field(body.layer, body.base.frames);  // throws what is wrong with it
    LayeredPart part;
    part.body = std::make_shared<const LayeredBody>(std::move(body));
    if (collider.kind != Collider::Kind::mesh) {
        part.pose = collider.pose;
    } else if (collider.mesh_before && collider.mesh_before != collider.mesh &&
               collider.mesh_before->topology == collider.mesh->topology &&
               collider.mesh_before->positions.size() == collider.mesh->positions.size()) {
        part.mesh_before = collider.mesh_before;
    }
    return part;
}

std::size_t LayeredBody::bytes() const
{
    const std::size_t each_seed = 2 * sizeof(Vec3) + 3 * sizeof(double) + sizeof(std::uint32_t);
    return seeds.count() * each_seed + 2 * seeds.faces.size() * sizeof(geometry::Triangle) +
           layer.skeletons.size() * (sizeof(Skeleton) + sizeof(geometry::Contribution) + 32) +
           base.frames.size() * (sizeof(Transform) + sizeof(Mat3)) +
           (base.cubes ? base.cubes->bytes() : 0);
}

}  // namespace physics
