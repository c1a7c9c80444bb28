#include "physics/layers/sample_walk.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/fields/evaluate_block.hpp"
#include "geometry/mesh/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace physics {

using geometry::BlockValues;
using geometry::FieldBlock;
using geometry::Triangle;
using geometry::TriMesh;

double SampleWalk::volume() const
{
    double sum = 0;
    for (const double v : local_volume) sum += v;
    return sum;
}

namespace {

// Up to a block of samples of one skeleton.
struct Batch {
    std::uint32_t skeleton, begin, end;
};

// A sample on its ray: it stops at the first zero of
//   chi(t) = min(f - c, f_own - f_rival) = min(phi, psi)
// between `inside`, where chi > 0 (or t = 0), and `outside`, where it is not.
struct Walker {
    Vec3 origin, direction;
    double t = 0, inside = 0, outside = 0;
};

// chi's two parts at t, and how they change along the ray.
struct Clearance {
    double phi, phi_slope, psi, psi_slope;
};

Clearance clearance_at(const geometry::TerritoryValues& values, std::size_t k,
                       const Vec3& direction, double isovalue)
{
    return {values.blend.f[k] - isovalue, direction.dot(values.blend.gradient(k)),
            values.own.f[k] - values.rival.f[k],
            direction.dot(values.own.gradient(k) - values.rival.gradient(k))};
}

// Newton's step from t; the bracket's middle when the step leaves the bracket.
double next_t(const Walker& w, const Clearance& at)
{
    double next = std::numeric_limits<double>::infinity();
    if (at.phi_slope < 0) next = std::min(next, w.t - at.phi / at.phi_slope);
    if (at.psi_slope < 0) next = std::min(next, w.t - at.psi / at.psi_slope);
    if (next > w.inside && next <= w.outside) return next;
    return 0.5 * (w.inside + w.outside);
}

// Goes on along the ray. Returns false, and stays, where it has arrived.
bool step(Walker& w, const Clearance& at, double tolerance)
{
    if (std::min(at.phi, at.psi) > 0)
        w.inside = w.t;
    else
        w.outside = w.t;
    const double next = next_t(w, at);
    if (std::abs(next - w.t) <= tolerance || w.outside - w.inside <= tolerance) return false;
    w.t = next;
    return true;
}

std::vector<Walker> start_walkers(const Field& field, const SurfaceSamples& samples,
                                  const Transform& frame, const Batch& batch,
                                  const SampleWalk* before)
{
    const geometry::FieldProfile& own = field.profile[batch.skeleton];
    std::vector<Walker> walkers(batch.end - batch.begin);
    for (std::size_t i = 0; i < walkers.size(); ++i) {
        Walker& w = walkers[i];
        w.origin = frame * samples.origin[batch.begin + i];
        w.direction = frame.linear() * samples.direction[batch.begin + i];
        const double width = geometry::width_along(field, batch.skeleton, w.direction);
        w.outside = std::max(0.0, own.R) * width;
        w.t = before ? before->distance[batch.begin + i] : own.e * width;
        w.t = std::clamp(w.t, 0.0, w.outside);
    }
    return walkers;
}

// Keeps what was asked where a sample has arrived: on the surface unless the border came first.
void keep(const SurfaceSamples& samples, std::size_t sample, const Walker& w, const Clearance& at,
          const Vec3& position, const Vec3& gradient, double tolerance, double isovalue,
          SampleWalk& result)
{
    const double slope = gradient.norm();
    const double cosine = slope > 0 ? -at.phi_slope / slope : 0;
    const bool on_surface = std::abs(at.phi) <= 10 * tolerance * slope + 1e-13 * isovalue;
    const bool own_ground = at.psi >= -(10 * tolerance * std::abs(at.psi_slope) + 1e-13 * isovalue);
    result.distance[sample] = w.t;
    result.position[sample] = position;
    result.gradient[sample] = gradient;
    result.valid[sample] = on_surface && own_ground && cosine > 1e-6;
    result.area[sample] = result.valid[sample] ? samples.crossed(sample, w.t) / cosine : 0;
}

// A field with a jump in it: as near as the sample came.
void give_up(std::size_t sample, const Walker& w, SampleWalk& result)
{
    result.distance[sample] = w.inside;
    result.position[sample] = w.origin + w.inside * w.direction;
    result.gradient[sample] = -w.direction;
    result.valid[sample] = 0;
    result.area[sample] = 0;
}

// What a batch adds to dV/dtau of each skeleton.
using Slopes = std::vector<std::pair<std::uint32_t, double>>;

// A sample's share of dV/dtau of every skeleton that was evaluated at point k.
void add_slopes(const Field& field, const geometry::FieldScratch& scratch, const Vec3& at,
                std::size_t k, double weight, Slopes& slopes)
{
    for (std::size_t s = 0; s < scratch.near.size(); ++s) {
        const BlockValues& one = scratch.each[s];
        if (!(one.f[k] > 0)) continue;
        const double share =
            scratch.share.empty() ? 1 : scratch.share[s * FieldBlock::capacity + k];
        const auto found = std::find_if(slopes.begin(), slopes.end(), [&](const auto& slope) {
            return slope.first == scratch.near[s];
        });
        double own = weight * share * one.gradient(k).norm();  // -df/dr |grad r|
        if (geometry::stretch_of(field, scratch.near[s])) {
            own /= geometry::foot(field, scratch.near[s], at).n.norm();
        }
        if (found != slopes.end()) {
            found->second += own;
        } else {
            slopes.emplace_back(scratch.near[s], own);
        }
    }
}

void walk_batch(const Field& field, const SurfaceSamples& samples, const Transform& frame,
                const Batch& batch, const SampleWalk* before, SampleWalk& result, Slopes* slopes)
{
    thread_local std::vector<std::uint32_t> near;
    thread_local geometry::FieldScratch scratch;
    thread_local geometry::TerritoryValues values;
    thread_local FieldBlock block;
    const std::uint32_t own = batch.skeleton;
    const double reach = field.profile[own].R, c = field.isovalue;

    geometry::candidates(field, field.influence[own], near);
    if (field.rule != geometry::BlendRule::sum) {
        std::erase_if(near, [&](std::uint32_t j) { return !(field.weights(own, j) > 0); });
    }
    std::vector<Walker> walkers = start_walkers(field, samples, frame, batch, before);
    std::vector<std::size_t> active(walkers.size());
    std::iota(active.begin(), active.end(), std::size_t{0});
    const double tolerance = 1e-12 * std::max(field.profile[own].e, 1e-3 * reach);
    for (int round = 0; round < 100 && !active.empty(); ++round) {
        block.count = 0;
        for (const std::size_t i : active) {
            block.add(walkers[i].origin + walkers[i].t * walkers[i].direction);
        }
        block.pad();
        geometry::evaluate(field, near, own, block, scratch, values);
        std::size_t left = 0;
        for (std::size_t k = 0; k < active.size(); ++k) {
            const std::size_t i = active[k], sample = batch.begin + i;
            Walker& w = walkers[i];
            const Clearance at = clearance_at(values, k, w.direction, c);
            if (step(w, at, tolerance)) {
                active[left++] = i;
                continue;
            }
            keep(samples, sample, w, at, block.point(k), values.blend.gradient(k), tolerance, c,
                 result);
            if (slopes && result.valid[sample]) {
                add_slopes(field, scratch, block.point(k), k,
                           samples.crossed(sample, w.t) / -at.phi_slope, *slopes);
            }
        }
        active.resize(left);
    }
    for (const std::size_t i : active) give_up(batch.begin + i, walkers[i], result);
}

}  // namespace

