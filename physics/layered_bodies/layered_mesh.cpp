#include "physics/layered_bodies/layered_mesh.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/fields/evaluate_points.hpp"
#include "geometry/fields/polygonize.hpp"
#include "geometry/mesh/clip.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/layered_bodies/layered_moment.hpp"
#include "physics/layered_bodies/scene_record.hpp"
#include "physics/layers/deformed_layer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <stdexcept>

namespace physics {

using geometry::TriMesh;
using geometry::Vec3f;

namespace {

// What each body adds: its mesh and how far its vertices are pressed.
struct Piece {
    TriMesh mesh;
    std::vector<float> compression;
};

// Samples where the state left them, carried by their frames.
Piece preview_of(const LayeredScene& scene, std::uint32_t b)
{
    const LayeredBody& body = *scene.parts[b].body;
    const LayeredState& state = scene.states[b];
    const SurfaceSamples& samples = body.samples;
    Piece piece;
    piece.mesh.positions.resize(samples.count());
    piece.mesh.normals.assign(samples.count(), Vec3f::Zero());
    piece.compression.resize(samples.count());
    for (std::size_t s = 0; s < samples.skeletons(); ++s) {
        const std::uint32_t f = samples.frame[s];
        const Mat3 turn = Eigen::Quaterniond(state.rotation[f]).toRotationMatrix();
        const double k = body.layer.contributions[s].stiffness;
        const geometry::FieldStretch width = geometry::stretch_of(body.layer.skeletons[s]);
        geometry::parallel_for(
            samples.first[s + 1] - samples.first[s], 4096, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = samples.first[s] + begin; i < samples.first[s] + end; ++i) {
                    const bool there = state.pressed[i] >= 0;
                    const double d =
                        there ? static_cast<double>(state.pressed[i]) : state.distance[i];
                    const Vec3 local = samples.origin[i] + d * samples.direction[i];
                    piece.mesh.positions[i] = (turn * local + state.position[f]).cast<float>();
                    const double slope = k / width.along(samples.direction[i]);
                    piece.compression[i] = std::max(
                        0.f, static_cast<float>(slope) * static_cast<float>(state.distance[i] - d));
                }
            });
    }
    auto topology = std::make_shared<geometry::MeshTopology>();
    for (const geometry::Triangle& t : samples.faces) {
        if (!(state.pressed[t[0]] >= 0 || state.pressed[t[1]] >= 0 || state.pressed[t[2]] >= 0)) {
            continue;
        }
        topology->triangles.push_back(t);
        const Vec3f &p = piece.mesh.positions[t[0]], &q = piece.mesh.positions[t[1]],
                    &r = piece.mesh.positions[t[2]];
        const Vec3f area = (q - p).cross(r - p);
        for (const std::uint32_t v : t) piece.mesh.normals[v] += area;
    }
    for (Vec3f& n : piece.mesh.normals) {
        const float size = n.norm();
        n = size > 0 ? Vec3f(n / size) : Vec3f(Vec3f::UnitY());
    }
    piece.mesh.topology = std::move(topology);
    return piece;
}

TriMesh mesh_of(const LayeredMoment& moment, std::uint32_t b, const LayeredMeshOptions& options)
{
    if (options.surface == LayeredMeshOptions::Surface::samples) {
        const SampleWalk& walk = moment.walks[b];
        return preview_mesh(*moment.bodies[b].samples,
                            options.deformed ? deformed(walk, b, moment.contacts) : walk);
    }
    geometry::IsoField field = options.deformed
                                   ? iso_field(deformed(moment.bodies, b, moment.contacts))
                                   : geometry::iso_field(moment.fields[b]);
    if (options.cut == LayeredMeshOptions::Cut::none) {
        return geometry::polygonize(field, options.cell, options.max_triangles);
    }
    const int axis = static_cast<int>(options.cut) - 1;
    field.domain.hi[axis] = std::min(field.domain.hi[axis], options.cut_at);
    if (field.domain.empty()) return {};
    // Whole cells: they reach beyond the cut.
    return geometry::clipped(geometry::polygonize(field, options.cell, options.max_triangles), axis,
                             static_cast<float>(options.cut_at));
}

Piece piece_of(const LayeredMoment& moment, std::uint32_t b, const LayeredMeshOptions& options)
{
    Piece piece{mesh_of(moment, b, options), {}};
    std::vector<Vec3> points;
    for (const Vec3f& p : piece.mesh.positions) points.push_back(p.cast<double>());
    std::vector<double> f(points.size());
    geometry::evaluate(moment.fields[b], points, f);
    for (const double value : f) {
        piece.compression.push_back(
            static_cast<float>(std::max(0.0, value - moment.fields[b].isovalue)));
    }
    return piece;
}

// Whether its samples are where its state left them: those of a net stretch.
bool walked(const LayeredScene& scene, std::size_t b)
{
    const LayeredBody& body = *scene.parts[b].body;
    return body.base.spans.empty() && scene.states[b].pressed.size() == body.samples.count();
}

}  // namespace

TriMesh layered_mesh(const LayeredScene& scene, const LayeredMeshOptions& options)
{
    if (options.body >= static_cast<int>(scene.parts.size())) {
        throw std::invalid_argument(
            fmt::format("body = {} does not exist: Layered has {} bodies, counted from 0.",
                        options.body, scene.parts.size()));
    }
    const bool preview = options.surface == LayeredMeshOptions::Surface::samples;
    if (preview && scene.presses) return layered_mesh(with_samples(scene), options);
    std::optional<LayeredMoment> moment;
    TriMesh all;
    auto topology = std::make_shared<geometry::MeshTopology>();
    geometry::Attribute compression{"compression", "1", {}};
    for (std::uint32_t b = 0; b < scene.parts.size(); ++b) {
        if (options.body >= 0 && options.body != static_cast<int>(b)) continue;
        if (!has_surface(*scene.parts[b].body)) continue;
        const bool quick = preview && walked(scene, b);
        if (!quick && !moment) moment.emplace(scene);
        const Piece piece = quick ? preview_of(scene, b) : piece_of(*moment, b, options);
        const TriMesh& mesh = piece.mesh;
        const auto base = static_cast<std::uint32_t>(all.positions.size());
        const auto number = static_cast<std::uint16_t>(topology->materials.size());
        topology->materials.push_back(
            {.name = fmt::format("body {}", b), .colour = scene.parts[b].colour});
        topology->groups.push_back(fmt::format("body {}", b));
        for (const geometry::Triangle& t : mesh.triangles()) {
            topology->triangles.push_back({base + t[0], base + t[1], base + t[2]});
            topology->material.push_back(number);
            topology->group.push_back(number);
        }
        all.positions.insert(all.positions.end(), mesh.positions.begin(), mesh.positions.end());
        all.normals.insert(all.normals.end(), mesh.normals.begin(), mesh.normals.end());
        compression.values.insert(compression.values.end(), piece.compression.begin(),
                                  piece.compression.end());
    }
    topology->normal_triangles = topology->triangles;
    all.topology = std::move(topology);
    all.attributes.push_back(std::move(compression));
    return all;
}

}  // namespace physics
