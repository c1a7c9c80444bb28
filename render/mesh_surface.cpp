#include "render/mesh_surface.hpp"

#include "geometry/mesh/mesh_edges.hpp"

#include <algorithm>

namespace render {

std::shared_ptr<const TriMesh> with_displacement(const std::shared_ptr<const TriMesh>& mesh,
                                                 const TriMesh* rest)
{
    const std::string name = "displacement";
    const bool has = std::any_of(mesh->attributes.begin(), mesh->attributes.end(),
                                 [&](const auto& a) { return a.name == name; });
    if (has || !rest || rest->positions.size() != mesh->positions.size()) return mesh;
    auto out = std::make_shared<TriMesh>(*mesh);
    std::vector<float> values(mesh->positions.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = (mesh->positions[i] - rest->positions[i]).norm();
    }
    out->attributes.push_back({name, "m", std::move(values)});
    return out;
}

Balls cloud_balls(const TriMesh& cloud, const Paint& paint, float radius)
{
    Balls balls;
    balls.centres = cloud.positions;
    balls.radius = radius;
    balls.colours = {paint.by == Paint::By::constant ? paint.colour : geometry::Material{}.colour};
    const bool own = paint.by == Paint::By::vertex_colour || paint.by == Paint::By::material;
    if (own && cloud.colours.size() == cloud.positions.size()) balls.colours = cloud.colours;
    if (paint.by != Paint::By::attribute) return balls;
    for (const geometry::Attribute& a : cloud.attributes) {
        if (a.name != paint.attribute || a.values.size() != cloud.positions.size()) continue;
        balls.colours.clear();
        for (const float value : a.values) {
            balls.colours.push_back(
                linear_from_srgb(colour_at(paint.scale.map, paint.scale.place(value))));
        }
    }
    return balls;
}

Lines edge_lines(const TriMesh& mesh)
{
    Lines lines;
    const auto uses = geometry::edge_uses(mesh.triangles(), mesh.positions.size());
    for (std::size_t i = 0; i < uses.size(); ++i) {
        if (i > 0 && uses[i].a == uses[i - 1].a && uses[i].b == uses[i - 1].b) continue;
        lines.ends.push_back(mesh.positions[uses[i].a]);
        lines.ends.push_back(mesh.positions[uses[i].b]);
    }
    lines.colour = {0.02f, 0.02f, 0.03f};
    return lines;
}

}  // namespace render
