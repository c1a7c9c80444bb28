#include "physics/layered_bodies/layer_skin.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/normals.hpp"
#include "physics/layered_bodies/layered_moment.hpp"
#include "physics/layered_bodies/mean_value_rings.hpp"
#include "physics/layers/deformed_layer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace physics {
namespace {

using geometry::TriMesh;
using geometry::Vec3f;

constexpr std::size_t skin_grain = 256;

std::vector<std::uint32_t> vertices_of_normals(const TriMesh& mesh)
{
    std::vector<std::uint32_t> vertex(mesh.normals.size(), geometry::no_index);
    const auto& topology = *mesh.topology;
    for (std::size_t t = 0; t < topology.normal_triangles.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            vertex[topology.normal_triangles[t][k]] = topology.triangles[t][k];
        }
    }
    return vertex;
}

struct Pull {
    std::uint32_t frame;
    double f;
};

// Who reaches p, by frame, the strongest first; the nearest skeleton's frame with f = 0 when
// nobody.
void find_reach(const Field& field, std::span<const std::uint32_t> frame_of, const Vec3& p,
                std::vector<Pull>& out)
{
    out.clear();
    double nearest = std::numeric_limits<double>::infinity();
    std::uint32_t owner = frame_of[0];
    for (std::uint32_t s = 0; s < field.count(); ++s) {
        const geometry::Foot foot = geometry::foot(field, s, p);
        if (const double gap = geometry::surface_gap(field, s, foot); gap < nearest) {
            nearest = gap;
            owner = frame_of[s];
        }
        const double f = geometry::profile_at(field.profile[s], foot.r).f;
        if (!(f > 0)) continue;
        const auto same = std::find_if(out.begin(), out.end(),
                                       [&](const Pull& o) { return o.frame == frame_of[s]; });
        if (same != out.end()) {
            same->f += f;
        } else {
            out.push_back({frame_of[s], f});
        }
    }
    if (out.empty()) out.push_back({owner, 0});
    std::stable_sort(out.begin(), out.end(),
                     [](const Pull& a, const Pull& b) { return a.f > b.f; });
    if (out.size() > LayerSkin::most) out.resize(LayerSkin::most);
}

// A rigid motion as a unit dual quaternion.
struct DualQuaternion {
    Eigen::Vector4d real, dual;
};

DualQuaternion dual_quaternion(const Transform& motion)
{
    const Eigen::Quaterniond turn(motion.linear());
    const Vec3 t = motion.translation();
    const Eigen::Quaterniond move(0, t.x(), t.y(), t.z());
    return {turn.coeffs(), 0.5 * (move * turn).coeffs()};
}

struct Motion {
    Eigen::Quaterniond turn;
    Vec3 way;

    Vec3 operator*(const Vec3& p) const { return turn * p + way; }
};

// The weighted motions of vertex v's frames.
Motion blended(const LayerSkin& skin, std::size_t v, std::span<const DualQuaternion> motions)
{
    DualQuaternion sum{Eigen::Vector4d::Zero(), Eigen::Vector4d::Zero()};
    const Eigen::Vector4d& first = motions[skin.frame[v][0]].real;
    for (std::size_t k = 0; k < LayerSkin::most; ++k) {
        if (!(skin.weight[v][k] > 0)) continue;
        const DualQuaternion& motion = motions[skin.frame[v][k]];
        // q and -q are the same turn: the shorter way round.
        const double weight = motion.real.dot(first) < 0 ? -skin.weight[v][k] : skin.weight[v][k];
        sum.real += weight * motion.real;
        sum.dual += weight * motion.dual;
    }
    const double size = sum.real.norm();
    const Eigen::Quaterniond turn(Eigen::Vector4d(sum.real / size));
    const Eigen::Quaterniond dual(Eigen::Vector4d(sum.dual / size));
    return {turn, 2 * (dual * turn.conjugate()).vec()};
}

