#include "geometry/cubes/local_matter.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

#include "graph/document/expression.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

#include <fmt/format.h>

#include <algorithm>
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

// What a mesh is painted with: numbers at its vertices, by the names that expressions know them by.
class Paint {
public:
    explicit Paint(const geometry::TriMesh* mesh)
    {
        if (!mesh || mesh->triangles().empty()) return;
        mesh_ = mesh;
        coloured_ = mesh->colours.size() == mesh->positions.size();
        if (coloured_) names_.insert(names_.end(), {"r", "g", "b"});
        for (const geometry::Attribute& a : mesh->attributes) {
            const bool free = graph::Grammar::free_name(a.name) &&
                              std::find(names_.begin(), names_.end(), a.name) == names_.end();
            if (!free || a.values.size() != mesh->positions.size()) continue;
            names_.push_back(a.name);
            attributes_.push_back(&a);
        }
        if (names_.size() > places) tree_ = geometry::TriangleBvh(*mesh);
    }

    const std::vector<std::string>& names() const { return names_; }

    // x, y and z of a place, and what the surface is painted with where it is nearest.
    void look(const Vec3& place, std::vector<double>& values) const
    {
        values.assign(names_.size(), 0.0);
        std::copy_n(place.data(), places, values.begin());
        if (names_.size() == places) return;
        const auto hit = tree_.closest(place);
        if (!hit) return;
        const geometry::Triangle& t = mesh_->triangles()[hit.triangle];
        for (std::size_t k = 0; k < 3; ++k) {
            const double weight = hit.barycentric[static_cast<Eigen::Index>(k)];
            std::size_t at = places;
            for (Eigen::Index c = 0; coloured_ && c < 3; ++c) {
                values[at++] += weight * double(mesh_->colours[t[k]][c]);
            }
            for (const geometry::Attribute* a : attributes_) {
                values[at++] += weight * double(a->values[t[k]]);
            }
        }
    }

private:
    static constexpr std::size_t places = 3;
    const geometry::TriMesh* mesh_ = nullptr;
    bool coloured_ = false;
    std::vector<std::string> names_{"x", "y", "z"};
    std::vector<const geometry::Attribute*> attributes_;
    geometry::TriangleBvh tree_;
};

static graph::FunctionOf compiled(const std::string& value, const Paint& paint)
{
    try {
        return graph::Grammar().compile_of(value, paint.names());
    } catch (const graph::ExpressionError& error) {
        throw std::invalid_argument(fmt::format(
            "{}{}{}", error.what(), error.suggestion.empty() ? "" : "; ", error.suggestion));
    }
}

static Outputs run(const Inputs& in, const graph::Context&)
{
    const Paint paint(in.mesh ? &*in.mesh : nullptr);
    std::vector<double> values;
    Outputs out{*in.cubes};
    for (std::size_t i = 0; i < in.properties.size(); ++i) {
        const Rule& rule = in.properties[i];
        try {
            const graph::FunctionOf f = compiled(rule.value, paint);
            const auto at = [&](const Vec3& p) {
                paint.look(p, values);
                return f(values);
            };
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
               "in m; r, g and b, from 0 to 1 and linear, where a mesh with vertex colours is "
               "linked; and the names of that mesh's attributes. Each cube gets the mean over its "
               "volume.");
}

void add_to(graph::Registry& registry)
{
    registry.add("LocalMatter", 1, run)
        .summary("Varies the material of cubes from place to place: by expressions of position, or "
                 "of the colours and attributes that a mesh is painted with.",
                 {"paint", "gradient", "graded", "stiffness map", "weight map", "vertex colour"})
        .input("cubes", &Inputs::cubes, "The cubes at rest.")
        .input(
            "mesh", &Inputs::mesh,
            "A mesh at rest with vertex colours (r, g and b) or attributes, which are read at the "
            "nearest point of its surface.",
            graph::Need::optional)
        .list("properties", &Inputs::properties, describe_rule,
              "Properties to change, each by its own expression.")
        .output("cubes", &Outputs::cubes, "The cubes with their new material.");
}

}  // namespace nodes::local_matter
