#include "geometry/transform.hpp"
#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::collider {

using geometry::Vec3;
using physics::Collider;

struct Sphere {
    double radius = 0.5;
};
struct Box {
    Vec3 size{1, 1, 1};
};

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh;
    Collider::Kind kind = Collider::Kind::plane;
    Sphere sphere;
    Box box;
    Vec3 translate{0, 0, 0};
    Vec3 rotate_degrees{0, 0, 0};
    double friction = 0.5;
    double thickness = 0;
    std::shared_ptr<const geometry::TriangleBvh> tree;
    graph::Wire<Collider> last;
};
struct Outputs {
    Collider collider;
};

static geometry::TriangleBvh build_tree(const Inputs& in)
{
    return in.mesh && in.kind == Collider::Kind::mesh ? geometry::TriangleBvh(*in.mesh)
                                                      : geometry::TriangleBvh();
}

static Outputs run(const Inputs& in, const graph::Context&)
{
    Collider out;
    out.kind = in.kind;
    out.radius = in.sphere.radius;
    out.half_size = in.box.size / 2;
    out.friction = in.friction;
    out.thickness = in.thickness;
    if (in.kind == Collider::Kind::mesh) {
        if (!in.mesh || in.tree->triangle_count() == 0) {
            throw std::invalid_argument("kind = mesh needs triangles: link a mesh that has some "
                                        "to the input 'mesh'");
        }
        out.mesh = in.mesh;
        out.tree = in.tree;
        out.mesh_before = in.last ? in.last->mesh : nullptr;
    } else {
        out.pose = geometry::placement(in.translate, in.rotate_degrees, Vec3::Ones(), Vec3::Zero());
        out.before = in.last ? in.last->pose : out.pose;
    }
    return {out};
}

void add_to(graph::Registry& registry)
{
    registry.add("Collider", 1, run)
        .summary("A rigid or animated thing that bodies cannot enter and rub against.")
        .input("mesh", &Inputs::mesh,
               "For kind = mesh: the thing itself, where it is at this frame. Animate it upstream.",
               graph::Need::optional)
        .choice("kind", &Inputs::kind, {"plane", "sphere", "box", "mesh"},
                "Its shape. A plane is solid below its local y = 0. A closed mesh is solid "
                "inside; an open one a sheet, two cubes thick below its front.")
        .block<Sphere>("sphere", &Inputs::sphere,
                       [](graph::ParamsOf<Sphere>& p) {
                           p.param("radius", &Sphere::radius, "Its radius.", {1e-9, 1e6, "m"});
                       },
                       "A ball about its own origin.", {"kind", {"sphere"}})
        .block<Box>("box", &Inputs::box,
                    [](graph::ParamsOf<Box>& p) {
                        p.param("size", &Box::size, "Its edges along its own x, y and z.",
                                {1e-9, 1e6, "m"});
                    },
                    "A box about its own origin.", {"kind", {"box"}})
        .param("translate", &Inputs::translate,
               "Where its origin is; keyframe it to move it. A mesh stays where it is.",
               {.unit = "m"})
        .param("rotate_degrees", &Inputs::rotate_degrees,
               "Its turn about x, then y, then z, each fixed in space.", {.unit = "deg"})
        .param("friction", &Inputs::friction,
               "Coulomb coefficient: 0 is ice, 0.5 wood on wood, 1 rubber.", {.min = 0, .max = 100})
        .param(
            "thickness", &Inputs::thickness,
            "How far outside the surface contact begins. Faces of a sheet are flat between its "
            "corners: over a collider of radius R those of cells h want h^2 / (8 R) and a little, "
            "or it shows through.",
            {.unit = "m"})
        .prepare("tree", &Inputs::tree, build_tree, {"mesh", "kind"})
        .output("collider", &Outputs::collider, "The thing at this frame and how it got there.")
        .previous("collider", &Inputs::last);
}

}  // namespace nodes::collider
