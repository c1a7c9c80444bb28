#include "geometry/mesh/transform.hpp"
#include "geometry/mesh/measure.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::transform {

// The faces of a mirrored mesh, wound to face outwards again; null if nothing is mirrored.
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
        .summary("Scales, rotates and moves a mesh: p becomes pivot + translate + R S (p - pivot).",
                 {"move", "rotate", "scale", "xform", "place"})
        .input("mesh", &Inputs::mesh, "The mesh to transform.")
        .param("translate", &Inputs::translate, "Translation.", {.unit = "m"})
        .param("rotate_degrees", &Inputs::rotate_degrees,
               "Rotation about x, then y, then z, each axis fixed in space.", {.unit = "deg"})
        .param("scale", &Inputs::scale,
               "Scale factors along x, y and z, applied before the rotation. A negative factor "
               "mirrors.")
        .param("pivot", &Inputs::pivot, "Point that scaling and rotation leave in place.",
               {.unit = "m"})
        .prepare("mirrored", &Inputs::mirrored, mirror, {"mesh", "scale"})
        .output("mesh", &Outputs::mesh, "The transformed mesh.");
}

}  // namespace nodes::transform
