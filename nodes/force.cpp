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
    bool follow = false;
};
struct Torque {
    Vec3 torque{0, 0, 0};
    Vec3 position{0, 0, 0};
    double radius = 0.1;
    bool follow = false;
};

struct Radial {
    double outward = 10;
    Vec3 swirl{0, 0, 0};
    Vec3 position{0, 0, 0};
    double radius = 1;
};

// What node Force makes; a pressure is made by node Pressure.
enum class Kind { gravity, wind, point, torque, radial };

struct Inputs {
    Kind kind = Kind::gravity;
    Gravity gravity;
    Wind wind;
    Point point;
    Torque torque;
    Radial radial;
    graph::Wire<Force> last;
};
struct Outputs {
    Force force;
};

static_assert(static_cast<Force::Kind>(Kind::wind) == Force::Kind::wind &&
              static_cast<Force::Kind>(Kind::point) == Force::Kind::point &&
              static_cast<Force::Kind>(Kind::torque) == Force::Kind::torque &&
              static_cast<Force::Kind>(Kind::radial) == Force::Kind::radial);

static Outputs run(const Inputs& in, const graph::Context&)
{
    Force out;
    out.kind = static_cast<Force::Kind>(in.kind);
    out.acceleration = in.gravity.acceleration;
    out.velocity = in.wind.velocity;
    out.air_density = in.wind.air_density;
    out.drag = in.wind.drag;
    out.force = in.point.force;
    out.position = in.point.position;
    out.radius = in.point.radius;
    out.follow = in.point.follow;
    if (in.kind == Kind::torque) {
        out.torque = in.torque.torque;
        out.position = in.torque.position;
        out.radius = in.torque.radius;
        out.follow = in.torque.follow;
    }
    if (in.kind == Kind::radial) {
        out.outward = in.radial.outward;
        out.swirl = in.radial.swirl;
        out.position = in.radial.position;
        out.radius = in.radial.radius;
    }
    if (in.last) out.began_as(*in.last);
    return {out};
}

static void describe(graph::ParamsOf<Gravity>& p)
{
    p.param("acceleration", &Gravity::acceleration,
            "Acceleration, in addition to the gravity of Simulate or Layered.", {.unit = "m/s^2"});
}

static void describe(graph::ParamsOf<Wind>& p)
{
    p.param("velocity", &Wind::velocity, "Velocity of the air.", {.unit = "m/s"})
        .param("air_density", &Wind::air_density, "Density of the air: 1.2 at sea level.",
               {.min = 0, .max = 1e5, .unit = "kg/m^3"})
        .param("drag", &Wind::drag,
               "Drag coefficient: about 0.5 for a ball, 1.2 for a plate or cable. Each side of a "
               "Sheet and the outside of a solid counts: a balloon made by Sheet takes half of the "
               "value, and a solid whose `surface` is an open mesh twice.",
               {.min = 0, .max = 1e4});
}

static void describe(graph::ParamsOf<Point>& p)
{
    p.param("force", &Point::force,
            "Total force, shared by all that it reaches: corners of cubes, or the surface of "
            "layers.",
            {.unit = "N"})
        .param("position", &Point::position, "Where the force acts, in the rest shape.",
               {.unit = "m"})
        .param("radius", &Point::radius,
               "Distance at which the force has faded smoothly to zero; 0: it acts at the point "
               "only.",
               {.min = 0, .unit = "m"})
        .param("follow", &Point::follow,
               "Whether the force turns with what it acts on, by the mean rotation within the "
               "radius (methods bricks, springs and shell of Simulate).");
}

static void describe(graph::ParamsOf<Torque>& p)
{
    p.param("torque", &Torque::torque,
            "Total torque. It turns what it acts on about an axis along this vector, through its "
            "centre, by the right-hand rule.",
            {.unit = "N m"})
        .param("position", &Torque::position, "Where the torque acts, in the rest shape.",
               {.unit = "m"})
        .param("radius", &Torque::radius,
               "Distance at which the torque has faded smoothly to zero.", {.min = 0, .unit = "m"})
        .param("follow", &Torque::follow, "Whether its axis turns with what it acts on.");
}

static void describe(graph::ParamsOf<Radial>& p)
{
    p.param("outward", &Radial::outward,
            "Acceleration away from the position, whatever the mass; below 0: towards it. An "
            "explosion has 100 or more for one frame.",
            {.unit = "m/s^2"})
        .param("swirl", &Radial::swirl,
               "Acceleration around an axis along this vector through the position, by the "
               "right-hand rule.",
               {.unit = "m/s^2"})
        .param("position", &Radial::position, "Where it starts from, in the world.", {.unit = "m"})
        .param("radius", &Radial::radius,
               "Distance at which it has faded smoothly to zero. Within a tenth of it, it grows "
               "from 0 at the position.",
               {.min = 1e-6, .max = 1e6, .unit = "m"});
}

void add_to(graph::Registry& registry)
{
    registry.add("Force", 1, run)
        .summary("A force field: gravity, wind, a point force, a torque, or a radial push, pull or "
                 "swirl. Every number can be keyframed.",
                 {"moment", "wind", "gravity", "field", "impulse", "explosion", "attractor",
                  "vortex", "magnet", "tornado", "blast"})
        .choice("kind", &Inputs::kind, {"gravity", "wind", "point", "torque", "radial"},
                "Kind of force. Wind with gusts: node Gusts.")
        .block<Gravity>("gravity", &Inputs::gravity, describe, "The same acceleration everywhere.",
                        {"kind", {"gravity"}})
        .block<Wind>("wind", &Inputs::wind, describe,
                     "Drag on the surface, from its area across the wind and its velocity relative "
                     "to the air.",
                     {"kind", {"wind"}})
        .block<Point>("point", &Inputs::point, describe,
                      "A force spread smoothly over the surface around a point, or over the "
                      "material if no surface is within the radius.",
                      {"kind", {"point"}})
        .block<Torque>("torque", &Inputs::torque, describe,
                       "A torque spread smoothly over the surface around a point, as forces that "
                       "push nowhere together (methods bricks, springs and shell of Simulate).",
                       {"kind", {"torque"}})
        .block<Radial>("radial", &Inputs::radial, describe,
                       "An acceleration away from a place, towards it, or around it, of all that "
                       "is near (Simulate and Layered).",
                       {"kind", {"radial"}})
        .output("force", &Outputs::force, "The force field at this frame and at the frame before.")
        .previous("force", &Inputs::last, graph::Memory::of_motion);
}

}  // namespace nodes::force
