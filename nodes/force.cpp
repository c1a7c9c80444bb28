#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::force {

using geometry::Vec3;
using physics::Force;

struct Gravity {
    Vec3 acceleration{0, -9.81, 0};
};
struct Wind {
    Vec3 velocity{5, 0, 0};
    double air_density = 1.2;
    double drag = 1;
};
struct Point {
    Vec3 force{0, 0, 0};
    Vec3 position{0, 0, 0};
    double radius = 0.1;
};

struct Inputs {
    Force::Kind kind = Force::Kind::gravity;
    Gravity gravity;
    Wind wind;
    Point point;
};
struct Outputs {
    Force force;
};

static Outputs run(const Inputs& in, const graph::Context&)
{
    Force out;
    out.kind = in.kind;
    out.acceleration = in.gravity.acceleration;
    out.velocity = in.wind.velocity;
    out.air_density = in.wind.air_density;
    out.drag = in.wind.drag;
    out.force = in.point.force;
    out.position = in.point.position;
    out.radius = in.point.radius;
    return {out};
}

void add_to(graph::Registry& registry)
{
    registry.add("Force", 1, run)
        .summary("A force field: gravity, wind, or a point force. Every number can be keyframed.",
                 {"wind", "gravity", "turbulence", "field", "impulse", "explosion"})
        .choice("kind", &Inputs::kind, {"gravity", "wind", "point"}, "Kind of force.")
        .block<Gravity>("gravity", &Inputs::gravity,
                        [](graph::ParamsOf<Gravity>& p) {
                            p.param(
                                "acceleration", &Gravity::acceleration,
                                "Acceleration, in addition to the gravity of Simulate or Layered.",
                                {.unit = "m/s^2"});
                        },
                        "The same acceleration everywhere.", {"kind", {"gravity"}})
        .block<Wind>(
            "wind", &Inputs::wind,
            [](graph::ParamsOf<Wind>& p) {
                p.param("velocity", &Wind::velocity, "Velocity of the air.", {.unit = "m/s"})
                    .param("air_density", &Wind::air_density,
                           "Density of the air: 1.2 at sea level.",
                           {.min = 0, .max = 1e5, .unit = "kg/m^3"})
                    .param("drag", &Wind::drag,
                           "Drag coefficient: about 0.5 for a ball, 1.2 for a plate or cable.",
                           {.min = 0, .max = 1e4});
            },
            "Drag on the surface, from its area across the wind and its velocity relative to the "
            "air.",
            {"kind", {"wind"}})
        .block<Point>("point", &Inputs::point,
                      [](graph::ParamsOf<Point>& p) {
                          p.param(
                               "force", &Point::force,
                               "Total force, shared by all that it reaches: corners of cubes, or "
                               "the surface of layers.",
                               {.unit = "N"})
                              .param("position", &Point::position,
                                     "Where the force acts, in the rest shape.", {.unit = "m"})
                              .param("radius", &Point::radius,
                                     "Distance at which the force has faded smoothly to zero; 0: "
                                     "it acts at the point only.",
                                     {.min = 0, .unit = "m"});
                      },
                      "A force spread smoothly over the surface around a point, or over the "
                      "material if no surface is within the radius.",
                      {"kind", {"point"}})
        .output("force", &Outputs::force, "The force field at this frame.");
}

}  // namespace nodes::force
