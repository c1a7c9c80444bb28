#include "geometry/cubes/local_matter.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/paint.hpp"
#include "nodes/wire_types.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace nodes::local_matter {

using geometry::LocalProperty;
using geometry::Vec3;

struct Rule {
    LocalProperty property = LocalProperty::young;
    std::string name = "weight";
    std::string unit;
    std::string value = "1000000";
    Ramp ramp;
    std::string part;
};

struct Inputs {
    graph::Wire<geometry::Cubes> cubes;
    graph::Wire<geometry::TriMesh> mesh;
    std::vector<Rule> properties;
    std::filesystem::path texture;
};
struct Outputs {
    geometry::Cubes cubes;
};

static constexpr std::array property_names{
    "young", "density", "poisson", "mass_damping", "stiffness_damping", "thickness", "own"};

static Paint paint_of(const Inputs& in)
{
    std::vector<std::string> expressions;
    bool parts = false;
    for (const Rule& rule : in.properties) {
        expressions.push_back(rule.value);
        parts = parts || !rule.part.empty();
    }
    return Paint(in.mesh.get(), picture_of(in.texture, expressions), expressions,
                 parts ? Paint::At::faces : Paint::At::places);
}

// What cubes have already, of what an expression uses and the mesh doesn't have.
struct OfCubes {
    std::vector<std::string> names;
    std::vector<std::vector<double>> values;  // empty where they are not used
};

static OfCubes of_cubes(const geometry::Cubes& cubes, const std::string& expression,
                        const std::vector<std::string>& others)
{
    OfCubes out;
    std::vector<std::string> names = geometry::value_names(cubes);
    std::erase_if(names, [&](const std::string& name) {
        return std::find(others.begin(), others.end(), name) != others.end();
    });
    out.names = usable_names(names, others);
    for (std::size_t i = 0; i < names.size(); ++i) {
        out.values.push_back(mentions(expression, out.names[i])
                                 ? geometry::cube_values(cubes, names[i])
                                 : std::vector<double>{});
    }
    return out;
}

// Each cube's value where a rule with a `part` does not apply.
static std::vector<double> before(const geometry::Cubes& cubes, const Rule& rule)
{
    if (rule.property == LocalProperty::own) {
        for (const geometry::CubeAttribute& a : cubes.attributes) {
            if (a.name == rule.name) return a.values;
        }
        return std::vector<double>(cubes.count(), 0.0);
    }
    if (rule.property == LocalProperty::thickness) return geometry::thicknesses(cubes);
    return geometry::cube_values(cubes, property_names[std::size_t(rule.property)]);
}

static std::vector<double> values_of(const geometry::Cubes& cubes, const Rule& rule,
                                     const Paint& paint)
{
    const OfCubes own = of_cubes(cubes, rule.value, paint.names());
    std::vector<std::string> names = paint.names();
    names.insert(names.end(), own.names.begin(), own.names.end());
    const graph::FunctionOf f = compiled(rule.value, names);
    const std::vector<double> otherwise =
        rule.part.empty() ? std::vector<double>{} : before(cubes, rule);
    std::vector<double> known;
    return geometry::cube_means(cubes, [&](const Vec3& p, std::size_t cube) {
        const std::uint32_t face = paint.look(p, known);
        if (!rule.part.empty() && !paint.in_part(face, rule.part)) return otherwise[cube];
        for (const std::vector<double>& v : own.values) known.push_back(v.empty() ? 0 : v[cube]);
        return rule.ramp(f(known));
    });
}

static geometry::Cubes changed(geometry::Cubes cubes, const Rule& rule, const Paint& paint)
{
    std::vector<double> values = values_of(cubes, rule, paint);
    if (rule.property != LocalProperty::own) {
        return geometry::with_local_values(std::move(cubes), rule.property, values);
    }
    return geometry::with_attribute(std::move(cubes), {rule.name, rule.unit, std::move(values)});
}

// What `work` finds wrong, told of the part `member` of rule number i.
template <class Work>
static void told_of(std::size_t i, const std::string& member, const Work& work)
{
    try {
        work();
    } catch (const std::invalid_argument& error) {
        throw std::invalid_argument(fmt::format("properties[{}].{}{}", i, member, error.what()));
    }
}

