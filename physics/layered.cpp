#include "physics/layered.hpp"

#include "physics/pins.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>
#include <stdexcept>

namespace physics {
namespace {

using geometry::BlendLink;
using geometry::Skeleton;
using geometry::SkeletonKind;

// Whether frames are where somebody says.
bool is_told(BaseKind kind)
{
    return kind == BaseKind::still || kind == BaseKind::led;
}

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Jacobian = Eigen::Matrix<double, 3, 6>;

Mat3 cross_matrix(const Vec3& a)
{
    Mat3 m;
    m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    return m;
}

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
                    throw std::invalid_argument(fmt::format(
                        "particles carry point skeletons only, skeleton {} is another", s));
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

namespace {

// Puts the frames where their cubes carry them.
void follow_cubes(const LayeredBody& body, LayeredState& state)
{
    const CubeBase& base = *body.base.cubes;
    for (std::size_t f = 0; f < body.base.frames.size(); ++f) {
        const FrameHold hold = base.hold(f, body.base.frames[f], state.cubes.x);
        const Transform at = hold.moved * body.base.frames[f];
        Vec6 twist = Vec6::Zero();
        for (std::size_t a = 0; a < hold.by.size(); ++a) {
            twist += hold.by[a] * state.cubes.v[base.corners(f)[a]];
        }
        state.position[f] = at.translation();
        state.rotation[f] = Eigen::Quaterniond(at.linear()).normalized().coeffs();
        state.velocity[f] = twist.head<3>();
        state.spin[f] = twist.tail<3>();
    }
}

std::vector<Transform> told_frames(const LayeredPart& part)
{
    if (!part.frames.empty()) return part.frames;
    std::vector<Transform> frames = part.body->base.frames;
    for (Transform& frame : frames) frame = part.pose * frame;
    return frames;
}

LayeredState start(const LayeredPart& part)
{
    const LayeredBody& body = *part.body;
    LayeredState state;
    for (const Transform& frame : told_frames(part)) {
        state.position.push_back(frame.translation());
        state.rotation.push_back(Eigen::Quaterniond(frame.linear()).coeffs());
    }
    state.velocity.assign(body.base.frames.size(), part.velocity);
    state.spin.assign(body.base.frames.size(), Vec3::Zero());
    if (body.base.cubes) {
        state.cubes = rest_state(body.base.cubes->bricks());
        for (Vec3& x : state.cubes.x) x = part.pose * x;
        state.cubes.v.assign(state.cubes.x.size(), part.velocity);
        follow_cubes(body, state);
    }
    state.translation.assign(body.layer.skeletons.size(), 0);
    state.part = body.layer.blend.part;
    if (state.part.empty() && body.layer.blend.rule != geometry::BlendRule::sum) {
        state.part.resize(body.layer.skeletons.size());
        std::iota(state.part.begin(), state.part.end(), 0u);
    }
    state.links = body.layer.blend.links;
    return state;
}

}  // namespace

LayeredScene start(std::vector<LayeredPart> parts)
{
    LayeredScene scene;
    for (const LayeredPart& part : parts) scene.states.push_back(start(part));
    scene.parts = std::move(parts);
    return scene;
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

std::size_t LayeredState::bytes() const
{
    return position.size() * (3 * sizeof(Vec3) + sizeof(Eigen::Vector4d)) +
           (translation.size() + volume.size() + inflation.size() + expected_error.size() +
            distance.size()) *
               sizeof(double) +
           pressed.size() * sizeof(float) + links.size() * sizeof(BlendLink) +
           part.size() * sizeof(std::uint32_t) + 2 * cubes.x.size() * sizeof(Vec3) +
           cubes.rotation.size() * sizeof(float);
}

std::size_t LayeredScene::bytes() const
{
    std::size_t sum = 0;
    for (const LayeredState& state : states) sum += sizeof(state) + state.bytes();
    return sum;
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

std::size_t particle_count(const LayeredScene& scene)
{
    std::size_t count = 0;
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        if (scene.parts[b].body->base.kind != BaseKind::particles) continue;
        for (const Vec3& p : scene.states[b].position) count += p.allFinite();
    }
    return count;
}

std::size_t piece_count(const LayeredScene& scene)
{
    std::size_t count = 0;
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        if (scene.parts[b].body->base.kind != BaseKind::particles) continue;
        const std::vector<std::uint32_t>& part = scene.states[b].part;
        count += part.empty() ? 1 : std::set(part.begin(), part.end()).size();
    }
    return count;
}

double fastest(const LayeredScene& scene)
{
    double most = 0;
    for (const LayeredState& state : scene.states) {
        for (const Vec3& v : state.velocity) most = std::max(most, v.norm());
    }
    return most;
}

LayeredMoment::LayeredMoment(const LayeredScene& scene, double mesh_seconds)
{
    const std::size_t n = scene.parts.size();
    fields.reserve(n);
    walks.reserve(n);
    for (std::size_t b = 0; b < n; ++b) {
        const LayeredBody& body = *scene.parts[b].body;
        const LayeredState& state = scene.states[b];
        std::vector<Transform> at;
        std::vector<Twist> moving;
        for (std::size_t f = 0; f < state.position.size(); ++f) {
            Transform t = Transform::Identity();
            t.translate(state.position[f]).rotate(Eigen::Quaterniond(state.rotation[f]));
            at.push_back(t);
            moving.push_back({state.velocity[f], state.spin[f]});
        }
        ImplicitLayer layer = body.layer;
        layer.blend.part = state.part;
        layer.blend.links = state.links;
        fields.push_back(geometry::make_field(layer, at, state.translation));
        SeedWalk before;
        before.distance = state.distance;
        walks.push_back(physics::walk(fields.back(), body.seeds, at,
                                      state.distance.empty() ? nullptr : &before,
                                      body.control.proportional > 0));
        frames.push_back(std::move(at));
        twists.push_back(std::move(moving));
    }
    for (const LayeredPart& part : scene.parts) {
        meshes.push_back({part.mesh_before ? part.body->layer.skeletons[0].mesh : nullptr,
                          part.mesh_before, mesh_seconds});
    }
    for (std::size_t b = 0; b < n; ++b) {
        bodies.push_back({&fields[b], &scene.parts[b].body->seeds, &walks[b], frames[b], twists[b],
                          scene.parts[b].body->layer.frame, scene.parts[b].body->matter,
                          meshes[b].before ? &meshes[b] : nullptr});
    }
    contacts = find_contacts(bodies);
}

namespace {

// The linear system of one backward Euler step, frame by frame; frames are numbered through all
// bodies, and after them the corners of cubes. Frames that cubes carry are no unknowns: they follow
// corners, and what they feel is handed on to those (cube_base.hpp). A pair term with 3x3 matrices
// C and K between points of two frames adds
//   J^T (dt C + dt^2 K) J      J: velocities to the relative velocity of the points
// to the left and its forces, with -dt K of that velocity, to the right.
class StepSystem {
public:
    StepSystem(const LayeredScene& scene, const LayeredMoment& moment, double dt) : dt_(dt)
    {
        const double led_mass = led_weight * heaviest(scene);
        for (std::size_t b = 0; b < scene.parts.size(); ++b) {
            first_.push_back(velocity_.size());
            const LayeredBody& body = *scene.parts[b].body;
            for (std::size_t f = 0; f < body.base.frames.size(); ++f) {
                Vec6 v;
                v << moment.twists[b][f].linear, moment.twists[b][f].angular;
                velocity_.push_back(v);
                kind_.push_back(body.base.kind);
                Mat6 mass = Mat6::Identity();
                if (body.base.kind != BaseKind::still) {
                    mass.topLeftCorner<3, 3>() *= body.base.kind == BaseKind::led ? led_mass
                                                  : body.base.cubes ? body.base.cubes->mass(f)
                                                                    : body.base.mass[f];
                }
                if (body.base.kind == BaseKind::rigid) {
                    const Mat3 turn = moment.frames[b][f].linear();
                    mass.bottomRightCorner<3, 3>() = turn * body.base.inertia[f] * turn.transpose();
                }
                mass_.push_back(mass);
                diagonal_.push_back(body.base.cubes ? Mat6::Zero() : mass);
            }
        }
        right_.assign(velocity_.size(), Vec6::Zero());
        first_corner_.resize(scene.parts.size());
        for (std::size_t b = 0; b < scene.parts.size(); ++b) {
            if (scene.parts[b].body->base.cubes) add_cubes(scene, b);
        }
    }

