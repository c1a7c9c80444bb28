#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "geometry/mesh/transform.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/obstacle_texts.hpp"
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
    double bounce = 0;
    double thickness = 0;
    std::shared_ptr<const geometry::TriangleBvh> tree;
    std::shared_ptr<const bool> open;
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

static bool is_open(const Inputs& in)
{
    return in.mesh && in.kind == Collider::Kind::mesh &&
           !geometry::is_closed(in.mesh->topology->triangles, in.mesh->positions.size());
}

constexpr const char* needs_mesh =
    "kind = mesh needs the input 'mesh': link a mesh that has triangles";

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    if (in.kind != Collider::Kind::mesh || setting.links("mesh")) return {};
    return {{"kind", needs_mesh}};
}

static Outputs run(const Inputs& in, const graph::Context&)
{
    Collider out;
    out.kind = in.kind;
    out.radius = in.sphere.radius;
    out.half_size = in.box.size / 2;
    out.friction = in.friction;
    out.bounce = in.bounce;
    out.thickness = in.thickness;
    if (in.kind == Collider::Kind::mesh) {
        if (!in.mesh || in.tree->triangle_count() == 0) {
            throw std::invalid_argument(needs_mesh);
        }
        out.mesh = in.mesh;
        out.tree = in.tree;
        out.sheet = *in.open;
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
        .summary("A rigid or animated obstacle with friction.",
                 {"obstacle", "collision", "static", "rigid", "wall"})
        .input("mesh", &Inputs::mesh,
               "The obstacle for kind = mesh, where it is at this frame. To move it, animate the "
               "mesh before it is linked here.",
               graph::Need::optional)
        .choice("kind", &Inputs::kind, {"plane", "sphere", "box", "mesh"},
                "Shape of the obstacle. plane: solid below its local y = 0. mesh: solid inside if "
                "it is closed; an open mesh is a sheet with two sides. What starts less than two "
                "cubes behind the front of a sheet is brought to its front.")
        .block<Sphere>(
            "sphere", &Inputs::sphere,
            [](graph::ParamsOf<Sphere>& p) {
                p.param("radius", &Sphere::radius, "Radius of the sphere.", {1e-9, 1e6, "m"});
            },
            "A sphere about its local origin.", {"kind", {"sphere"}})
        .block<Box>("box", &Inputs::box,
                    [](graph::ParamsOf<Box>& p) {
                        p.param("size", &Box::size, "Edge lengths along the local x, y and z.",
                                {1e-9, 1e6, "m"});
                    },
                    "A box about its local origin.", {"kind", {"box"}})
        .param("translate", &Inputs::translate,
               "Position of the local origin; keyframe it to move the obstacle. Has no effect on a "
               "mesh.",
               {.unit = "m"})
        .param(
            "rotate_degrees", &Inputs::rotate_degrees,
            "Rotation about x, then y, then z, each axis fixed in space. Has no effect on a mesh.",
            {.unit = "deg"})
        .param("friction", &Inputs::friction, friction_text, {.min = 0, .max = 100})
        .param("bounce", &Inputs::bounce, bounce_text, {.min = 0, .max = 1})
        .param("thickness", &Inputs::thickness,
               "Distance from the surface at which contact begins. A sheet keeps half of its own "
               "thickness besides. Its faces are flat between its corners: for cells of size h "
               "over a round collider of radius R, both together should be slightly more than "
               "h^2 / (8 R), or it shows through. Sharp edges need none.",
               {.unit = "m"})
        .prepare("tree", &Inputs::tree, build_tree, {"mesh", "kind"})
        .prepare("open", &Inputs::open, is_open, {"mesh", "kind"})
        .check(check)
        .output("collider", &Outputs::collider,
                "The obstacle at this frame and at the frame before.")
        .previous("collider", &Inputs::last);
}

}  // namespace nodes::collider
