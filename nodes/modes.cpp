#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/state/hold_matter.hpp"
#include "physics/state/pins.hpp"

#include <cmath>
#include <numbers>

namespace nodes::modes {

struct Inputs {
    graph::Wire<geometry::Cubes> cubes;
    graph::Wire<geometry::TriMesh> mesh;
    graph::Wire<physics::Pins> pins;
    int count = 20;
    bool keep_rigid = false;
    physics::Weighting weighting = physics::Weighting::filled;
    physics::BrickElement element = physics::BrickElement::incompatible;
};
struct Outputs {
    physics::ModalModel model;
    double lowest_frequency = 0;
};

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (in.pins) physics::require_all_axes(*in.pins, "Modes");
    if (in.pins) physics::check_held(*in.cubes, in.pins->matter);
    const std::vector<std::uint32_t> pinned =
        in.pins ? in.pins->corner : std::vector<std::uint32_t>{};
    const std::vector<physics::HeldCube> held =
        in.pins ? in.pins->matter.cubes : std::vector<physics::HeldCube>{};
    const physics::Modes modes = physics::lowest_modes(
        *in.cubes, pinned, {in.count, in.keep_rigid, in.weighting, in.element}, held);
    Outputs out{physics::make_modal_model(modes, *in.cubes, in.mesh)};
    for (const auto& warning : out.model.warnings) context.warn(warning);
    for (const double omega_sq : modes.omega_sq) {
        if (omega_sq == 0) continue;
        out.lowest_frequency = std::sqrt(omega_sq) / (2 * std::numbers::pi);
        break;
    }
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Modes", 1, run)
        .summary("Computes the lowest vibration modes of a model of cubes, and keeps them at the "
                 "vertices of its mesh.",
                 {"vibration", "eigen", "modal", "eigenmodes"})
        .input("cubes", &Inputs::cubes, "The model at rest, with its materials.")
        .input("mesh", &Inputs::mesh, "The mesh that the cubes carry.")
        .input("pins", &Inputs::pins,
               "Corners that do not move, or points of the material that are held. Without pins "
               "the body is free, and its rigid motions are "
               "left out.",
               graph::Need::optional)
        .bends("cubes", [](const Inputs&, const std::size_t&) { return true; })
        .param("count", &Inputs::count, "Number of modes, from the lowest frequency up.",
               {.min = 1, .max = 10'000})
        .param("keep_rigid", &Inputs::keep_rigid,
               "Whether the modes of a free body include its rigid motions, as the first ones.")
        .choice(
            "weighting", &Inputs::weighting, {"filled", "full"},
            "filled: a partly filled cube has that share of the stiffness. full: it has all of it.")
        .choice("element", &Inputs::element, {"incompatible", "trilinear"},
                "incompatible: right in bending even one cube thick. trilinear: too stiff in "
                "bending; for comparison only.")
        .output("model", &Outputs::model, "The modes at the vertices, for Vibrate.")
        .output("lowest_frequency", &Outputs::lowest_frequency,
                "Frequency of the lowest mode that is not a rigid motion, Hz; 0 if there is none.");
}

}  // namespace nodes::modes