    std::size_t corner(std::size_t body, std::size_t k) const { return first_corner_[body] + k; }
    // The rotations of each body's cubes as they were found, in the order of such bodies.
    std::vector<float> rotations(std::size_t body) const
    {
        for (const Carrier& carrier : carriers_) {
            if (carrier.first_frame == first_[body]) return carrier.elasticity->rotations();
        }
        return {};
    }

    std::size_t frame(std::size_t body, std::size_t f) const { return first_[body] + f; }
    double dt() const { return dt_; }
    const Mat6& mass(std::size_t f) const { return mass_[f]; }

    void add_force(std::size_t f, const Vec3& force, const Vec3& torque = Vec3::Zero())
    {
        right_[f].head<3>() += dt_ * force;
        right_[f].tail<3>() += dt_ * torque;
    }
    void add_drag(std::size_t f, double rate)
    {
        right_[f] -= dt_ * rate * (mass_[f] * velocity_[f]);
        diagonal_[f] += dt_ * rate * mass_[f];
    }

    // Only the matrix terms: forces come by add_force().
    void add_pair(std::size_t a, std::size_t b, const Vec3& arm_a, const Vec3& arm_b, const Mat3& C,
                  const Mat3& K)
    {
        add_terms(a, b, point_jacobian(a, arm_a), point_jacobian(b, arm_b), C, K);
    }
    void add_angular_pair(std::size_t a, std::size_t b, const Mat3& C, const Mat3& K)
    {
        Jacobian J = Jacobian::Zero();
        J.rightCols<3>().setIdentity();
        add_terms(a, b, J, J, C, K);
    }

    // Points of two frames may not come nearer than this along `normal`, away from b, in the step:
    // what is left between them now is `gap` m more. At least one of the two is free.
    void add_stop(std::size_t a, std::size_t b, const Vec3& arm_a, const Vec3& arm_b,
                  const Vec3& normal, double gap)
    {
        if (a == b || (kind_[a] == BaseKind::still && kind_[b] == BaseKind::still)) return;
        const double mass = kind_[a] == BaseKind::still ? mass_[b](0, 0)
                            : kind_[b] == BaseKind::still
                                ? mass_[a](0, 0)
                                : std::min(mass_[a](0, 0), mass_[b](0, 0));
        stops_.push_back({a, b, point_jacobian(a, arm_a).transpose() * normal,
                          -point_jacobian(b, arm_b).transpose() * normal, gap / dt_,
                          stop_stiffness * mass});
    }

    // dv of every frame: the least of  dv^T A dv / 2 - dv . right + sum stiffness min(0, u +
    // room)^2 / 2  over stops, convex and quadratic in pieces. Newton's method: those that would be
    // passed are held, the others let go, until that is what comes out; a step that does not go
    // down is halved.
    std::vector<Vec6> solve(Report& report)
    {
        merge_pairs();
        hand_to_corners(right_);
        for (std::size_t f = 0; f < velocity_.size(); ++f) {
            right_[f] = free(f, right_[f]);
            if (kind_[f] == BaseKind::particles) right_[f].tail<3>().setZero();
        }
        std::vector<Vec6> dv = solve_held(report);
        constexpr int most_rounds = 30;
        double now = potential(dv);
        for (int round = 0; round < most_rounds && hold_passed(dv); ++round) {
            const std::vector<Vec6> end = solve_held(report);
            std::vector<Vec6> next = end;
            double after = potential(next);
            for (double share = 0.5; after > now && share > 1e-3; share *= 0.5) {
                for (std::size_t f = 0; f < dv.size(); ++f) {
                    next[f] = dv[f] + share * (end[f] - dv[f]);
                }
                after = potential(next);
            }
            dv = std::move(next);
            now = after;
        }
        return dv;
    }

private:
    struct Pair {
        std::size_t a, b;
        Mat6 off;  // row a, column b
    };

    // Speed of parting u = along_a . v_a + along_b . v_b must be at least -room.
    struct Stop {
        std::size_t a, b;
        Vec6 along_a, along_b;
        double room;  // m/s
        double
            stiffness;  // kg: while held, stiffness (u + room)^2 / 2 joins what the step minimises
        bool held = false;

        double speed(const std::vector<Vec6>& v) const
        {
            return along_a.dot(v[a]) + along_b.dot(v[b]);
        }
    };

    // Cubes that carry the frames from first_frame on.
    struct Carrier {
        const CubeBase* base = nullptr;
        std::size_t first_frame = 0, first_corner = 0;
        std::vector<FrameHold> holds;  // one a frame
        std::unique_ptr<Elasticity> elasticity;
        Aligned<double> diagonal;  // by slot, about, of its terms

        const CornerBody& corner_body() const { return base->bricks().base; }
    };

    // Of the mass that it stops: it gives way by a thousandth of what the step would do without it.
    static constexpr double stop_stiffness = 1000;
    // Led frames are so much heavier than all others: those hardly push them.
    static constexpr double led_weight = 1e6;

    static double heaviest(const LayeredScene& scene)
    {
        double most = 0;
        for (const LayeredPart& part : scene.parts) {
            if (is_told(part.body->base.kind)) continue;
            for (const double mass : part.body->base.mass) most = std::max(most, mass);
        }
        return most > 0 ? most : 1;
    }

    double beyond(const Stop& stop, const std::vector<Vec6>& dv) const
    {
        return stop.speed(velocity_) + stop.speed(dv) + stop.room;
    }

    // Whether that changes which stops are held.
    bool hold_passed(const std::vector<Vec6>& dv)
    {
        bool changed = false;
        for (Stop& stop : stops_) {
            const bool passed = beyond(stop, dv) < 0;
            changed |= passed != stop.held;
            stop.held = passed;
        }
        return changed;
    }

