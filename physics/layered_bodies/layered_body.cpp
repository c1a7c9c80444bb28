#include "physics/layered_bodies/layered_body.hpp"

#include "geometry/base/numbering.hpp"
#include "geometry/fields/round_skeleton.hpp"
#include "geometry/fields/skeleton_mesh.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/same_triangles.hpp"
#include "physics/layered_bodies/own_core.hpp"
#include "physics/layers/layer_contact.hpp"
#include "physics/layers/velocity_at.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <optional>
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

// A torus has moments in closed form. Of a cylinder or cone, three Gauss points up the axis are
// exact for slices whose moments are polynomials of degree 4 in y.
void add_round_core(const Skeleton& s, Moments& m)
{
    const geometry::RoundShape c = geometry::round_shape(s.kind, s.half_size);
    constexpr double pi = std::numbers::pi;
    const Mat3 turn = s.place.linear();
    const auto add_about = [&](double y, double volume, double across, double along) {
        m.add(s.place * Vec3(0, y, 0), volume);
        const Vec3 own = volume * Vec3(across, along, across);
        m.second += turn * own.asDiagonal() * turn.transpose();
    };
    if (s.kind == SkeletonKind::torus) {
        const double tube_sq = c.tube * c.tube, volume = 2 * pi * pi * c.ring * tube_sq;
        return add_about(0, volume, c.ring * c.ring / 2 + 3 * tube_sq / 8, tube_sq / 4);
    }
    const double at[] = {-std::sqrt(0.6), 0, std::sqrt(0.6)},
                 weight[] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
    for (std::size_t i = 0; i < 3; ++i) {
        const double r = 0.5 * (c.base + c.top + at[i] * (c.top - c.base));
        add_about(at[i] * c.height, c.height * weight[i] * pi * r * r, r * r / 4, 0);
    }
}

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
    if (geometry::is_round(s.kind)) {
        m.add(centre, -volume);
        return add_round_core(s, m);
    }
    const double share = s.kind == SkeletonKind::box ? 1.0 / 3 : 1.0 / 5;
    const Mat3 turn = s.place.linear();
    const Vec3 own = volume * share * s.half_size.cwiseAbs2();
    m.second += turn * own.asDiagonal() * turn.transpose();
}

// What every body has as it is drawn, before its frames have places and masses.
struct DrawnBody {
    LayeredBody body;
    SampleWalk walk;
    std::vector<OwnCore> cores;  // S
};

// What a frame's territories hold, from the rays of their samples; three Gauss points a ray are
// exact.
std::vector<Moments> moments_of_frames(const ImplicitLayer& layer, const DrawnBody& drawn,
                                       std::size_t frames)
{
    const SurfaceSamples& samples = drawn.body.samples;
    std::vector<Moments> moments(frames);
    const double g = std::sqrt(0.6);
    const double at[] = {0.5 * (1 - g), 0.5, 0.5 * (1 + g)},
                 weight[] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    for (std::size_t s = 0; s < layer.skeletons.size(); ++s) {
        Moments& m = moments[layer.frame[s]];
        for (std::size_t i = samples.first[s]; i < samples.first[s + 1]; ++i) {
            const double d = drawn.walk.distance[i];
            for (int k = 0; k < 3; ++k) {
                const double t = at[k] * d;
                m.add(samples.origin[i] + t * samples.direction[i],
                      weight[k] * d * samples.crossed(i, t));
            }
        }
        const OwnCore& core = drawn.cores[s];
        if (core.is_whole()) {
            add_core(layer.skeletons[s], samples.core[s], m);
            continue;
        }
        const double each = samples.core[s] / static_cast<double>(core.points.size());
        for (const Vec3& p : core.points) m.add(p, each);
    }
    return moments;
}