// Vertices that are asked about together.
struct VertexBatch {
    static constexpr std::size_t most = 32;
    std::vector<std::uint32_t> vertex, open;
    std::vector<Vec3> at;
    geometry::FieldBlock block;
    geometry::BlockValues values;

    void clear() { vertex.clear(), at.clear(); }
    void add(std::size_t v, const Vec3& p)
    {
        vertex.push_back(static_cast<std::uint32_t>(v));
        at.push_back(p);
    }
};

// What a vertex settles on: its value's surface, and within it the border between its frame's field
// and the largest of the others'.
struct Ground {
    geometry::IsoField layer;
    const Field& field;
    std::span<const std::uint32_t> frame_of;
};

// The deformed field, its isovalue taken off, at some of the vertices, or at all.
void ask(const Ground& ground, VertexBatch& batch, std::span<const std::uint32_t> which)
{
    batch.block.count = 0;
    for (const std::uint32_t i : which) batch.block.add(batch.at[i]);
    batch.block.pad();
    ground.layer.ask(batch.block, batch.values);
}

void ask(const Ground& ground, VertexBatch& batch)
{
    batch.open.resize(batch.at.size());
    std::iota(batch.open.begin(), batch.open.end(), 0u);
    ask(ground, batch, batch.open);
}

// By how much the frame's field is larger than that of any other, and the gradient of that.
geometry::FieldValue side(const Ground& ground, std::uint32_t frame, const Vec3& p)
{
    thread_local std::vector<std::uint32_t> near;
    thread_local std::vector<std::pair<std::uint32_t, geometry::FieldValue>> of_frame;
    geometry::Box box;
    box.add(p);
    geometry::candidates(ground.field, box, near);
    of_frame.assign(1, {frame, {}});
    for (const std::uint32_t s : near) {
        const geometry::Foot foot = geometry::foot(ground.field, s, p);
        const geometry::ProfileValue value = geometry::profile_at(ground.field.profile[s], foot.r);
        if (!(value.f > 0)) continue;
        auto same = std::find_if(of_frame.begin(), of_frame.end(),
                                 [&](const auto& o) { return o.first == ground.frame_of[s]; });
        if (same == of_frame.end()) {
            of_frame.push_back({ground.frame_of[s], {}});
            same = of_frame.end() - 1;
        }
        same->second.f += value.f;
        same->second.gradient += value.slope * foot.n;
    }
    geometry::FieldValue out = of_frame[0].second;
    const auto rival =
        std::max_element(of_frame.begin() + 1, of_frame.end(),
                         [](const auto& a, const auto& b) { return a.second.f < b.second.f; });
    if (rival != of_frame.end()) {
        out.f -= rival->second.f;
        out.gradient -= rival->second.gradient;
    }
    return out;
}

// From beyond the border of the frame's side back to it.
Vec3 to_border(const Ground& ground, std::uint32_t frame, double thickness, Vec3 p)
{
    for (int i = 0; i < 12; ++i) {
        const geometry::FieldValue at = side(ground, frame, p);
        const double slope = at.gradient.norm();
        if (!(slope > 0) || std::abs(at.f) < 1e-9) break;
        p -= std::clamp(at.f / slope, -0.25 * thickness, 0.25 * thickness) * at.gradient / slope;
    }
    return p;
}