    double potential(const std::vector<Vec6>& dv) const
    {
        if (stops_.empty()) return 0;
        double sum = 0;
        for (std::size_t f = 0; f < dv.size(); ++f) {
            sum += dv[f].dot(0.5 * diagonal_[f] * dv[f] - right_[f]);
        }
        for (const Pair& pair : pairs_) sum += dv[pair.a].dot(pair.off * dv[pair.b]);
        if (!carriers_.empty()) {
            std::vector<Vec6> pull(dv.size(), Vec6::Zero());
            add_elastic(dv, pull);
            for (std::size_t f = 0; f < dv.size(); ++f) sum += 0.5 * dv[f].dot(pull[f]);
        }
        for (const Stop& stop : stops_) {
            const double miss = std::min(0.0, beyond(stop, dv));
            sum += 0.5 * stop.stiffness * miss * miss;
        }
        return sum;
    }

    // By conjugate gradients preconditioned by the frames' own blocks.
    std::vector<Vec6> solve_held(Report& report) const
    {
        const std::size_t n = velocity_.size();
        std::vector<Mat6> blocks = diagonal_;
        std::vector<Vec6> right = right_;
        for (const Stop& stop : stops_) {
            if (!stop.held) continue;
            const double miss = stop.stiffness * (stop.speed(velocity_) + stop.room);
            blocks[stop.a] += stop.stiffness * stop.along_a * stop.along_a.transpose();
            blocks[stop.b] += stop.stiffness * stop.along_b * stop.along_b.transpose();
            right[stop.a] -= miss * stop.along_a;
            right[stop.b] -= miss * stop.along_b;
        }
        hand_to_corners(right);
        add_to_corner_blocks(blocks);
        std::vector<Eigen::LDLT<Mat6>> own;
        for (std::size_t f = 0; f < n; ++f) {
            if (kind_[f] == BaseKind::led) {  // turns as told
                blocks[f].topRightCorner<3, 3>().setZero();
                blocks[f].bottomLeftCorner<3, 3>().setZero();
                blocks[f].bottomRightCorner<3, 3>().setIdentity();
            }
            if (kind_[f] == BaseKind::cubes) blocks[f].setIdentity();
            own.emplace_back(blocks[f]);
            right[f] = free(f, right[f]);
        }
        std::vector<Vec6> x(n, Vec6::Zero()), r = right, z(n), p(n), Ap(n);
        const auto dot = [&](const std::vector<Vec6>& u, const std::vector<Vec6>& v) {
            double sum = 0;
            for (std::size_t f = 0; f < n; ++f) sum += u[f].dot(v[f]);
            return sum;
        };
        for (std::size_t f = 0; f < n; ++f) p[f] = z[f] = free(f, own[f].solve(r[f]));
        double rz = dot(r, z);
        const double goal = 1e-20 * rz;
        int iteration = 0;
        for (; rz > goal && rz > 1e-290 && iteration < 1000; ++iteration) {
            multiply(p, Ap);
            const double alpha = rz / dot(p, Ap);
            for (std::size_t f = 0; f < n; ++f) {
                x[f] += alpha * p[f];
                r[f] -= alpha * Ap[f];
                z[f] = free(f, own[f].solve(r[f]));
            }
            const double next = dot(r, z);
            for (std::size_t f = 0; f < n; ++f) p[f] = z[f] + next / rz * p[f];
            rz = next;
        }
        report.iterations += iteration;
        if (rz > 1e-12 * std::abs(goal) * 1e20) report.converged = false;
        return x;
    }

    Vec6 free(std::size_t f, Vec6 v) const
    {
        if (kind_[f] == BaseKind::still) v.setZero();
        if (kind_[f] == BaseKind::led) v.tail<3>().setZero();
        return v;
    }

    Jacobian point_jacobian(std::size_t f, const Vec3& arm) const
    {
        Jacobian J = Jacobian::Zero();
        J.leftCols<3>().setIdentity();
        if (kind_[f] != BaseKind::particles) J.rightCols<3>() = -cross_matrix(arm);
        return J;
    }

    void add_terms(std::size_t a, std::size_t b, const Jacobian& Ja, const Jacobian& Jb,
                   const Mat3& C, const Mat3& K)
    {
        const Mat3 D = dt_ * C + dt_ * dt_ * K;
        const Vec3 pull = dt_ * dt_ * (K * (Ja * velocity_[a] - Jb * velocity_[b]));
        right_[a] -= Ja.transpose() * pull;
        right_[b] += Jb.transpose() * pull;
        diagonal_[a] += Ja.transpose() * D * Ja;
        diagonal_[b] += Jb.transpose() * D * Jb;
        pairs_.push_back({a, b, -Ja.transpose() * D * Jb});
        if (pairs_.size() >= 4096 + 2 * merged_) merge_pairs();
    }

    // One block a pair of frames, in their order.
    void merge_pairs()
    {
        for (Pair& pair : pairs_) {
            if (pair.a <= pair.b) continue;
            std::swap(pair.a, pair.b);
            pair.off.transposeInPlace();
        }
        std::stable_sort(pairs_.begin(), pairs_.end(), [](const Pair& p, const Pair& q) {
            return std::pair(p.a, p.b) < std::pair(q.a, q.b);
        });
        merged_ = 0;
        for (const Pair& pair : pairs_) {
            if (merged_ > 0 && pairs_[merged_ - 1].a == pair.a && pairs_[merged_ - 1].b == pair.b) {
                pairs_[merged_ - 1].off += pair.off;
            } else {
                pairs_[merged_++] = pair;
            }
        }
        pairs_.resize(merged_);
    }

    // Frames that cubes carry go along in x, whatever it has for them.
    void multiply(std::vector<Vec6>& x, std::vector<Vec6>& y) const
    {
        take_along(x);
        for (std::size_t f = 0; f < x.size(); ++f) y[f] = diagonal_[f] * x[f];
        for (const Pair& pair : pairs_) {
            y[pair.a] += pair.off * x[pair.b];
            y[pair.b] += pair.off.transpose() * x[pair.a];
        }
        for (const Stop& stop : stops_) {
            if (!stop.held) continue;
            const double pull = stop.stiffness * stop.speed(x);
            y[stop.a] += pull * stop.along_a;
            y[stop.b] += pull * stop.along_b;
        }
        hand_to_corners(y);
        add_elastic(x, y);
        for (std::size_t f = 0; f < x.size(); ++f) y[f] = free(f, y[f]);
    }

    // Corners as unknowns, with the forces of body b's cubes on them.
    void add_cubes(const LayeredScene& scene, std::size_t b)
    {
        const LayeredPart& part = scene.parts[b];
        const State& state = scene.states[b].cubes;
        Carrier carrier;
        carrier.base = part.body->base.cubes.get();
        carrier.first_frame = first_[b];
        carrier.first_corner = first_corner_[b] = velocity_.size();
        for (std::size_t f = 0; f < part.body->base.frames.size(); ++f) {
            carrier.holds.push_back(carrier.base->hold(f, part.body->base.frames[f], state.x));
        }
        const CornerBody& body = carrier.corner_body();
        carrier.elasticity = elasticity_of(carrier.base->bricks(), state.rotation);
        Aligned<double> force(carrier.elasticity->room(), 0), pull = force;
        carrier.elasticity->forces(by_slot(body, state.x).data(), force.data());
        carrier.elasticity->weigh(dt_ * dt_, dt_);
        carrier.elasticity->multiply(by_slot(body, state.v).data(), pull.data());
        carrier.diagonal.assign(body.numbers, 0);
        carrier.elasticity->add_diagonal(carrier.diagonal.data());
        for (std::size_t k = 0; k < body.corners; ++k) {
            const std::size_t slot = body.slot[k];
            const double drag = dt_ * body.mass_damping[slot];
            Vec6 v = Vec6::Zero(), right = Vec6::Zero();
            for (std::size_t i = 0; i < 3; ++i) {
                const auto axis = static_cast<Eigen::Index>(i);
                v[axis] = state.v[k][axis];
                right[axis] = dt_ * force[4 * slot + i] - pull[4 * slot + i] - drag * v[axis];
            }
            velocity_.push_back(v);
            right_.push_back(right);
            kind_.push_back(BaseKind::particles);
            mass_.push_back(body.mass[slot] * Mat6::Identity());
            diagonal_.push_back((body.mass[slot] + drag) * Mat6::Identity());
        }
        for (const std::uint32_t k : part.pins.corner) {
            kind_[carrier.first_corner + k] = BaseKind::still;
        }
        carriers_.push_back(std::move(carrier));
    }