// Gives each frame mass, centre and inertia from what its territories hold.
void set_masses(const ImplicitLayer& layer, const DrawnBody& drawn, double density, Base& base)
{
    const std::vector<Moments> moments = moments_of_frames(layer, drawn, base.frames.size());
    for (std::size_t f = 0; f < base.frames.size(); ++f) {
        const Moments& m = moments[f];
        if (!(m.volume > 0)) {
            throw std::invalid_argument(fmt::format(
                "frame {} of the layered body has no volume of its own: its skeletons all lie "
                "inside "
                "those of other frames, or are planes. Set base to still, or move them apart",
                f));
        }
        const Vec3 centre = m.first / m.volume;
        base.frames[f].translation() = centre;
        base.mass[f] = density * m.volume;
        const Mat3 second = density * (m.second - m.volume * centre * centre.transpose());
        base.inertia[f] = second.trace() * Mat3::Identity() - second;
    }
}

// A particle is where its skeleton is.
void set_particles(const ImplicitLayer& layer, Base& base)
{
    for (std::size_t s = layer.skeletons.size(); s-- > 0;) {
        const Skeleton& skeleton = layer.skeletons[s];
        if (skeleton.kind != SkeletonKind::point) {
            throw std::invalid_argument(fmt::format(
                "particles carry point skeletons only. Make skeleton {} (counted from 0) a "
                "point, or choose another base",
                s));
        }
        base.frames[layer.frame[s]].translation() = skeleton.points[0];
    }
}

// Skeletons and samples, drawn in the world, into their frames.
void move_into_frames(const Base& base, ImplicitLayer& layer, SurfaceSamples& samples)
{
    for (std::size_t s = 0; s < layer.skeletons.size(); ++s) {
        const Vec3 to = -base.frames[layer.frame[s]].translation();
        for (Vec3& p : layer.skeletons[s].points) p += to;
        layer.skeletons[s].place.pretranslate(to);
        for (std::size_t i = samples.first[s]; i < samples.first[s + 1]; ++i)
            samples.origin[i] += to;
    }
}

// Of each territory, on the surface that is drawn.
std::vector<double> rest_volumes(const Field& field, const SurfaceSamples& samples,
                                 const SampleWalk& walk, std::span<const Transform> frames,
                                 std::span<const std::uint32_t> frame_of)
{
    const std::vector<Twist> still(frames.size());
    const ContactBody body{&field, &samples, &walk, frames, still, frame_of, LayerMatter{}};
    return local_volumes({&body, 1}, 0, find_contacts({&body, 1}));
}

DrawnBody draw_body(const ImplicitLayer& layer, BaseKind kind, double density,
                    double sample_spacing)
{
    if (!(density > 0) || !std::isfinite(density)) {
        throw std::invalid_argument(
            fmt::format("density must be above 0 kg/m^3, got {}.", density));
    }
    std::size_t frames = 0;
    for (const std::uint32_t f : layer.frame) frames = std::max<std::size_t>(frames, f + 1);
    const std::vector<Transform> drawn(frames, Transform::Identity());

    DrawnBody out;
    LayeredBody& body = out.body;
    const Field field = geometry::make_field(layer, drawn);
    body.samples = make_surface_samples(layer, sample_spacing);
    if (body.samples.count() > 0) body.sample_spacing = sample_spacing;
    for (std::uint32_t s = 0; s < layer.skeletons.size(); ++s) {
        out.cores.push_back(own_core(field, s));
        body.samples.core[s] *= out.cores.back().share();
    }
    out.walk = physics::walk(field, body.samples, drawn);
    body.volume = rest_volumes(field, body.samples, out.walk, drawn, layer.frame);
    body.base.kind = kind;
    body.base.frames = drawn;
    body.base.mass.assign(frames, 0);
    body.base.inertia.assign(frames, Mat3::Identity());
    body.matter.rigid = false;
    return out;
}