// Along the gradient to the values, in steps of a quarter of the thickness at most; they stay
// where the field has no slope. With frames, what starts within keeps to its frame's side.
void to_values(const Ground& ground, const LayerSkin& skin, VertexBatch& batch, bool keep_sides)
{
    std::vector<std::uint32_t>& open = batch.open;
    open.clear();
    for (std::uint32_t i = 0; i < batch.vertex.size(); ++i) {
        if (batch.at[i].allFinite()) open.push_back(i);
    }
    for (int round = 0; round < 24 && !open.empty(); ++round) {
        ask(ground, batch, open);
        std::size_t left = 0;
        for (std::size_t k = 0; k < open.size(); ++k) {
            const std::uint32_t i = open[k], v = batch.vertex[i];
            const Vec3 gradient = batch.values.gradient(k);
            const double slope = gradient.norm();
            const double miss = skin.value[v] - ground.field.isovalue - batch.values.f[k];
            if (!(slope > 0) || std::abs(miss) < 1e-9) continue;
            const double most = 0.25 * skin.thickness;
            Vec3& p = batch.at[i];
            p += std::clamp(miss / slope, -most, most) * gradient / slope;
            const std::uint32_t frame = skin.frame[v][0];
            if (keep_sides && miss < 0 && side(ground, frame, p).f < 0) {
                p = to_border(ground, frame, skin.thickness, p);
            }
            open[left++] = i;
        }
        open.resize(left);
    }
}

// body(begin, end) for a batch of n vertices at a time, always the same ones together.
void for_batches(std::size_t n, const auto& body)
{
    constexpr std::size_t most = VertexBatch::most;
    geometry::parallel_for((n + most - 1) / most, 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) body(k * most, std::min(n, (k + 1) * most));
    });
}

// Slides vertices along the surface to their places among their neighbours, round by round, those
// that are off by a hundredth of their ring or more; then back to their values.
void slide(const LayerSkin& skin, const Ground& ground, std::span<const Vec3> offset,
           std::vector<Vec3>& at)
{
    constexpr double enough_sq = 1e-4;
    std::vector<Vec3> next = at;
    for (int round = 0; round < skin.rounds; ++round) {
        for_batches(at.size(), [&](std::size_t begin, std::size_t end) {
            thread_local VertexBatch batch;
            std::array<Vec3, VertexBatch::most> way;
            std::array<double, VertexBatch::most> least_sq;
            batch.clear();
            for (std::size_t v = begin; v < end; ++v) {
                if (skin.ring_at[v] == skin.ring_at[v + 1] || !(skin.value[v] > 0)) continue;
                Vec3 there = -offset[v];
                double around_sq = 0;
                for (std::uint32_t i = skin.ring_at[v]; i < skin.ring_at[v + 1]; ++i) {
                    const Vec3 to = at[skin.ring[i]] - at[v];
                    there += static_cast<double>(skin.ring_weight[i]) * to;
                    around_sq += static_cast<double>(skin.ring_weight[i]) * to.squaredNorm();
                }
                if (!(there.squaredNorm() > enough_sq * around_sq)) continue;
                way[batch.at.size()] = there;
                least_sq[batch.at.size()] = enough_sq * around_sq;
                batch.add(v, at[v]);
            }
            if (batch.at.empty()) return;
            ask(ground, batch);
            std::size_t left = 0;
            for (std::size_t i = 0; i < batch.at.size(); ++i) {
                const Vec3 normal = batch.values.gradient(i).normalized();
                const Vec3 along = way[i] - way[i].dot(normal) * normal;
                if (!(along.squaredNorm() > least_sq[i])) continue;
                batch.vertex[left] = batch.vertex[i];
                batch.at[left++] = batch.at[i] + along;
            }
            batch.vertex.resize(left), batch.at.resize(left);
            to_values(ground, skin, batch, false);
            for (std::size_t i = 0; i < left; ++i) next[batch.vertex[i]] = batch.at[i];
        });
        at = next;
    }
}

}  // namespace