    // Every carried frame's part of x from its corners'.
    void take_along(std::vector<Vec6>& x) const
    {
        for (const Carrier& carrier : carriers_) {
            for (std::size_t f = 0; f < carrier.holds.size(); ++f) {
                Vec6& twist = x[carrier.first_frame + f];
                twist.setZero();
                const auto corners = carrier.base->corners(f);
                for (std::size_t a = 0; a < corners.size(); ++a) {
                    twist +=
                        carrier.holds[f].by[a] * x[carrier.first_corner + corners[a]].head<3>();
                }
            }
        }
    }

    // What y has for carried frames goes to their corners.
    void hand_to_corners(std::vector<Vec6>& y) const
    {
        for (const Carrier& carrier : carriers_) {
            for (std::size_t f = 0; f < carrier.holds.size(); ++f) {
                Vec6& wrench = y[carrier.first_frame + f];
                const auto corners = carrier.base->corners(f);
                for (std::size_t a = 0; a < corners.size(); ++a) {
                    y[carrier.first_corner + corners[a]].head<3>() +=
                        carrier.holds[f].by[a].transpose() * wrench;
                }
                wrench.setZero();
            }
        }
    }

    // The same of the diagonal's blocks, as far as it stays on the diagonal, and the cubes' own.
    void add_to_corner_blocks(std::vector<Mat6>& blocks) const
    {
        for (const Carrier& carrier : carriers_) {
            for (std::size_t f = 0; f < carrier.holds.size(); ++f) {
                const auto corners = carrier.base->corners(f);
                for (std::size_t a = 0; a < corners.size(); ++a) {
                    const auto& by = carrier.holds[f].by[a];
                    blocks[carrier.first_corner + corners[a]].topLeftCorner<3, 3>() +=
                        by.transpose() * blocks[carrier.first_frame + f] * by;
                }
            }
            const CornerBody& body = carrier.corner_body();
            for (std::size_t k = 0; k < body.corners; ++k) {
                for (int i = 0; i < 3; ++i) {
                    blocks[carrier.first_corner + k](i, i) +=
                        carrier.diagonal[4 * std::size_t{body.slot[k]} + std::size_t(i)];
                }
            }
        }
    }

    // y += (dt C + dt^2 K) x of cubes.
    void add_elastic(const std::vector<Vec6>& x, std::vector<Vec6>& y) const
    {
        for (const Carrier& carrier : carriers_) {
            const CornerBody& body = carrier.corner_body();
            Aligned<double> in(body.numbers, 0), out(carrier.elasticity->room(), 0);
            for (std::size_t k = 0; k < body.corners; ++k) {
                for (std::size_t i = 0; i < 3; ++i) {
                    in[4 * std::size_t{body.slot[k]} + i] =
                        x[carrier.first_corner + k][static_cast<Eigen::Index>(i)];
                }
            }
            carrier.elasticity->multiply(in.data(), out.data());
            for (std::size_t k = 0; k < body.corners; ++k) {
                for (std::size_t i = 0; i < 3; ++i) {
                    y[carrier.first_corner + k][static_cast<Eigen::Index>(i)] +=
                        out[4 * std::size_t{body.slot[k]} + i];
                }
            }
        }
    }

