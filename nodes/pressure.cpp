#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/body/press_on.hpp"

#include <fmt/format.h>

namespace nodes::pressure {

// The surface as it is kept, shared by the forces of all frames.
struct Surface {
    std::shared_ptr<const physics::PressedSurface> is;
    std::size_t turned = 0, one_way = 0, faces = 0;
    double farthest = 0, size = 0;

    std::size_t bytes() const
    {
        const auto of = [](const auto& v) { return v.size() * sizeof v[0]; };
        return sizeof *this + of(is->corners) + of(is->weight) + of(is->faces);
    }
};

struct Inputs {
    graph::Wire<geometry::Cubes> cubes;
    graph::Wire<geometry::TriMesh> mesh;
    double pressure = 1000;
    std::string part;
    std::shared_ptr<const Surface> surface;
    graph::Wire<physics::Force> last;
};
struct Outputs {
    physics::Force force;
};

static Surface build(const Inputs& in)
{
    physics::PressOn made = physics::press_on(*in.cubes, *in.mesh, in.part);
    return {std::make_shared<const physics::PressedSurface>(std::move(made.surface)),
            made.turned,
            made.one_way,
            in.mesh->triangles().size(),
            made.farthest,
            in.cubes->size};
}

static void warn_of_surface(const Surface& surface, const graph::Context& context)
{
    if (surface.turned > 0) {
        context.warn(fmt::format("{} of {} faces of the mesh are wound inwards, or against the "
                                 "others of their piece: pressure takes them as if they faced out. "
                                 "Turn them in the mesh, if that is wrong",
                                 surface.turned, surface.faces));
    }
    if (surface.one_way > 0) {
        context.warn(fmt::format("the mesh has no inside: {} of its edges have two faces that "
                                 "cannot both face out. Pressure pushes to either side there",
                                 surface.one_way));
    }
    if (surface.farthest > surface.size) {
        context.warn(fmt::format("the mesh is up to {:.2g} m away from the cubes, more than their "
                                 "edge of {:.2g} m: link the mesh that they were made of",
                                 surface.farthest, surface.size));
    }
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    warn_of_surface(*in.surface, context);
    Outputs out;
    out.force.kind = physics::Force::Kind::pressure;
    out.force.pressure = in.pressure;
    out.force.surface = in.surface->is;
    if (in.last) out.force.began_as(*in.last);
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Pressure", 1, run)
        .summary("Pressure on the surface of a body, which follows the surface as it deforms.",
                 {"inflate", "balloon", "hydrostatic", "gas", "follower", "vacuum"})
        .input("cubes", &Inputs::cubes, "The cubes at rest, which carry the surface.")
        .input("mesh", &Inputs::mesh,
               "The mesh at rest that is pressed on, as a rule the one that the cubes were made "
               "of. Its winding tells which way is out of the material. Pieces that are wound "
               "inwards and lie in no other, and faces that are wound against the rest of their "
               "piece, are taken the other way round, with a warning. A closed piece within "
               "another is a hollow where the cubes leave it empty, however it is wound.")
        .param("pressure", &Inputs::pressure,
               "Pressure on the outside of the material: above 0 it pushes in, below 0 it sucks. "
               "For a hollow body, press on the faces of the hollow. It should stay below a tenth "
               "of Young's modulus, because a step takes the direction of the pressure before it "
               "deforms the body.",
               {.unit = "Pa"})
        .param("part", &Inputs::part,
               "Name of the material or group of the mesh that is pressed on; empty: all of it.")
        .prepare("surface", &Inputs::surface, build, {"cubes", "mesh", "part"})
        .output("force", &Outputs::force,
                "The pressure at this frame and at the frame before, for Simulate.")
        .previous("force", &Inputs::last, graph::Memory::of_motion);
}

}  // namespace nodes::pressure