LayerSkin bind(const TriMesh& mesh, const LayeredBody& body)
{
    if (body.layer.skeletons.empty()) {
        throw std::invalid_argument("a skin needs a layer with skeletons; this layer has none");
    }
    const Field field = geometry::make_field(body.layer, body.base.frames);
    const std::size_t n = mesh.positions.size();
    LayerSkin skin;
    skin.frame.resize(n);
    skin.weight.resize(n);
    skin.value.resize(n);
    skin.normal_vertex = vertices_of_normals(mesh);
    skin.thickness = std::numeric_limits<double>::infinity();
    for (const geometry::Contribution& c : body.layer.contributions) {
        skin.thickness = std::min(skin.thickness, c.thickness);
    }
    geometry::parallel_for(n, skin_grain, [&](std::size_t begin, std::size_t end) {
        std::vector<Pull> reach;
        for (std::size_t v = begin; v < end; ++v) {
            const Vec3 p = mesh.positions[v].cast<double>();
            find_reach(field, body.layer.frame, p, reach);
            double sum = 0;
            for (const Pull& r : reach) sum += r.f;
            for (std::size_t k = 0; k < LayerSkin::most; ++k) {
                const bool there = k < reach.size();
                skin.frame[v][k] = there ? reach[k].frame : 0;
                skin.weight[v][k] = !there ? 0 : sum > 0 ? reach[k].f / sum : 1;
            }
            skin.value[v] = geometry::value_at(field, p).f;
        }
    });
    for (const double value : skin.value) skin.out_of_reach += !(value > 0);
    MeanValueRings rings = mean_value_rings(mesh);
    // A round spreads what is crowded by an edge: as many as let it spread over a limb's side.
    const double edge = rings.ring.empty() ? skin.thickness : rings.edge;
    skin.rounds = static_cast<int>(std::clamp(3 * skin.thickness / edge, 4.0, 48.0));
    skin.ring_at = std::move(rings.ring_at);
    skin.ring = std::move(rings.ring);
    skin.ring_weight = std::move(rings.weight);
    skin.offset = std::move(rings.offset);
    return skin;
}

TriMesh follow(const LayerSkin& skin, const TriMesh& mesh, const LayeredScene& scene,
               std::size_t body)
{
    if (body >= scene.parts.size() || mesh.positions.size() != skin.value.size() ||
        mesh.normals.size() != skin.normal_vertex.size()) {
        throw std::invalid_argument(
            fmt::format("the skin ({} vertices, {} normals) does not match the mesh ({}, {}), or "
                        "body {} is not among the scene's {}",
                        skin.value.size(), skin.normal_vertex.size(), mesh.positions.size(),
                        mesh.normals.size(), body, scene.parts.size()));
    }
    const LayeredMoment moment(scene);
    const std::vector<Transform>& rest = scene.parts[body].body->base.frames;
    std::vector<DualQuaternion> moved;
    for (std::size_t b = 0; b < rest.size(); ++b) {
        moved.push_back(dual_quaternion(moment.frames[body][b] * rest[b].inverse()));
    }
    for (const auto& frames : skin.frame) {
        for (const std::uint32_t f : frames) {
            if (f >= moved.size()) {
                throw std::invalid_argument(fmt::format(
                    "the skin is bound to frame {}, but the body has {} frames", f, moved.size()));
            }
        }
    }
    const DeformedLayer layer =
        deformed(moment.bodies, static_cast<std::uint32_t>(body), moment.contacts);
    const Ground ground{iso_field(layer), moment.fields[body], scene.parts[body].body->layer.frame};
    std::vector<Vec3> at(mesh.positions.size());
    std::vector<Vec3> offset(at.size());
    for_batches(at.size(), [&](std::size_t begin, std::size_t end) {
        thread_local VertexBatch batch;
        batch.clear();
        for (std::size_t v = begin; v < end; ++v) {
            const Motion motion = blended(skin, v, moved);
            at[v] = motion * mesh.positions[v].cast<double>();
            offset[v] = motion.turn * skin.offset[v].cast<double>();
            if (skin.value[v] > 0) batch.add(v, at[v]);
        }
        to_values(ground, skin, batch, true);
        for (std::size_t i = 0; i < batch.at.size(); ++i) at[batch.vertex[i]] = batch.at[i];
    });
    slide(skin, ground, offset, at);
    TriMesh out = mesh;
    for (std::size_t v = 0; v < at.size(); ++v) out.positions[v] = at[v].cast<float>();
    if (!mesh.normals.empty()) geometry::compute_normals(out, 0.8);
    return out;
}

}  // namespace physics