    double dt_;
    std::vector<std::size_t> first_, first_corner_;  // of each body
    std::vector<Vec6> velocity_, right_;
    std::vector<BaseKind> kind_;
    std::vector<Mat6> mass_, diagonal_;
    std::vector<Pair> pairs_;
    std::vector<Stop> stops_;
    std::vector<Carrier> carriers_;
    std::size_t merged_ = 0;
};

// Contact forces, with the stiffness that the layers have there: moved together by x along the
// normal, two layers of slopes s_i and s_j compress by x s_i s_j / (s_i + s_j); a rigid one by x
// s_i.
void add_contacts(const LayeredScene& scene, const LayeredMoment& moment, StepSystem& system)
{
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        for (std::size_t f = 0; f < moment.contacts.wrenches[b].size(); ++f) {
            const Wrench& wrench = moment.contacts.wrenches[b][f];
            system.add_force(system.frame(b, f), wrench.force, wrench.torque);
        }
    }
    for (const LayerContact& contact : moment.contacts.contacts) {
        const ContactLaw law = contact_law(moment.bodies, contact);
        const bool rigid = scene.parts[contact.other].body->matter.rigid;
        const double si = moment.fields[contact.body].profile[contact.skeleton].k;
        const double sj = moment.fields[contact.other].profile[contact.other_skeleton].k;
        const double K = law.stiffness * (rigid ? si : si * sj / (si + sj));
        const double share = rigid ? contact.area : 0.5 * contact.area;
        const Mat3 across = contact.normal * contact.normal.transpose();
        const std::uint32_t fa = scene.parts[contact.body].body->layer.frame[contact.skeleton];
        const std::uint32_t fb =
            scene.parts[contact.other].body->layer.frame[contact.other_skeleton];
        system.add_pair(system.frame(contact.body, fa), system.frame(contact.other, fb),
                        contact.position - moment.frames[contact.body][fa].translation(),
                        contact.position - moment.frames[contact.other][fb].translation(),
                        share * (law.along * Mat3::Identity() + (law.damping - law.along) * across),
                        share * K * across);
    }
}

// Skeletons stay out of other bodies, by a tenth of their thickness; one that stands nearer comes
// out by a fifth of what it lacks each step. Meshes that change their shape come on besides.
void add_stops(const LayeredScene& scene, const LayeredMoment& moment, StepSystem& system)
{
    for (const LayerStop& stop : moment.contacts.stops) {
        const std::uint32_t fa = scene.parts[stop.body].body->layer.frame[stop.skeleton];
        const std::uint32_t fb = scene.parts[stop.other].body->layer.frame[stop.other_skeleton];
        const double clear = stop.gap - 0.1 * moment.fields[stop.body].profile[stop.skeleton].e;
        system.add_stop(system.frame(stop.body, fa), system.frame(stop.other, fb),
                        stop.position - moment.frames[stop.body][fa].translation(),
                        stop.position - moment.frames[stop.other][fb].translation(), stop.normal,
                        clear - 0.8 * std::min(0.0, clear) - stop.closing * system.dt());
    }
}

// A force of size f (positive: apart) and damping c along or against the line from b to a.
void add_central(StepSystem& system, std::size_t a, std::size_t b, const Vec3& line, double f,
                 double stiffness, const Mat3& damping, const Vec3& slip)
{
    const double r = line.norm();
    const Vec3 n = r > 0 ? Vec3(line / r) : Vec3(Vec3::UnitY());
    const Vec3 force = f * n - damping * slip;
    system.add_force(a, force);
    system.add_force(b, -force);
    system.add_pair(a, b, Vec3::Zero(), Vec3::Zero(), damping, stiffness * n * n.transpose());
}

void add_springs(const LayeredScene& scene, std::size_t b, StepSystem& system)
{
    const LayeredState& state = scene.states[b];
    for (const LayerSpring& spring : scene.parts[b].body->base.springs) {
        const Vec3 line = state.position[spring.a] - state.position[spring.b];
        const double r = line.norm();
        const Vec3 n = r > 0 ? Vec3(line / r) : Vec3(Vec3::UnitY());
        add_central(system, system.frame(b, spring.a), system.frame(b, spring.b), line,
                    spring.stiffness * (spring.rest - r), spring.stiffness,
                    spring.damping * n * n.transpose(),
                    state.velocity[spring.a] - state.velocity[spring.b]);
    }
}

// A hinge's two points, half a radius of gyration to either side, are held together by springs so
// stiff that a step leaves a hundredth of what was apart; its limits likewise.
void add_hinges(const LayeredScene& scene, const LayeredMoment& moment, std::size_t b,
                StepSystem& system)
{
    const double dt = system.dt();
    for (const Hinge& hinge : scene.parts[b].body->base.hinges) {
        const Transform& at_a = moment.frames[b][hinge.a];
        const Transform& at_b = moment.frames[b][hinge.b];
        const std::size_t a = system.frame(b, hinge.a), c = system.frame(b, hinge.b);
        const double mass = std::min(system.mass(a)(0, 0), system.mass(c)(0, 0));
        const double inertia = std::min(system.mass(a).bottomRightCorner<3, 3>().trace(),
                                        system.mass(c).bottomRightCorner<3, 3>().trace()) /
                               3;
        const double half = std::sqrt(inertia / mass);
        const double k = 100 * mass / (dt * dt);
        for (const double side : {-half, half}) {
            const Vec3 pa = at_a * (hinge.point_a + side * hinge.axis_a);
            const Vec3 pb = at_b * (hinge.point_b + side * hinge.axis_b);
            const Vec3 arm_a = pa - at_a.translation(), arm_b = pb - at_b.translation();
            const Vec3 force = -k * (pa - pb);
            system.add_force(a, force, arm_a.cross(force));
            system.add_force(c, -force, -arm_b.cross(force));
            system.add_pair(a, c, arm_a, arm_b, Mat3::Zero(), k * Mat3::Identity());
        }
        const Vec3 axis = at_a.linear() * hinge.axis_a;
        const double angle = hinge_angle(hinge, at_a, at_b);
        double stiffness = hinge.stiffness, torque = -hinge.stiffness * (angle - hinge.rest);
        const double beyond = angle > hinge.highest  ? angle - hinge.highest
                              : angle < hinge.lowest ? angle - hinge.lowest
                                                     : 0;
        if (beyond != 0) {
            const double stop = 10 * inertia / (dt * dt);
            stiffness += stop;
            torque -= stop * beyond;
        }
        const Vec3 spin = moment.twists[b][hinge.b].angular - moment.twists[b][hinge.a].angular;
        torque -= hinge.damping * spin.dot(axis);
        system.add_force(c, Vec3::Zero(), torque * axis);
        system.add_force(a, Vec3::Zero(), -torque * axis);
        const Mat3 about = axis * axis.transpose();
        system.add_angular_pair(a, c, hinge.damping * about, stiffness * about);
    }
}

std::vector<std::vector<std::uint32_t>> skeletons_on_frames(const LayeredBody& body)
{
    std::vector<std::vector<std::uint32_t>> on_frame(body.base.frames.size());
    for (std::uint32_t i = 0; i < body.layer.frame.size(); ++i) {
        on_frame[body.layer.frame[i]].push_back(i);
    }
    return on_frame;
}

double weight_between(const Field& field, const std::vector<std::vector<std::uint32_t>>& on_frame,
                      std::size_t p, std::size_t q)
{
    double weight = 0;
    for (const std::uint32_t i : on_frame[p]) {
        for (const std::uint32_t j : on_frame[q]) weight = std::max(weight, field.weights(i, j));
    }
    return weight;
}

void add_particles(const LayeredScene& scene, const LayeredMoment& moment, std::size_t b,
                   StepSystem& system)
{
    const LayeredBody& body = *scene.parts[b].body;
    const LayeredState& state = scene.states[b];
    const Substance& s = body.base.substance;
    const double r0 = s.rest_distance, most = s.reach * r0;
    const auto window = [&](double r) {
        const double u = 1 - r * r / (most * most);
        return u > 0 ? u * u : 0;
    };
    const auto force = [&](double r) {
        const double q = std::pow(r0 / std::max(r, 0.3 * r0), 4);  // bounded where they coincide
        return s.stiffness * (q * q - q) * window(r);
    };
    const auto on_frame = skeletons_on_frames(body);
    for (std::size_t p = 0; p < state.position.size(); ++p) {
        for (std::size_t q = p + 1; q < state.position.size(); ++q) {
            const Vec3 line = state.position[p] - state.position[q];
            const double r = line.norm();
            if (!(r < most)) continue;
            // What has come apart pulls no more; what fuses begins to.
            const double weight = moment.fields[b].rule == geometry::BlendRule::sum
                                      ? 1
                                      : weight_between(moment.fields[b], on_frame, p, q);
            if (!(weight > 0)) continue;
            const double step = 1e-4 * r0;
            const double stiffness =
                std::max(0.0, (force(r - step) - force(r + step)) / (2 * step));
            add_central(system, system.frame(b, p), system.frame(b, q), line, weight * force(r),
                        weight * stiffness, weight * s.friction * window(r) * Mat3::Identity(),
                        state.velocity[p] - state.velocity[q]);
        }
    }
}

// Cubes whose corners go by `dv`, and the frames that they carry. Warns where neighbours part by
// more than a cube in one step: that is more than its linear forces know of.
void move_cubes(const LayeredBody& body, std::span<const Vec6> dv, double dt, LayeredState& state)
{
    const geometry::Cubes& cubes = body.base.cubes->source().cubes;
    for (std::size_t k = 0; k < state.cubes.x.size(); ++k) {
        state.cubes.v[k] += dv[k].head<3>();
        state.cubes.x[k] += dt * state.cubes.v[k];
    }
    state.cubes.time += dt;
    double most = 0;
    for (const auto& corners : cubes.corners) {
        for (const std::uint32_t k : corners) {
            most = std::max(most, (state.cubes.v[k] - state.cubes.v[corners[0]]).norm());
        }
    }
    if (dt * most > cubes.size && state.report.converged) {
        state.report.converged = false;
        state.report.warnings.emplace_back(
            "cubes under a layer are torn along by more than their size in a step; raise substeps");
    }
    follow_cubes(body, state);
}

void move(const LayeredBody& body, std::span<const Vec6> dv, double dt, LayeredState& state)
{
    for (std::size_t f = 0; f < state.position.size(); ++f) {
        state.velocity[f] += dv[f].head<3>();
        state.position[f] += dt * state.velocity[f];
        state.spin[f] += dv[f].tail<3>();
        const Eigen::Quaterniond before(state.rotation[f]);
        const double angle = dt * state.spin[f].norm();
        if (angle > 0) {
            const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, state.spin[f].normalized()));
            state.rotation[f] = (turn * before).normalized().coeffs();
        }
        if (body.base.kind != BaseKind::rigid) continue;
        // The turn keeps the angular momentum, not the spin.
        const Mat3 R = before.toRotationMatrix();
        const Vec3 momentum = R * body.base.inertia[f] * R.transpose() * state.spin[f];
        const Mat3 after = Eigen::Quaterniond(state.rotation[f]).toRotationMatrix();
        state.spin[f] = after * body.base.inertia[f].inverse() * after.transpose() * momentum;
    }
}

