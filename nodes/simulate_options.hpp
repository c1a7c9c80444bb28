#pragma once

// The blocks of parameters of Simulate, as documents have them.

#include "graph/types/node_builder.hpp"
#include "nodes/simulate_contact_options.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/springs.hpp"
#include "physics/lattice/lattice.hpp"
#include "physics/shell/shell.hpp"

#include <algorithm>

namespace nodes::simulate {

using geometry::Vec3;

inline void describe_plastic(graph::ParamsOf<physics::PlasticOptions>& p)
{
    using physics::PlasticOptions;
    p.param("yield", &PlasticOptions::yield,
            "Strain above which the rest shape changes for good (it yields); 0: never.",
            {.min = 0, .max = 10})
        .param(
            "flow", &PlasticOptions::flow,
            "Rate at which the rest shape changes above the yield strain. 1e6: in one step, by a "
            "strain of 0.2 at most.",
            {.min = 0, .max = 1e6, .unit = "1/s"})
        .param("limit", &PlasticOptions::limit, "Largest change of the rest shape, as a strain.",
               {.min = 0, .max = 0.95});
}

inline void describe_bricks(graph::ParamsOf<physics::BrickOptions>& p)
{
    p.choice("element", &physics::BrickOptions::element, {"incompatible", "trilinear", "one_point"},
             "incompatible: right in bending even one cube thick. trilinear: too stiff in bending; "
             "for comparison. one_point: finite differences with hourglass control and lumped "
             "mass; a quarter faster, but a plate one cube thick bends 26 % too far, of two 7 %.")
        .choice(
            "law", &physics::BrickOptions::law, {"corotated", "neo_hookean"},
            "corotated: stress is proportional to the strain that turns with each cube; right "
            "for strains below about a tenth. neo_hookean: rubber and flesh at large strains, "
            "which keep their volume better and stiffen as they are squashed (stable "
            "Neo-Hookean); each cube's mean deformation follows it, its bending stays "
            "corotated. A step takes 2 to 4 times as long; set newton_iterations to 10 where it "
            "stretches far within few frames.")
        .choice("weighting", &physics::BrickOptions::weighting, {"filled", "full"},
                "filled: a partly filled cube has that share of the stiffness. full: all of it.")
        .block<physics::PlasticOptions>(
            "plastic", &physics::BrickOptions::plastic, describe_plastic,
            "Plastic deformation: a permanent change of each cube's rest shape, its bending too. A "
            "cube yields by its strain without the change of volume.");
}

inline void describe_springs(graph::ParamsOf<physics::SpringOptions>& p)
{
    p.param("bending", &physics::SpringOptions::bending,
            "Share of the stiffness along the axes that is carried by springs across two cubes, "
            "which resist bending.",
            {.min = 0, .max = 0.9});
}

inline void describe_shell(graph::ParamsOf<physics::ShellOptions>& p)
{
    using physics::ShellOptions;
    p.param("stretch", &ShellOptions::stretch,
            "Stretch stiffness: a multiple of what material and thickness give.",
            {.min = 1e-6, .max = 1e6})
        .param("bend", &ShellOptions::bend,
               "Bending stiffness: a multiple of what material and thickness give, for cloth often "
               "0.01 to 0.1. A pinned row of corners is a hinge. Two pinned rows are a clamp at "
               "the row next to the free corners.",
               {.min = 0, .max = 1e6})
        .block<physics::PlasticOptions>(
            "plastic", &ShellOptions::plastic, describe_plastic,
            "Plastic deformation: a permanent change of the rest shape, dents and creases. A Plane "
            "is stepped as triangles then, which takes 3 to 20 times as long.");
}

inline void describe_lattice(graph::ParamsOf<physics::LatticeOptions>& p)
{
    using physics::LatticeOptions;
    p.param("half_width", &LatticeOptions::half_width,
            "Half width of a region, in cubes. A region is a group of cubes that keeps its shape: "
            "wider regions are stiffer and smoother, at the same cost. With stiffness = material "
            "it should be at most a tenth of a beam's length, or a sixteenth of a sheet's: at "
            "twice that, a beam bends a tenth and a sheet a third too far.",
            {.min = 1, .max = 64})
        .choice("stiffness", &LatticeOptions::stiffness, {"material", "rate"},
                "Source of the stiffness. material: Young's modulus and Poisson's ratio, as far as "
                "regions and substeps can. rate: the parameter rate; Poisson's ratio acts as 0.")
        .choice("calibrate", &LatticeOptions::calibrate, {"bending", "stretch", "both"},
                "What the stiffness from the material is right for. both: stretch and bends. "
                "bending: a bend of the whole body; parts one cube thick then stretch 3 to 9 times "
                "too far. stretch: long waves of stretch; such parts then bend a third as far as "
                "they should, or less. docs/lattice-error.md has the errors of 24 shapes.",
                {"stiffness", {"material"}})
        .param("rate", &LatticeOptions::rate,
               "Rate at which a region pulls its cubes back, whatever the time step. 0: not at "
               "all; very large: as stiff as the method allows.",
               {.min = 0, .unit = "1/s"}, {"stiffness", {"rate"}})
        .param(
            "bend", &LatticeOptions::bend,
            "Bending stiffness of a plane: a multiple of what its thickness gives or, with "
            "stiffness = rate, of its stretch stiffness. Its stretch stiffness is at least as "
            "large: with half width w, a plane thicker than w cells is too stiff in its plane. "
            "Within w cells of a free rim, the bending stiffness is too small. To clamp a rim, pin "
            "it w cells deep; pinning one row of corners makes a hinge. A force on a single corner "
            "makes a dimple of w cells, deeper for wider regions. Corners that move away from "
            "their neighbours by more than 2.5 cells per substep add energy; a warning reports it.",
            {.min = 0})
        .param(
            "damping", &LatticeOptions::damping,
            "Damping proportional to stiffness, in addition to that of the material. The damping "
            "ratio of a vibration of frequency f is pi f damping. A substep bears only so much, "
            "for stiff materials a millisecond or less: where less than half acts, a warning "
            "reports how much. mass_damping of the matter has no such limit.",
            {.min = 0, .unit = "s"})
        .choice(
            "weighting", &LatticeOptions::weighting, {"filled", "full"},
            "filled: a partly filled cube has that share of the stiffness. full: it has all of it.")
        .choice("plane", &LatticeOptions::plane, {"space", "in_plane"},
                "Motion of a plane. space: it moves in space (folds, flips, rolls). in_plane: it "
                "moves within its plane only.")
        .block<physics::PlasticOptions>(
            "plastic", &LatticeOptions::plastic, describe_plastic,
            "Plastic deformation: a permanent change of each region's rest shape.")
        .param("tear", &LatticeOptions::tear,
               "Strain at which a link between neighbouring corners breaks: 1 is twice its length, "
               "0: never. Embed cuts meshes along the tear.",
               {.min = 0, .max = 1000})
        .block<physics::BodyContactOptions>(
            "contact", &LatticeOptions::contact, describe_contact,
            "Contact between bodies that are not linked, and of a body with itself.")
        .choice("precision", &LatticeOptions::precision, {"single", "full"},
                "Precision of the sums over regions. Motion is always in double precision.");
}

// The steps of a graph's frames: as many as are needed, where nothing else is said.
struct FrameSteps : physics::StepOptions {
    FrameSteps() { substeps = 0; }
};

// A member of StepOptions as one of FrameSteps.
template <class T> constexpr T FrameSteps::*of_steps(T physics::StepOptions::*member)
{
    return member;
}

inline void describe_step(graph::ParamsOf<FrameSteps>& p)
{
    p.choice(
         "integrator", of_steps(&physics::StepOptions::integrator),
         {"implicit_euler", "implicit_midpoint", "sdirk2"},
         "implicit_euler: the most robust; damps all vibration, with n steps a period by pi / n of "
         "critical damping: 6.5 % at 48, so that resonance needs another one. Bodies in free fall "
         "follow a parabola however long the steps, unless drag stops them soon. "
         "implicit_midpoint: no damping. sdirk2: accurate; damps only what the steps cannot "
         "resolve, at twice the cost, and keeps the angular momentum of what spins only as far as "
         "its steps are short. A step in which the body hits something is one of "
         "implicit_euler, whatever is chosen.")
        .param(
            "substeps", of_steps(&physics::StepOptions::substeps),
            "Steps per frame. More steps resolve fast motion and vibration better. 0: as many as "
            "are needed. With method = lattice those are as many as its material needs to be as "
            "stiff as it is and to keep its volume, up to 1000 (1 with lattice.stiffness = "
            "rate). With other methods they are as many, up to 32, as keep the error of each "
            "within step.error: more in impacts, and where something rolls or pushes cloth; 1 "
            "with another step.integrator than implicit_euler, whose error is not known.",
            {.min = 0, .max = physics::most_substeps})
        .param("error", of_steps(&physics::StepOptions::error),
               "Largest error of a time step, in edges of cubes or cells, where substeps = 0 "
               "(other methods than lattice): half of the change of a corner's velocity in the "
               "step, times its duration. The motion of free parts as a whole has none. 0.03 "
               "takes twice the steps of 0.1.",
               {.min = 1e-4, .max = 10})
        .param("tolerance", of_steps(&physics::StepOptions::tolerance),
               "Tolerance: the share of the acting forces that may be left unbalanced at the end "
               "of a step.",
               {.min = 1e-12, .max = 0.1})
        .param("newton_iterations", of_steps(&physics::StepOptions::newton_iterations),
               "Newton iterations per step. 1 is enough for most scenes; use more for large "
               "deformation of solids with large steps. For thin stiff sheets take more substeps: "
               "with 2 to 10 iterations they fall slower than with 1.",
               {.min = 1, .max = 100})
        .param("contact_iterations", of_steps(&physics::StepOptions::contact_iterations),
               "Largest number of solves per step to find which points are in contact.",
               {.min = 1, .max = 1000})
        .param("solver_iterations", of_steps(&physics::StepOptions::solver_iterations),
               "Largest number of conjugate gradient iterations per solve.",
               {.min = 1, .max = 1'000'000})
        .param(
            "sleep", of_steps(&physics::StepOptions::sleep),
            "Whether a frame is skipped in which nothing would move: bodies that have been at "
            "rest for 12 frames, under forces that still balance. A load, a pin or a collider "
            "that moves wakes them. All bodies of a Simulate sleep together. false: also what is "
            "balanced on an edge, or pressed beyond buckling, moves as its smallest error grows.");
}

}  // namespace nodes::simulate
