#include "physics/state/gusts.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::gusts {

using geometry::Vec3;
using physics::Force;

struct Inputs {
    Vec3 velocity{5, 0, 0};
    double speed = 1.5;
    double size = 1;
    int seed = 0;
    double air_density = 1.2;
    double drag = 1;
    graph::Wire<Force> last;
};
struct Outputs {
    Force force;
};

static Outputs run(const Inputs& in, const graph::Context& context)
{
    Force out;
    out.kind = Force::Kind::wind;
    out.velocity = in.velocity;
    out.air_density = in.air_density;
    out.drag = in.drag;
    out.gusts = {.speed = in.speed, .size = in.size, .seed = static_cast<std::uint32_t>(in.seed)};
    if (in.last) {
        physics::let_pass(*in.last, context.frame_seconds(), out);
        out.began_as(*in.last);
    }
    return {out};
}

void add_to(graph::Registry& registry)
{
    registry.add("Gusts", 1, run)
        .summary("A wind whose speed and direction vary from place to place and from frame to "
                 "frame.",
                 {"wind", "turbulence", "gust", "air", "noise", "breeze", "storm", "flow"})
        .param("velocity", &Inputs::velocity, "Mean velocity of the air, which carries the gusts.",
               {.unit = "m/s"})
        .param("gusts", &Inputs::speed,
               "Root mean square of how much the velocity differs from its mean: 0.2 to 0.4 of a "
               "wind near the ground.",
               {.min = 0, .max = 1e4, .unit = "m/s"})
        .param("size", &Inputs::size,
               "Wave length of the largest gusts; the finest are a sixteenth of it. Gusts as large "
               "as what they blow at push it as a whole.",
               {.min = 1e-3, .max = 1e6, .unit = "m"})
        .param("seed", &Inputs::seed, "Another number, other gusts.", {.min = 0, .max = 1e9})
        .param("air_density", &Inputs::air_density, "Density of the air, as that of Force.",
               {.min = 0, .max = 1e5, .unit = "kg/m^3"})
        .param("drag", &Inputs::drag, "Drag coefficient, as that of Force.", {.min = 0, .max = 1e4})
        .output("force", &Outputs::force, "The wind at this frame and at the frame before.")
        .previous("force", &Inputs::last)
        .reads(graph::Variable::fps);
}

}  // namespace nodes::gusts