// Sends told frames straight, at constant spin, to where they are to be in `left` seconds.
void drive(const std::vector<Transform>& motion, double left, LayeredState& state)
{
    for (std::size_t f = 0; f < state.position.size(); ++f) {
        state.velocity[f] = (motion[f].translation() - state.position[f]) / left;
        const Eigen::Quaterniond now(state.rotation[f]);
        const Eigen::AngleAxisd turn(Eigen::Quaterniond(motion[f].linear()) * now.conjugate());
        const double angle =
            turn.angle() > std::numbers::pi ? turn.angle() - 2 * std::numbers::pi : turn.angle();
        state.spin[f] = angle / left * turn.axis();
    }
}

// Gives pinned corners the velocity that brings them to where they are to be in `left` seconds.
void drive_pins(const LayeredPart& part, double left, LayeredState& state)
{
    if (part.pins.corner.empty()) return;
    for (std::size_t i = 0; i < part.pins.corner.size(); ++i) {
        const std::uint32_t k = part.pins.corner[i];
        state.cubes.v[k] = (part.pins.target[i] - state.cubes.x[k]) / left;
    }
    follow_cubes(*part.body, state);
}

std::vector<float> pressed_distances(const LayeredMoment& moment, std::uint32_t body)
{
    const SeedWalk& walk = moment.walks[body];
    std::vector<float> pressed(walk.distance.size());
    for (std::size_t i = 0; i < pressed.size(); ++i) {
        pressed[i] = static_cast<float>(walk.valid[i] ? walk.distance[i] : -1);
    }
    for (const LayerContact& contact : moment.contacts.contacts) {
        if (contact.body == body) pressed[contact.seed] = static_cast<float>(contact.distance);
    }
    return pressed;
}

// What the walk saw of body number b.
void keep_seen(const LayeredMoment& moment, std::uint32_t b, LayeredState& state)
{
    state.distance = moment.walks[b].distance;
    state.pressed = pressed_distances(moment, b);
    state.volume = local_volumes(moment.bodies, b, moment.contacts);
    state.penetration = std::max(state.penetration, moment.contacts.penetration[b]);
}

// What a part is told to seek of each territory's volume, on the way from one frame to the next.
std::vector<double> sought(const LayeredPart& from, const LayeredPart& to, double share)
{
    std::vector<double> result;
    for (std::size_t s = 0; s < to.body->layer.skeletons.size(); ++s) {
        result.push_back(from.sought(s) + (to.sought(s) - from.sought(s)) * share);
    }
    return result;
}

// Moves the contributions as the controllers of `control` do in dt seconds, in which the inflation
// sought goes from state.inflation to `after`.
void keep_volume(const LayeredBody& body, const VolumeControl& control, const SeedWalk& walk,
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

double volume_error(const LayeredBody& body, const LayeredState& state)
{
    if (!(body.control.proportional > 0) || state.volume.empty()) return 0;
    const double target =
        std::inner_product(body.volume.begin(), body.volume.end(), state.inflation.begin(), 0.0);
    const double now = std::accumulate(state.volume.begin(), state.volume.end(), 0.0);
    return std::abs(now / target - 1);
}

// The last step's motion has changed volumes since the controllers saw them. Mends that before
// anybody looks, by Newton steps in which nothing moves; leaves what the last walk saw.
void settle_volumes(LayeredScene& now, double mesh_seconds)
{
    constexpr int most_rounds = 3;
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
        if (!(worst > enough) || round == most_rounds) return;
        for (std::size_t b = 0; b < now.parts.size(); ++b) {
            if (!(volume_error(*now.parts[b].body, now.states[b]) > enough)) continue;
            constexpr double at_once = std::numeric_limits<double>::infinity();
            keep_volume(*now.parts[b].body, {at_once, 0}, moment.walks[b], now.states[b].inflation,
                        1, now.states[b]);
        }
    }
}

// Parts of a soft substance. A part falls into what chains of overlapping spheres of influence hold
// together; what once came apart comes together by fusion only. Where two parts press harder than
// the threshold, the pair of skeletons there starts to blend, over `fusion_time`; from the first
// pair that blends fully the others in reach follow; parts of which all pairs in reach blend fully
// become one, which changes nothing in the field.
void update_parts(const LayeredBody& body, std::uint32_t number, const LayeredMoment& moment,
                  double dt, LayeredState& state)
{
    const Field& field = moment.fields[number];
    const Substance& substance = body.base.substance;
    const auto n = static_cast<std::uint32_t>(field.count());
    const auto centre = [&](std::uint32_t i) { return field.points[field.first[i]]; };
    const auto in_reach = [&](std::uint32_t i, std::uint32_t j) {
        return (centre(i) - centre(j)).norm() < field.profile[i].R + field.profile[j].R;
    };

    // Separation.
    std::vector<std::uint32_t> root(n);
    std::iota(root.begin(), root.end(), 0u);
    const auto find = [&](std::uint32_t i) {
        while (root[i] != i) i = root[i] = root[root[i]];
        return i;
    };
    const auto join = [&](std::uint32_t i, std::uint32_t j) {
        const std::uint32_t a = find(i), b = find(j);
        root[std::max(a, b)] = std::min(a, b);
    };
    for (std::uint32_t i = 0; i < n; ++i) {
        for (std::uint32_t j = i + 1; j < n; ++j) {
            if (state.part[i] == state.part[j] && in_reach(i, j)) join(i, j);
        }
    }

    // Fusion: links that still matter, grown; new ones where it presses hard enough.
    std::vector<BlendLink> links;
    for (BlendLink link : state.links) {
        if (!in_reach(link.a, link.b)) continue;
        link.weight =
            substance.fusion_time > 0 ? std::min(1.0, link.weight + dt / substance.fusion_time) : 1;
        links.push_back(link);
    }
    const auto add_link = [&](std::uint32_t i, std::uint32_t j) {
        if (i > j) std::swap(i, j);
        if (find(i) == find(j)) return;
        for (const BlendLink& link : links) {
            if (link.a == i && link.b == j) return;
        }
        links.push_back({i, j, substance.fusion_time > 0 ? 1e-3 : 1});
    };
    for (const LayerContact& contact : moment.contacts.contacts) {
        if (contact.body == number && contact.other == number &&
            body.matter.stiffness * contact.compression > substance.fusion_threshold) {
            add_link(contact.skeleton, contact.other_skeleton);
        }
    }
    const std::vector<BlendLink> begun = links;
    for (const BlendLink& full : begun) {
        if (full.weight < 1) continue;
        bool whole = true;
        const std::uint32_t A = find(full.a), B = find(full.b);
        if (A == B) continue;
        for (std::uint32_t i = 0; i < n; ++i) {
            if (find(i) != A) continue;
            for (std::uint32_t j = 0; j < n; ++j) {
                if (find(j) != B || !in_reach(i, j)) continue;
                add_link(i, j);
                const auto linked =
                    std::find_if(links.begin(), links.end(), [&](const BlendLink& l) {
                        return l.a == std::min(i, j) && l.b == std::max(i, j);
                    });
                whole &= linked != links.end() && linked->weight >= 1;
            }
        }
        if (whole) join(A, B);
    }
    for (std::uint32_t i = 0; i < n; ++i) state.part[i] = find(i);
    std::erase_if(links, [&](const BlendLink& l) { return state.part[l.a] == state.part[l.b]; });
    state.links = std::move(links);
}