// Gives each skeleton of a net its frames: a number for every place of its points, and after those
// one for each segment and triangle. Returns the places.
std::vector<Vec3> set_net_frames(ImplicitLayer& layer, std::vector<NetSpan>& spans)
{
    geometry::Numbering<6> places;
    std::vector<Vec3> at;
    std::vector<std::uint32_t> span_of(layer.skeletons.size(), geometry::no_index);
    for (std::size_t s = 0; s < layer.skeletons.size(); ++s) {
        const Skeleton& skeleton = layer.skeletons[s];
        const bool carried =
            skeleton.kind == SkeletonKind::segment || skeleton.kind == SkeletonKind::triangle;
        if (!carried && skeleton.kind != SkeletonKind::point) {
            throw std::invalid_argument(fmt::format(
                "a net carries points, segments and triangles only. Make skeleton {} (counted from "
                "0) one of those, a line of several segments for example, or choose another base",
                s));
        }
        NetSpan span;
        for (const Vec3& p : skeleton.points) {
            std::array<std::uint32_t, 6> key;
            for (std::size_t k = 0; k < 3; ++k) {
                const auto bits =
                    std::bit_cast<std::uint64_t>(p[static_cast<Eigen::Index>(k)] + 0.0);  // -0 is 0
                key[2 * k] = static_cast<std::uint32_t>(bits);
                key[2 * k + 1] = static_cast<std::uint32_t>(bits >> 32);
            }
            span.masses.push_back(places.add(key));
            if (span.masses.back() == at.size()) at.push_back(p);
        }
        layer.frame[s] = span.masses[0];
        if (!carried) continue;
        span_of[s] = static_cast<std::uint32_t>(spans.size());
        spans.push_back(std::move(span));
    }
    for (std::size_t s = 0; s < span_of.size(); ++s) {
        if (span_of[s] == geometry::no_index) continue;
        layer.frame[s] = static_cast<std::uint32_t>(at.size()) + span_of[s];
    }
    return at;
}

void set_net_masses(const ImplicitLayer& layer, const DrawnBody& drawn, double density, Base& base)
{
    const SurfaceSamples& samples = drawn.body.samples;
    const std::size_t masses = mass_count(base);
    for (std::size_t s = 0; s < layer.skeletons.size(); ++s) {
        const std::uint32_t f = layer.frame[s];
        for (std::size_t i = samples.first[s]; i < samples.first[s + 1]; ++i) {
            const double mass = density * samples.swept(i, drawn.walk.distance[i]);
            const Vec3 share = shares_at(layer.skeletons[s].points, samples.origin[i]);
            if (f < masses) {
                base.mass[f] += mass;
                continue;
            }
            const std::vector<std::uint32_t>& on = base.spans[f - masses].masses;
            for (std::size_t k = 0; k < on.size(); ++k) {
                base.mass[on[k]] += mass * share[static_cast<Eigen::Index>(k)];
            }
        }
    }
    for (std::size_t m = 0; m < masses; ++m) {
        if (base.mass[m] > 0) continue;
        const Vec3& at = base.frames[m].translation();
        throw std::invalid_argument(fmt::format(
            "the mass of the net at ({:.4g}, {:.4g}, {:.4g}) has no volume of its own: its "
            "skeletons lie inside others there. Move them apart, or make their layer thinner",
            at.x(), at.y(), at.z()));
    }
}

// Of a segment or triangle that has no length or area.
void check_spans(const ImplicitLayer& layer)
{
    for (std::size_t s = 0; s < layer.skeletons.size(); ++s) {
        const std::vector<Vec3>& p = layer.skeletons[s].points;
        if (p.size() < 2) continue;
        const Vec3 side = p[1] - p[0];
        double size = side.norm(), longest = size;
        if (p.size() == 3) {
            longest = std::max({longest, (p[2] - p[0]).norm(), (p[2] - p[1]).norm()});
            size = longest > 0 ? side.cross(p[2] - p[0]).norm() / longest : 0;
        }
        if (size > 1e-6 * longest) continue;
        throw std::invalid_argument(
            fmt::format("skeleton {} (counted from 0) of the net has no {}: move its points apart",
                        s, p.size() == 3 ? "area" : "length"));
    }
}

}  // namespace

