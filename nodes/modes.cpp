#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

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
    const std::vector<std::uint32_t> pinned =
        in.pins ? in.pins->corner : std::vector<std::uint32_t>{};
    const physics::Modes modes = physics::lowest_modes(
        *in.cubes, pinned, {in.count, in.keep_rigid, in.weighting, in.element});
    for (const auto& warning : modes.report.warnings) context.warn(warning);
    Outputs out{physics::make_modal_model(modes, *in.cubes, in.mesh)};
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
        .summary("Finds how a model of cubes vibrates, and keeps only the modes of its mesh.")
        .input("cubes", &Inputs::cubes, "The model at rest, and what it is made of.")
        .input("mesh", &Inputs::mesh, "What the modes are for: the mesh that the cubes carry.")
        .input("pins", &Inputs::pins,
               "Corners that do not move; without any the body floats, and its rigid motions are "
               "left out.",
               graph::Need::optional)
        .param("count", &Inputs::count, "How many modes, from the lowest.",
               {.min = 1, .max = 10'000})
        .param("keep_rigid", &Inputs::keep_rigid,
               "Whether rigid motions of a body that is not held are listed too, first.")
        .choice("weighting", &Inputs::weighting, {"filled", "full"},
                "filled gives a partly filled cube that share of the stiffness, full all of it.")
        .choice("element", &Inputs::element, {"incompatible", "trilinear"},
                "incompatible bends rightly even one cube thick; trilinear is too stiff in bending "
                "and only here to compare.")
        .output("model", &Outputs::model, "The modes at the vertices, for Vibrate.")
        .output("lowest_frequency", &Outputs::lowest_frequency,
                "Of the lowest mode that is no rigid motion, in Hz; 0 without any.");
}

}  // namespace nodes::modes