// A frame's layer on its way through a frame of the film: a ball that goes straight, or a half
// space.
struct Mover {
    Vec3 from = Vec3::Zero();    // m, its middle; a point of a half space's edge
    Vec3 way = Vec3::Zero();     // m, how far that goes
    Vec3 normal = Vec3::Zero();  // of a half space; else 0
    double reach = 0;            // m, from the middle to where its influence ends
    double turn = 0;             // rad
    double stray = 0;            // m, how far its points go besides: they turn, or change shape
    Box box;                     // m, that a ball's influence stays in
};

// What these skeletons of a frame take up, in its axes; `plane`: one of them that has no end.
Box box_of(const LayeredBody& body, std::span<const std::uint32_t> skeletons, double& reach,
           const Skeleton*& plane)
{
    Box box;
    for (const std::uint32_t s : skeletons) {
        const Skeleton& skeleton = body.layer.skeletons[s];
        reach = std::max(reach, body.layer.contributions[s].radius);
        if (skeleton.kind == SkeletonKind::plane) plane = &skeleton;
        for (const Vec3& p : skeleton.points) box.add(p);
        if (!skeleton.points.empty()) continue;
        Box own;
        own.add(-skeleton.half_size);
        own.add(skeleton.half_size);
        if (skeleton.mesh) own = geometry::bounds(skeleton.mesh->mesh);
        const Vec3 centre = skeleton.place * own.centre();
        box.add(centre - Vec3::Constant(0.5 * own.diagonal()));
        box.add(centre + Vec3::Constant(0.5 * own.diagonal()));
    }
    return box;
}

Mover mover_of(const LayeredPart& part, const LayeredState& state, std::size_t f,
               std::span<const std::uint32_t> skeletons, const std::vector<Transform>& told,
               const Vec3& gravity, double dt)
{
    Mover mover;
    const Skeleton* plane = nullptr;
    const Box box = box_of(*part.body, skeletons, mover.reach, plane);
    const Eigen::Quaterniond now(state.rotation[f]);
    const Vec3 arm = now * (plane ? Vec3(plane->place.translation()) : box.centre());
    mover.from = state.position[f] + arm;
    if (told.empty()) {
        mover.turn = dt * state.spin[f].norm();
        mover.way = dt * (state.velocity[f] + dt * gravity + state.spin[f].cross(arm));
    } else {
        mover.turn = now.angularDistance(Eigen::Quaterniond(told[f].linear()));
        mover.way = told[f] * (now.conjugate() * arm) - mover.from;
    }
    if (plane) {
        mover.normal = now * plane->place.linear().col(1);
        return mover;
    }
    mover.reach += 0.5 * box.diagonal();
    mover.stray = 0.5 * box.diagonal() * mover.turn;
    if (part.mesh_before) {
        const Box before = geometry::bounds(*part.mesh_before);
        const auto& after = part.body->layer.skeletons[0].mesh->mesh.positions;
        mover.from = before.centre();
        mover.way = box.centre() - mover.from;
        mover.reach =
            std::max(mover.reach, mover.reach + 0.5 * (before.diagonal() - box.diagonal()));
        for (std::size_t v = 0; v < after.size(); ++v) {
            const Vec3 way = (after[v] - part.mesh_before->positions[v]).cast<double>();
            mover.stray = std::max(mover.stray, (way - mover.way).norm());
        }
    }
    const Vec3 around = Vec3::Constant(mover.reach + mover.stray);
    for (const Vec3& at : {mover.from, Vec3(mover.from + mover.way)}) {
        mover.box.add(at - around);
        mover.box.add(at + around);
    }
    return mover;
}

// How much nearer a ball may come to another mover in the frame of the film, m; 0 where they stay
// apart.
double approach(const Mover& a, const Mover& b)
{
    if (b.normal.squaredNorm() > 0) {
        const double apart = (a.from - b.from).dot(b.normal) - a.reach - b.reach;
        const double tilt = b.turn * (a.from - b.from).norm();
        const double closing = (b.way - a.way).dot(b.normal) + a.stray + tilt;
        return closing > apart ? std::max(0.0, closing) : 0;
    }
    const bool meet = (a.box.lo.array() <= b.box.hi.array()).all() &&
                      (b.box.lo.array() <= a.box.hi.array()).all();
    return meet ? (a.way - b.way).norm() + a.stray + b.stray : 0;
}

// As many equal steps as were asked for, or as it takes for what may touch a soft layer to come on
// by no more than two fifths of it in each: a skeleton's stop sees it coming on the inner half.
int choose_steps(LayeredScene& now, const Vec3& gravity, double dt, int asked)
{
    constexpr double share = 0.4;
    constexpr int most_times = 64;
    const std::size_t n = now.parts.size();
    std::vector<std::vector<Mover>> movers(n);
    std::vector<double> thinnest(n, std::numeric_limits<double>::infinity());  // of soft layers
    for (std::size_t b = 0; b < n; ++b) {
        const LayeredBody& body = *now.parts[b].body;
        const std::vector<Transform> told =
            is_told(body.base.kind) ? told_frames(now.parts[b]) : std::vector<Transform>();
        const auto on_frame = skeletons_on_frames(body);
        for (std::size_t f = 0; f < on_frame.size(); ++f) {
            if (on_frame[f].empty()) continue;
            movers[b].push_back(
                mover_of(now.parts[b], now.states[b], f, on_frame[f], told, gravity, dt));
        }
        if (body.matter.rigid || body.seeds.count() == 0) continue;
        for (const geometry::Contribution& c : body.layer.contributions) {
            thinnest[b] = std::min(thinnest[b], c.thickness);
        }
    }
    // How many steps body i, a soft one, needs beside j.
    const auto needed = [&](std::size_t i, std::size_t j) {
        double most = 0;
        for (const Mover& a : movers[i]) {
            if (a.normal.squaredNorm() > 0) continue;
            for (const Mover& b : movers[j]) most = std::max(most, approach(a, b));
        }
        return most / (share * std::min(thinnest[i], thinnest[j]));
    };
    double wanted = asked;
    for (std::size_t i = 0; i < n; ++i) {
        if (!std::isfinite(thinnest[i])) continue;
        for (std::size_t j = 0; j < n; ++j) {
            const bool both_still = now.parts[i].body->base.kind == BaseKind::still &&
                                    now.parts[j].body->base.kind == BaseKind::still;
            if (i == j || both_still || (j < i && std::isfinite(thinnest[j]))) continue;
            const double steps = needed(i, j);
            if (steps > most_times * asked) {
                now.states[i].report.warnings.push_back(fmt::format(
                    "bodies {} and {} may pass through each other: they come on by {:.2g} of a "
                    "layer's thickness in a step, even in {} steps a frame; slow them down or "
                    "raise substeps",
                    i, j, share * steps / (most_times * asked), most_times * asked));
            }
            wanted = std::max(wanted, std::min<double>(steps, most_times * asked));
        }
    }
    return static_cast<int>(std::ceil(wanted));
}