LayeredBody make_net_body(ImplicitLayer layer, double density, double sample_spacing)
{
    for (const Skeleton& skeleton : layer.skeletons) geometry::check(skeleton);
    layer.frame.assign(layer.skeletons.size(), 0);
    std::vector<NetSpan> spans;
    const std::vector<Vec3> places = set_net_frames(layer, spans);
    check_spans(layer);
    DrawnBody drawn = draw_body(layer, BaseKind::net, density, sample_spacing);
    Base& base = drawn.body.base;
    base.frames.resize(places.size() + spans.size(), Transform::Identity());
    base.mass.resize(base.frames.size(), 0);
    base.inertia.resize(base.frames.size(), Mat3::Identity());
    base.spans = std::move(spans);
    for (std::size_t m = 0; m < places.size(); ++m) base.frames[m].translation() = places[m];
    for (std::size_t i = 0; i < base.spans.size(); ++i) {
        Vec3 sum = Vec3::Zero();
        for (const std::uint32_t m : base.spans[i].masses) sum += places[m];
        base.frames[places.size() + i].translation() =
            sum / static_cast<double>(base.spans[i].masses.size());
    }
    set_net_masses(layer, drawn, density, base);
    move_into_frames(base, layer, drawn.body.samples);
    drawn.body.layer = std::move(layer);
    return std::move(drawn.body);
}

LayeredBody make_layered_body(ImplicitLayer layer, BaseKind kind, double density,
                              double sample_spacing)
{
    DrawnBody drawn = draw_body(layer, kind, density, sample_spacing);
    LayeredBody& body = drawn.body;
    if (!is_told(kind)) {
        set_masses(layer, drawn, density, body.base);
        if (kind == BaseKind::particles) set_particles(layer, body.base);
        move_into_frames(body.base, layer, body.samples);
    }
    body.layer = std::move(layer);
    return std::move(drawn.body);
}

void let_separate(ImplicitLayer& layer, LayerMatter& matter)
{
    matter.self_contact = true;
    if (layer.blend.rule != geometry::BlendRule::sum) return;
    layer.blend.rule = geometry::BlendRule::smooth_groups;
    layer.blend.part.assign(layer.skeletons.size(), 0);
    layer.blend.links.clear();
}

void set_on_cubes(LayeredBody& body, geometry::Cubes cubes, const BrickOptions& options)
{
    if (body.base.kind != BaseKind::still) {
        throw std::invalid_argument(
            "a layer on cubes must have base = still: the cubes supply its mass");
    }
    CubeBase::Source source{std::move(cubes), options, {}};
    source.frames = bind_frames(body.base.frames, body.samples, source.cubes);
    body.base.cubes = std::make_shared<const CubeBase>(std::move(source));
    body.base.kind = BaseKind::carried;
}

LayeredPart rigid_part(const Collider& collider)
{
    // Rounded by a tenth of its size; only f = c and its slope there matter to others.
    Skeleton skeleton{.kind = SkeletonKind::plane, .points = {}};
    double e = 0.1;
    std::optional<double> thickness;  // m, of the layer: e
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
        if (!collider.mesh) throw std::invalid_argument("the mesh collider has no mesh");
        skeleton.kind = SkeletonKind::mesh;
        skeleton.mesh = std::make_shared<const geometry::SkeletonMesh>(*collider.mesh);
        e = std::max(collider.thickness, 1e-3 * geometry::bounds(*collider.mesh).diagonal());
        // No slope of what is rigid may be as steep as a collider is thin, but its surface stands
        // where it says; a layer has some thickness.
        thickness = std::max(collider.thickness, 1e-6 * e);
    }
    const double surface = thickness.value_or(e);
    LayeredBody body;
    body.layer.skeletons = {skeleton};
    body.layer.contributions = {
        {.thickness = surface, .stiffness = 1 / e, .radius = surface + 2 * e}};
    body.layer.frame = {0};
    body.samples.first = {0, 0};
    body.samples.core = {0};
    body.samples.frame = {0};
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
    } else if (geometry::has_moved(collider.mesh_before.get(), *collider.mesh)) {
        part.mesh_before = collider.mesh_before;
    }
    return part;
}

}  // namespace physics
