#include "physics/layered_mesh.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace physics {

using geometry::TriMesh;
using geometry::Vec3f;

namespace {

TriMesh mesh_of(const LayeredMoment& moment, std::uint32_t b, const LayeredMeshOptions& options)
{
    if (options.surface == LayeredMeshOptions::Surface::seeds) {
        const SeedWalk& walk = moment.walks[b];
        return preview_mesh(*moment.bodies[b].seeds,
                            options.deformed ? deformed(walk, b, moment.contacts) : walk);
    }
    geometry::IsoField field = options.deformed
                                   ? iso_field(deformed(moment.bodies, b, moment.contacts))
                                   : geometry::iso_field(moment.fields[b]);
    if (options.cut != LayeredMeshOptions::Cut::none) {
        const int axis = static_cast<int>(options.cut) - 1;
        field.domain.hi[axis] = std::min(field.domain.hi[axis], options.cut_at);
        if (field.domain.empty()) return {};
    }
    return geometry::polygonize(field, options.cell);
}

}  // namespace

TriMesh layered_mesh(const LayeredScene& scene, const LayeredMeshOptions& options)
{
    if (options.body >= static_cast<int>(scene.parts.size())) {
        throw std::invalid_argument(fmt::format("body {} was asked for in a scene of {}",
                                                options.body, scene.parts.size()));
    }
    const LayeredMoment moment(scene);
    TriMesh all;
    auto topology = std::make_shared<geometry::MeshTopology>();
    geometry::Attribute compression{"compression", "1", {}};
    for (std::uint32_t b = 0; b < scene.parts.size(); ++b) {
        if (options.body >= 0 && options.body != static_cast<int>(b)) continue;
        if (scene.parts[b].body->seeds.count() == 0) continue;  // the ground draws itself
        const TriMesh mesh = mesh_of(moment, b, options);
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
        std::vector<Vec3> points;
        for (const Vec3f& p : mesh.positions) points.push_back(p.cast<double>());
        std::vector<double> f(points.size());
        geometry::evaluate(moment.fields[b], points, f);
        for (const double value : f) {
            compression.values.push_back(
                static_cast<float>(std::max(0.0, value - moment.fields[b].isovalue)));
        }
    }
    topology->normal_triangles = topology->triangles;
    all.topology = std::move(topology);
    all.attributes.push_back(std::move(compression));
    return all;
}

}  // namespace physics