static void check_rule(const Inputs& in, std::size_t i)
{
    const Rule& rule = in.properties[i];
    told_of(i, "", [&] { check(rule.ramp); });
    if (rule.property == LocalProperty::own) {
        told_of(i, "name: ", [&] {
            geometry::check_own_name(rule.name);
            check_name(rule.name);
        });
    }
    if (rule.part.empty()) return;
    told_of(i, fmt::format("part \"{}\": ", rule.part), [&] {
        if (!in.mesh) {
            throw std::invalid_argument("parts are those of a mesh: link it to the input 'mesh'");
        }
        if (in.mesh->triangles().empty()) {
            throw std::invalid_argument("the mesh has no faces, and so no parts");
        }
    });
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    for (std::size_t i = 0; i < in.properties.size(); ++i) check_rule(in, i);
    const Paint paint = paint_of(in);
    Outputs out{*in.cubes};
    for (std::size_t i = 0; i < in.properties.size(); ++i) {
        const Rule& rule = in.properties[i];
        if (!rule.part.empty() && !paint.has_part(rule.part)) {
            context.warn(
                fmt::format("properties[{}].part \"{}\" matches no group or material of the mesh",
                            i, rule.part));
        }
        told_of(i, fmt::format("value \"{}\": ", rule.value),
                [&] { out.cubes = changed(std::move(out.cubes), rule, paint); });
    }
    return out;
}

static void describe_rule(graph::ParamsOf<Rule>& p)
{
    const graph::ShownWhen own{"property", {"own"}};
    p.choice("property", &Rule::property, {property_names.begin(), property_names.end()},
             "The property: young (Pa), density of the material (kg/m^3), poisson, mass_damping "
             "(1/s) or stiffness_damping (s); thickness of a Plane or a Sheet (m), whose density "
             "stays; or one of the user's own, which CubeMesh, Embed, Measure, Render and "
             "WriteMesh know by its name.")
        .param("name", &Rule::name, "Name of the user's own property.", {}, own)
        .param("unit", &Rule::unit, "Its unit, for legends of pictures.", {}, own)
        .param("value", &Rule::value,
               "Its value as an expression of the place at rest, without a leading =: x, y and z "
               "in m; r, g and b, from 0 to 1 and linear, where a mesh with vertex colours is "
               "linked; the names of that mesh's attributes; texture_r, texture_g, texture_b and "
               "texture_a, from 0 to 1 as the picture has them, where it has texture coordinates; "
               "and what the cubes have so far: young, density, poisson, mass_damping, "
               "stiffness_damping, fill, of a Plane or a Sheet thickness, and their own. Each cube "
               "gets the mean over its volume.")
        .block("ramp", &Rule::ramp, describe_ramp, about_ramp)
        .param("part", &Rule::part,
               "Applies only where the nearest face of the mesh is of such a group or material: * "
               "stands for any text, ? for any character. Elsewhere the property stays, or is 0 if "
               "it is new. Empty: everywhere. Where bodies that Voxelize made with pieces = each "
               "or groups touch or overlap, that face may be of another body.");
}

void add_to(graph::Registry& registry)
{
    registry.add("LocalMatter", 1, run)
        .summary("Varies the material of cubes and planes from place to place, and gives them "
                 "properties of the user's own: by expressions of position, or of the colours, "
                 "attributes and textures that a mesh is painted with.",
                 {"paint", "gradient", "graded", "stiffness map", "weight map", "vertex colour",
                  "attribute"})
        .input("cubes", &Inputs::cubes, "The cubes at rest.")
        .input(
            "mesh", &Inputs::mesh,
            "A mesh at rest with vertex colours (r, g and b), attributes or texture coordinates, "
            "which are read at the nearest point of its surface.",
            graph::Need::optional)
        .list("properties", &Inputs::properties, describe_rule,
              "Properties to change, one after the other, each by its own expression.")
        .path_in("texture", &Inputs::texture, about_texture)
        .output("cubes", &Outputs::cubes, "The cubes with their new material.");
}

}  // namespace nodes::local_matter
