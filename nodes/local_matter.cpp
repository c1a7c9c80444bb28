#include "geometry/cubes/local_matter.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

#include "graph/document/expression.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace nodes::local_matter {

using geometry::Vec3;

struct Rule {
    geometry::LocalProperty property = geometry::LocalProperty::young;
    std::string value = "1000000";
};

struct Inputs {
    graph::Wire<geometry::Cubes> cubes;
    graph::Wire<geometry::TriMesh> mesh;
    std::vector<Rule> properties;
};
struct Outputs {
    geometry::Cubes cubes;
};

static graph::FunctionOf compiled(const Rule& rule, std::size_t i, bool coloured)
{
    std::vector<std::string> names{"x", "y", "z"};
    if (coloured) names.insert(names.end(), {"r", "g", "b"});
    try {
        return graph::Grammar().compile_of(rule.value, names);
    } catch (const graph::ExpressionError& error) {
        throw std::invalid_argument(
            fmt::format("properties[{}].value \"{}\": {}{}{}", i, rule.value, error.what(),
                        error.suggestion.empty() ? "" : "; ", error.suggestion));
    }
}

// The colour of the surface where it is nearest to a place.
static Vec3 colour_near(const geometry::TriMesh& mesh, const geometry::TriangleBvh& tree,
                        const Vec3& place)
{
    const auto hit = tree.closest(place);
    Vec3 colour = Vec3::Zero();
    if (!hit) return colour;
    const geometry::Triangle& t = mesh.triangles()[hit.triangle];
    for (std::size_t k = 0; k < 3; ++k) {
        colour += hit.barycentric[static_cast<Eigen::Index>(k)] * mesh.colours[t[k]].cast<double>();
    }
    return colour;
}

static Outputs run(const Inputs& in, const graph::Context&)
{
    const bool coloured = in.mesh && !in.mesh->triangles().empty() &&
                          in.mesh->colours.size() == in.mesh->positions.size();
    const geometry::TriangleBvh tree =
        coloured ? geometry::TriangleBvh(*in.mesh) : geometry::TriangleBvh();
    Outputs out{*in.cubes};
    for (std::size_t i = 0; i < in.properties.size(); ++i) {
        const Rule& rule = in.properties[i];
        const graph::FunctionOf f = compiled(rule, i, coloured);
        const auto at = [&](const Vec3& p) {
            std::array<double, 6> values{p.x(), p.y(), p.z(), 0, 0, 0};
            if (coloured) {
                const Vec3 colour = colour_near(*in.mesh, tree, p);
                std::copy_n(colour.data(), 3, values.begin() + 3);
            }
            return f(values);
        };
        try {
            out.cubes = geometry::with_local_values(std::move(out.cubes), rule.property,
                                                    geometry::cube_means(*in.cubes, at));
        } catch (const std::invalid_argument& error) {
            throw std::invalid_argument(
                fmt::format("properties[{}].value \"{}\": {}", i, rule.value, error.what()));
        }
    }
    return out;
}

static void describe_rule(graph::ParamsOf<Rule>& p)
{
    p.choice("property", &Rule::property,
             {"young", "density", "poisson", "mass_damping", "stiffness_damping"},
             "The property: young (Pa), density of the material (kg/m^3), poisson, mass_damping "
             "(1/s) or stiffness_damping (s).")
        .param("value", &Rule::value,
               "Its value as an expression of the place at rest, without a leading =: x, y and z "
               "in m; and r, g and b, from 0 to 1 and linear, where a mesh with vertex colours is "
               "linked. Each cube gets the mean over its volume.");
}

void add_to(graph::Registry& registry)
{
    registry.add("LocalMatter", 1, run)
        .summary("Varies the material of cubes from place to place: by expressions of position, or "
                 "of the colours that a mesh is painted with.",
                 {"paint", "gradient", "graded", "stiffness map", "weight map", "vertex colour"})
        .input("cubes", &Inputs::cubes, "The cubes at rest.")
        .input("mesh", &Inputs::mesh,
               "A mesh at rest, whose vertex colours give r, g and b at the nearest point of its "
               "surface.",
               graph::Need::optional)
        .list("properties", &Inputs::properties, describe_rule,
              "Properties to change, each by its own expression.")
        .output("cubes", &Outputs::cubes, "The cubes with their new material.");
}

}  // namespace nodes::local_matter
