#pragma once

// How nodes let a user say what a model is made of: one matter for all, and rules for parts of it.

#include "geometry/assign_matter.hpp"
#include "graph/context.hpp"
#include "graph/param.hpp"

namespace nodes {

struct MaterialRule {
    geometry::MatterRule::Match match = geometry::MatterRule::Match::all;
    std::string name = "*";
    geometry::Vec3f colour{1, 1, 1};
    double tolerance = 0.1;
    double density = geometry::Matter{}.density;
    double young = geometry::Matter{}.young;
    double poisson = geometry::Matter{}.poisson;
    double mass_damping = geometry::Matter{}.mass_damping;
    double stiffness_damping = geometry::Matter{}.stiffness_damping;
};

// The five numbers of a matter, as parameters of a block or list element.
template <class S> void describe_matter(graph::ParamsOf<S>& p)
{
    p.param("density", &S::density, "Mass of a volume of the solid material.",
            {1e-6, 1e9, "kg/m^3"})
        .param("young", &S::young, "Young's modulus: how stiff it is.", {1e-6, 1e15, "Pa"})
        .param("poisson", &S::poisson,
               "Poisson ratio: how much it thins when stretched; near 0.5 it keeps its volume.",
               {0, 0.499, ""})
        .param("mass_damping", &S::mass_damping,
               "Rayleigh damping in proportion to mass: slows all motion, slow swaying most.",
               {0, 1e6, "1/s"})
        .param("stiffness_damping", &S::stiffness_damping,
               "Rayleigh damping in proportion to stiffness: takes out fast vibration first.",
               {0, 1e6, "s"});
}

inline void describe_rule(graph::ParamsOf<MaterialRule>& p)
{
    p.choice("match", &MaterialRule::match, {"all", "material", "group", "colour"},
             "What a face is known by: nothing, its material's name, its group's name, or its "
             "colour (of its vertices, else of its material).")
        .param("name", &MaterialRule::name,
               "The name to match: * stands for any text, ? for any character. It also labels "
               "the matter.",
               {}, {"match", {"material", "group"}})
        .colour("colour", &MaterialRule::colour, "The colour to match.", {"match", {"colour"}})
        .param("tolerance", &MaterialRule::tolerance,
               "How far each component of a face's colour may be from it.", {0, 1, ""},
               {"match", {"colour"}});
    describe_matter(p);
}

// `matter` and `rules` for each face. Warns about rules that match nothing.
inline geometry::FaceMatter face_matter(const geometry::TriMesh& mesh,
                                        const geometry::Matter& matter,
                                        const std::vector<MaterialRule>& rules,
                                        const graph::Context& context)
{
    std::vector<geometry::MatterRule> list;
    for (const MaterialRule& r : rules) {
        list.push_back(
            {r.match,
             r.name,
             r.colour,
             static_cast<float>(r.tolerance),
             {r.name, r.density, r.young, r.poisson, r.mass_damping, r.stiffness_damping}});
    }
    geometry::FaceMatter out = geometry::assign_matter(mesh, list, matter);
    for (const std::size_t i : out.idle) {
        context.warn("materials[" + std::to_string(i) + "] (\"" + rules[i].name +
                     "\") matches no face of the mesh");
    }
    return out;
}

}  // namespace nodes