// Puts meshes that change their shape to where they are after so many of the frame's steps, with
// where they were, or would have been, a step before. `told` has them at its end, `last` as the
// frame began.
void move_meshes(LayeredScene& now, const LayeredScene& last, const std::vector<LayeredPart>& told,
                 int step, int steps)
{
    for (std::size_t b = 0; b < told.size(); ++b) {
        if (!told[b].mesh_before) continue;
        geometry::TriMesh mesh = told[b].body->layer.skeletons[0].mesh->mesh;
        geometry::TriMesh earlier = mesh;
        const float each = 1 / static_cast<float>(steps), done = each * static_cast<float>(step);
        for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
            const geometry::Vec3f& from = told[b].mesh_before->positions[v];
            const geometry::Vec3f way = mesh.positions[v] - from;
            mesh.positions[v] = from + done * way;
            earlier.positions[v] = mesh.positions[v] - each * way;
        }
        const std::vector<Skeleton>& before = last.parts[b].body->layer.skeletons;
        const bool ready = !before.empty() && before[0].mesh &&
                           before[0].mesh->mesh.positions == mesh.positions &&
                           before[0].mesh->mesh.topology == mesh.topology;
        LayeredBody body = *told[b].body;
        body.layer.skeletons[0].mesh =
            ready ? before[0].mesh
                  : std::make_shared<const geometry::SkeletonMesh>(std::move(mesh));
        now.parts[b].body = std::make_shared<const LayeredBody>(std::move(body));
        now.parts[b].mesh_before = std::make_shared<const geometry::TriMesh>(std::move(earlier));
    }
}

bool same_cubes(const LayeredPart& part, const LayeredState& state)
{
    const auto& cubes = part.body->base.cubes;
    return state.cubes.x.size() == (cubes ? cubes->source().cubes.corner_count() : 0) &&
           state.cubes.v.size() == state.cubes.x.size();
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
    bool same = parts.size() == scene.states.size();
    for (std::size_t b = 0; same && b < parts.size(); ++b) {
        same = parts[b].body->base.frames.size() == scene.states[b].position.size() &&
               parts[b].body->layer.skeletons.size() == scene.states[b].translation.size() &&
               told_frames(parts[b]).size() == scene.states[b].position.size() &&
               same_cubes(parts[b], scene.states[b]) &&
               (parts[b].muscle.empty() ||
                parts[b].muscle.size() == scene.states[b].translation.size()) &&
               (scene.states[b].distance.empty() ||
                scene.states[b].distance.size() == parts[b].body->seeds.count());
    }
    if (!same) {
        throw std::invalid_argument(
            fmt::format("layered bodies changed while they moved: a scene of {} goes on with the "
                        "same bodies, frames and skeletons, got {}",
                        scene.states.size(), parts.size()));
    }
    const std::vector<LayeredPart> told = parts;
    LayeredScene now{std::move(parts), scene.states};
    for (LayeredState& state : now.states) {
        state.report = {};
        state.penetration = 0;
    }
    if (!(dt > 0)) return now;
    const int steps = choose_steps(now, world.gravity, dt, std::max(1, substeps));
    const double h = dt / steps;
    for (int substep = 0; substep < steps; ++substep) {
        const double left = dt - h * substep;
        for (std::size_t b = 0; b < now.parts.size(); ++b) {
            drive_pins(now.parts[b], left, now.states[b]);
            if (!is_told(now.parts[b].body->base.kind)) continue;
            drive(told_frames(now.parts[b]), left, now.states[b]);
        }
        move_meshes(now, scene, told, substep, steps);
        const LayeredMoment moment(now, h);
        StepSystem system(now, moment, h);
        add_contacts(now, moment, system);
        add_stops(now, moment, system);
        for (std::size_t b = 0; b < now.parts.size(); ++b) {
            const LayeredBody& body = *now.parts[b].body;
            if (is_told(body.base.kind)) continue;
            const std::size_t corners = now.states[b].cubes.x.size();
            const std::size_t begin = corners > 0 ? system.corner(b, 0) : system.frame(b, 0);
            const std::size_t count = corners > 0 ? corners : body.base.frames.size();
            for (std::size_t f = begin; f < begin + count; ++f) {
                system.add_force(f, system.mass(f)(0, 0) * world.gravity);
                if (world.drag > 0) system.add_drag(f, world.drag);
            }
            add_springs(now, b, system);
            add_hinges(now, moment, b, system);
            if (body.base.kind == BaseKind::particles) add_particles(now, moment, b, system);
        }
        Report report;
        const std::vector<Vec6> dv = system.solve(report);
        for (std::uint32_t b = 0; b < now.parts.size(); ++b) {
            const LayeredBody& body = *now.parts[b].body;
            LayeredState& state = now.states[b];
            const std::size_t begin = system.frame(b, 0);
            const auto inflation = [&](int at) {
                return sought(scene.parts[b], told[b], static_cast<double>(at) / steps);
            };
            keep_seen(moment, b, state);
            state.inflation = inflation(substep);
            keep_volume(body, body.control, moment.walks[b], inflation(substep + 1), h, state);
            if (body.base.kind == BaseKind::particles &&
                body.layer.blend.rule != geometry::BlendRule::sum) {
                update_parts(body, b, moment, h, state);
            }
            if (body.base.cubes) {
                state.cubes.rotation = system.rotations(b);
                move_cubes(body, std::span(dv).subspan(system.corner(b, 0)), h, state);
            } else {
                move(body, std::span(dv).subspan(begin, state.position.size()), h, state);
            }
            state.time += h;
            state.report.steps += 1;
            state.report.iterations += report.iterations;
            state.report.converged &= report.converged;
        }
    }
    now.parts = told;
    // Still frames end exactly where they were told to.
    for (std::size_t b = 0; b < now.parts.size(); ++b) {
        if (now.parts[b].body->base.kind != BaseKind::still) continue;
        const std::vector<Transform> at = told_frames(now.parts[b]);
        for (std::size_t f = 0; f < at.size(); ++f) {
            now.states[b].position[f] = at[f].translation();
            now.states[b].rotation[f] = Eigen::Quaterniond(at[f].linear()).normalized().coeffs();
        }
    }
    settle_volumes(now, dt);
    return now;
}

double volume_error(const LayeredScene& scene)
{
    double worst = 0;
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        worst = std::max(worst, volume_error(*scene.parts[b].body, scene.states[b]));
    }
    return worst;
}

}  // namespace physics