SampleWalk walk(const Field& field, const SurfaceSamples& samples,
                std::span<const Transform> frames, const SampleWalk* before, bool slopes)
{
    if (samples.skeletons() != field.count() ||
        (before && before->distance.size() != samples.count())) {
        throw std::invalid_argument(
            fmt::format("samples of {} skeletons do not match a field of {} skeletons, or {} "
                        "samples do not match "
                        "an earlier walk of {}",
                        samples.skeletons(), field.count(), samples.count(),
                        before ? before->distance.size() : samples.count()));
    }
    SampleWalk result;
    result.distance.resize(samples.count());
    result.valid.resize(samples.count());
    result.position.resize(samples.count());
    result.gradient.resize(samples.count());
    result.area.resize(samples.count());
    result.local_volume.resize(samples.skeletons());

    std::vector<Batch> batches;
    for (std::uint32_t s = 0; s < samples.skeletons(); ++s) {
        constexpr auto most = static_cast<std::uint32_t>(FieldBlock::capacity);
        for (std::uint32_t b = samples.first[s]; b < samples.first[s + 1]; b += most) {
            batches.push_back({s, b, std::min(b + most, samples.first[s + 1])});
        }
    }
    std::vector<Slopes> found(slopes ? batches.size() : 0);
    geometry::parallel_for(batches.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            geometry::stop_if_asked();
            walk_batch(field, samples, frames[samples.frame[batches[b].skeleton]], batches[b],
                       before, result, slopes ? &found[b] : nullptr);
        }
    });
    if (slopes) {
        result.volume_slope.assign(samples.skeletons(), 0);
        for (const Slopes& some : found) {
            for (const auto& [skeleton, slope] : some) result.volume_slope[skeleton] += slope;
        }
    }
    for (std::size_t s = 0; s < samples.skeletons(); ++s) {
        double volume = samples.core[s];
        for (std::size_t i = samples.first[s]; i < samples.first[s + 1]; ++i) {
            volume += samples.swept(i, result.distance[i]);
        }
        result.local_volume[s] = volume;
    }
    return result;
}

geometry::TriMesh preview_mesh(const SurfaceSamples& samples, const SampleWalk& walk)
{
    TriMesh mesh;
    mesh.positions.reserve(samples.count());
    mesh.normals.reserve(samples.count());
    for (std::size_t i = 0; i < samples.count(); ++i) {
        mesh.positions.push_back(walk.position[i].cast<float>());
        const double slope = walk.gradient[i].norm();
        mesh.normals.push_back(slope > 0
                                   ? geometry::Vec3f((-walk.gradient[i] / slope).cast<float>())
                                   : geometry::Vec3f(geometry::Vec3f::UnitY()));
    }
    auto topology = std::make_shared<geometry::MeshTopology>();
    for (const Triangle& t : samples.faces) {
        if (walk.valid[t[0]] || walk.valid[t[1]] || walk.valid[t[2]]) {
            topology->triangles.push_back(t);
        }
    }
    topology->normal_triangles = topology->triangles;
    mesh.topology = std::move(topology);
    return mesh;
}

}  // namespace physics
