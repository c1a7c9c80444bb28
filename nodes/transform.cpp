#include "geometry/transform.hpp"
#include "geometry/measure.hpp"
#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::transform {

// A mirrored mesh's faces, wound to face outwards again; null where nothing is mirrored.
struct Mirrored {
    std::shared_ptr<const geometry::MeshTopology> topology;
};

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh;
    geometry::Vec3 translate{0, 0, 0};
    geometry::Vec3 rotate_degrees{0, 0, 0};
    geometry::Vec3 scale{1, 1, 1};
    geometry::Vec3 pivot{0, 0, 0};
    std::shared_ptr<const Mirrored> mirrored;
};
struct Outputs {
    geometry::TriMesh mesh;
};

static Mirrored mirror(const Inputs& in)
{
    if (!geometry::mirrors(in.scale.asDiagonal())) return {};
    return {std::make_shared<const geometry::MeshTopology>(
        geometry::turned_inside_out(*in.mesh->topology))};
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    Outputs out{*in.mesh};
    geometry::move(out.mesh,
                   geometry::placement(in.translate, in.rotate_degrees, in.scale, in.pivot));
    if (const std::string far = geometry::far_from_origin(out.mesh); !far.empty()) {
        context.warn(far);
    }
    if (in.mirrored->topology) out.mesh.topology = in.mirrored->topology;
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Transform", 1, run)
        .summary("Scales, turns and moves a mesh: p becomes pivot + translate + R S (p - pivot).")
        .input("mesh", &Inputs::mesh, "What to move.")
        .param("translate", &Inputs::translate, "By how much to move it.", {.unit = "m"})
        .param("rotate_degrees", &Inputs::rotate_degrees,
               "Turns about the x axis, then y, then z, each fixed in space.", {.unit = "deg"})
        .param("scale", &Inputs::scale,
               "Factors along x, y and z, before turning; a negative one mirrors.")
        .param("pivot", &Inputs::pivot, "The point that scaling and turning leave in place.",
               {.unit = "m"})
        .prepare("mirrored", &Inputs::mirrored, mirror, {"mesh", "scale"})
        .output("mesh", &Outputs::mesh, "The moved mesh.");
}

}  // namespace nodes::transform
