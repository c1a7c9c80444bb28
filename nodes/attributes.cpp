#include "nodes/paint.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace nodes::attributes {

struct Item {
    std::string name = "weight";
    std::string unit;
    std::string value = "1";
    Ramp ramp;
};

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh;
    std::vector<Item> attributes;
    std::filesystem::path texture;
};
struct Outputs {
    geometry::TriMesh mesh;
};

static std::vector<float> values_of(const geometry::TriMesh& mesh, const Item& item,
                                    const std::shared_ptr<const geometry::Picture>& picture)
{
    const Paint paint(&mesh, picture, std::span(&item.value, 1), Paint::At::vertices);
    const graph::FunctionOf f = compiled(item.value, paint.names());
    std::vector<double> known;
    std::vector<float> out(mesh.positions.size());
    for (std::size_t v = 0; v < out.size(); ++v) {
        paint.at_vertex(v, known);
        out[v] = static_cast<float>(item.ramp(f(known)));
        if (std::isfinite(out[v])) continue;
        const geometry::Vec3f& p = mesh.positions[v];
        throw std::invalid_argument(
            fmt::format("expected a finite number, found {:.3g} at vertex {} at ({:.3g}, {:.3g}, "
                        "{:.3g})",
                        out[v], v, p.x(), p.y(), p.z()));
    }
    return out;
}

static Outputs run(const Inputs& in, const graph::Context&)
{
    Outputs out{*in.mesh};
    std::vector<std::string> expressions;
    for (const Item& item : in.attributes) expressions.push_back(item.value);
    const auto picture = picture_of(in.texture, expressions);  // read once for all
    for (std::size_t i = 0; i < in.attributes.size(); ++i) {
        const Item& item = in.attributes[i];
        try {
            check_name(item.name);
            check(item.ramp);
            geometry::Attribute made{item.name, item.unit, values_of(out.mesh, item, picture)};
            const auto same = [&](const geometry::Attribute& a) { return a.name == item.name; };
            std::erase_if(out.mesh.attributes, same);
            out.mesh.attributes.push_back(std::move(made));
        } catch (const std::invalid_argument& error) {
            throw std::invalid_argument(fmt::format("attributes[{}] {} = \"{}\": {}", i, item.name,
                                                    item.value, error.what()));
        }
    }
    return out;
}

static void describe_item(graph::ParamsOf<Item>& p)
{
    p.param("name", &Item::name,
            "Name of the attribute. One of this name that the mesh has is replaced.")
        .param("unit", &Item::unit, "Its unit, for legends of pictures.")
        .param("value", &Item::value, about_paint)
        .block("ramp", &Item::ramp, describe_ramp, about_ramp);
}

void add_to(graph::Registry& registry)
{
    registry.add("Attributes", 1, run)
        .summary("Gives the vertices of a mesh numbers of the user's own: by expressions of "
                 "position, of colours and other attributes, and of a texture.",
                 {"attribute wrangle", "attribvop", "attribute from map", "weight map",
                  "vertex "
                  "group",
                  "primitive variable", "primvar", "paint"})
        .input("mesh", &Inputs::mesh, "The mesh, or point cloud.")
        .list("attributes", &Inputs::attributes, describe_item,
              "Attributes to make, one after the other: each expression knows those before it.")
        .path_in("texture", &Inputs::texture, about_texture)
        .output("mesh", &Outputs::mesh, "The mesh with its attributes.");
}

}  // namespace nodes::attributes
