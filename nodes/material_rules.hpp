#pragma once

// The parameters by which a node lets a user choose materials: one for the whole model (`matter`)
// and rules for parts of it (`materials`). Sample and Voxelize share them.

#include "geometry/cubes/assign_matter.hpp"
#include "geometry/cubes/known_matter.hpp"
#include "graph/types/context.hpp"
#include "graph/types/param_builder.hpp"

#include <fmt/format.h>

namespace nodes {

// 0: custom, else 1 + its place in known_matters.
enum class Preset : std::size_t {};

// The material of a model: a preset, or numbers.
struct ChosenMatter {
    Preset preset{};
    double density = geometry::Matter{}.density;
    double young = geometry::Matter{}.young;
    double poisson = geometry::Matter{}.poisson;
    double mass_damping = geometry::Matter{}.mass_damping;
    double stiffness_damping = geometry::Matter{}.stiffness_damping;
};

struct MaterialRule {
    geometry::MatterRule::Match match = geometry::MatterRule::Match::all;
    std::string name = "*";
    geometry::Vec3f colour{1, 1, 1};
    double tolerance = 0.1;
    Preset preset{};
    double density = geometry::Matter{}.density;
    double young = geometry::Matter{}.young;
    double poisson = geometry::Matter{}.poisson;
    double mass_damping = geometry::Matter{}.mass_damping;
    double stiffness_damping = geometry::Matter{}.stiffness_damping;
};

// What a block or list element says, under `name` where it is no preset.
template <class S> geometry::Matter matter_of(const S& from, const std::string& name = "default")
{
    const auto number = static_cast<std::size_t>(from.preset);
    if (number > 0) return geometry::known_matters.at(number - 1).matter();
    return {name,         from.density,      from.young,
            from.poisson, from.mass_damping, from.stiffness_damping};
}

inline std::vector<std::string> preset_names()
{
    std::vector<std::string> names{"custom"};
    for (const geometry::KnownMatter& m : geometry::known_matters) names.emplace_back(m.name);
    return names;
}

// Adds a preset and the five numbers of a material to a block or list element.
template <class S> void describe_matter(graph::ParamsOf<S>& p)
{
    const graph::ShownWhen custom{"preset", {"custom"}};
    p.choice("preset", &S::preset, preset_names(),
             "A material by its name, with its density, stiffness and damping (docs/materials.md); "
             "custom: the numbers below.")
        .param("density", &S::density, "Density of the solid material.", {1e-6, 1e9, "kg/m^3"},
               custom)
        .param("young", &S::young, "Young's modulus: the stiffness of the material.",
               {1e-6, 1e15, "Pa"}, custom)
        .param("poisson", &S::poisson,
               "Poisson's ratio: how much the material thins when stretched. Near 0.5 it keeps its "
               "volume.",
               {0, 0.4999, ""}, custom)
        .param("mass_damping", &S::mass_damping,
               "Rayleigh damping proportional to mass: damps all motion, slow swaying most.",
               {0, 1e6, "1/s"}, custom)
        .param("stiffness_damping", &S::stiffness_damping,
               "Rayleigh damping proportional to stiffness: damps fast vibration most.",
               {0, 1e6, "s"}, custom);
}

inline void describe_rule(graph::ParamsOf<MaterialRule>& p)
{
    p.choice("match", &MaterialRule::match, {"all", "material", "group", "colour"},
             "Which faces the rule matches. all: every face. material: by the name of the face's "
             "material. group: by the name of its group. colour: by its colour (of its vertices, "
             "or else of its material).")
        .param("name", &MaterialRule::name,
               "Name to match: * stands for any text, ? for any character. It also names the "
               "material of the matching faces.",
               {}, {"match", {"material", "group"}})
        .colour("colour", &MaterialRule::colour, "Colour to match.", {"match", {"colour"}})
        .param("tolerance", &MaterialRule::tolerance,
               "Largest difference from it in each component of a face's colour.", {0, 1, ""},
               {"match", {"colour"}});
    describe_matter(p);
}

// What a rule looks for, for people.
inline std::string sought(const MaterialRule& r)
{
    using Match = geometry::MatterRule::Match;
    if (r.match == Match::all) return "every face";
    if (r.match != Match::colour) return "\"" + r.name + "\"";
    return fmt::format("colour [{:.4g}, {:.4g}, {:.4g}], tolerance {:.4g}", r.colour.x(),
                       r.colour.y(), r.colour.z(), r.tolerance);
}

// The material of each face: that of the last rule that matches it, else `matter`. Warns about
// rules that match no face.
inline geometry::FaceMatter face_matter(const geometry::TriMesh& mesh,
                                        const geometry::Matter& matter,
                                        const std::vector<MaterialRule>& rules,
                                        const graph::Context& context)
{
    std::vector<geometry::MatterRule> list;
    for (const MaterialRule& r : rules) {
        geometry::Matter made_of = matter_of(r, r.name);
        made_of.name = r.name;
        list.push_back({r.match, r.name, r.colour, static_cast<float>(r.tolerance), made_of});
    }
    geometry::FaceMatter out = geometry::assign_matter(mesh, list, matter);
    for (const std::size_t i : out.idle) {
        context.warn(
            fmt::format("materials[{}] ({}) matches no face of the mesh", i, sought(rules[i])));
    }
    return out;
}

}  // namespace nodes
