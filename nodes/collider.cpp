#include "geometry/mesh/doubled_faces.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "geometry/mesh/same_triangles.hpp"
#include "geometry/mesh/transform.hpp"
#include "geometry/mesh/wound_out.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/doubled_faces.hpp"
#include "nodes/obstacle_texts.hpp"
#include "nodes/wire_types.hpp"
#include "physics/body/collider_features.hpp"

#include <fmt/format.h>

#include <limits>

namespace nodes::collider {

using geometry::Vec3;
using physics::Collider;

struct Sphere {
    double radius = 0.5;
};
struct Box {
    Vec3 size{1, 1, 1};
};

// A mesh as it stops others.
struct Obstacle {
    // Each face once and, of a solid, turned out; null: as those of the mesh are.
    std::shared_ptr<const geometry::TriMesh> mended;
    geometry::TriangleBvh tree;
    std::shared_ptr<const physics::KeptFeatures> features =
        std::make_shared<const physics::KeptFeatures>();
    std::size_t faces_turned = 0, faces_doubled = 0;
    bool open = false;

    std::size_t bytes() const  // but for features, which are found when a body comes near
    {
        std::size_t out = sizeof *this + tree.bytes();
        if (mended) out += mended->positions.size() * sizeof mended->positions[0];
        if (mended) out += mended->triangles().size() * sizeof mended->triangles()[0];
        return out;
    }
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
    std::shared_ptr<const Obstacle> obstacle;
    graph::Wire<Collider> last;
};
struct Outputs {
    Collider collider;
};

// Faces of a solid that look in are turned out: without it, points would be pushed in by them. Of a
// surface with two sides one stays: the nearer of both would be either by chance, and a sheet of
// them would count as closed.
static Obstacle make_obstacle(const Inputs& in)
{
    Obstacle out;
    if (!in.mesh || in.kind != Collider::Kind::mesh) return out;
    const auto once = geometry::without_doubled(*in.mesh);
    const geometry::TriMesh& mesh = once ? once->mesh : *in.mesh;
    const std::size_t vertices = mesh.positions.size();
    geometry::WoundOut wound = geometry::wound_out(mesh);
    const bool turns = wound.turned > 0 && geometry::is_closed(wound.triangles, vertices);
    out.open = !turns && !geometry::is_closed(mesh.triangles(), vertices);
    out.faces_turned = turns ? wound.turned : 0;
    out.faces_doubled = once ? once->doubled : 0;
    if (!turns && !once) {
        out.tree = geometry::TriangleBvh(mesh);
        return out;
    }
    auto topology = std::make_shared<geometry::MeshTopology>();
    topology->triangles = mesh.triangles();
    if (turns) topology->triangles = std::move(wound.triangles);
    geometry::TriMesh mended;
    mended.topology = std::move(topology);
    mended.positions = mesh.positions;
    out.tree = geometry::TriangleBvh(mended);
    out.mended = std::make_shared<const geometry::TriMesh>(std::move(mended));
    return out;
}

constexpr const char* needs_mesh =
    "kind = mesh needs the input 'mesh': link a mesh that has triangles";

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    if (in.kind != Collider::Kind::mesh || setting.links("mesh")) return {};
    return {{"kind", needs_mesh}};
}

static void warn_of_turned(const Inputs& in, const graph::Context& context)
{
    if (in.obstacle->faces_turned == 0) return;
    context.warn(fmt::format(
        "{} of {} faces of the closed mesh look in: they are taken as if they looked out, and the "
        "mesh is solid. For a room with bodies in it, leave a face open, or give it walls",
        in.obstacle->faces_turned, in.mesh->triangles().size() - in.obstacle->faces_doubled));
}

// How far all of a mesh has gone, as far as its bounds tell: not at all if their size changes.
static Vec3 way_of_all(const geometry::TriMesh& before, const geometry::TriMesh& now)
{
    constexpr double alike = 1e-3;  // of the diagonal
    const geometry::Box from = geometry::bounds(before), to = geometry::bounds(now);
    const bool kept = (to.size() - from.size()).norm() <= alike * from.diagonal();
    return kept ? Vec3(to.centre() - from.centre()) : Vec3::Zero();
}

// Where the mesh was a frame ago. If it had other triangles then, it goes back as a whole, and each
// vertex from there to the nearest place of the last mesh: the surface does not jump.
static std::shared_ptr<const geometry::TriMesh> mesh_before(const geometry::TriMesh& mesh,
                                                            const Collider& last)
{
    if (!last.mesh || !last.tree || geometry::same_triangles(*last.mesh, mesh)) return last.mesh;
    auto out = std::make_shared<geometry::TriMesh>();
    out->topology = mesh.topology;
    out->positions = mesh.positions;
    const Vec3 way = way_of_all(*last.mesh, mesh);
    std::vector<Vec3> places;
    for (const auto& p : mesh.positions) places.push_back(p.cast<double>() - way);
    std::vector<geometry::TriangleBvh::Hit> hits(places.size());
    last.tree->closest(places, std::numeric_limits<double>::infinity(), hits);
    for (std::size_t v = 0; v < hits.size(); ++v) {
        if (hits[v]) out->positions[v] = hits[v].point.cast<float>();
    }
    return out;
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    Collider out;
    out.kind = in.kind;
    out.radius = in.sphere.radius;
    out.half_size = in.box.size / 2;
    out.friction = in.friction;
    out.bounce = in.bounce;
    out.thickness = in.thickness;
    if (in.kind == Collider::Kind::mesh) {
        const auto& obstacle = in.obstacle;
        if (!in.mesh || obstacle->tree.triangle_count() == 0) {
            throw std::invalid_argument(needs_mesh);
        }
        warn_of_doubled_faces(obstacle->faces_doubled, in.mesh->triangles().size(), context);
        warn_of_turned(in, context);
        out.mesh = in.mesh;
        if (obstacle->mended) out.mesh = obstacle->mended;
        out.tree = std::shared_ptr<const geometry::TriangleBvh>(obstacle, &obstacle->tree);
        out.features = obstacle->features;
        out.sheet = obstacle->open;
        if (in.last) out.mesh_before = mesh_before(*out.mesh, *in.last);
    } else {
        out.pose = geometry::placement(in.translate, in.rotate_degrees, Vec3::Ones(), Vec3::Zero());
    }
    out.began_as(in.last ? *in.last : out);
    return {out};
}

void add_to(graph::Registry& registry)
{
    registry.add("Collider", 1, run)
        .summary("A rigid or animated obstacle with friction.",
                 {"obstacle", "collision", "static", "rigid", "wall"})
        .input("mesh", &Inputs::mesh,
               "The obstacle for kind = mesh, where it is at this frame. To move it, animate the "
               "mesh before it is linked here. If its triangles change from frame to frame, a mesh "
               "that keeps its size is taken to move as a whole, and any other across its surface: "
               "it carries nothing along. keep_order of ReadMesh keeps the triangles of a file.",
               graph::Need::optional)
        .choice("kind", &Inputs::kind, {"plane", "sphere", "box", "mesh"},
                "Shape of the obstacle. plane: solid below its local y = 0. mesh: solid inside if "
                "it is closed, faces that look in are turned out; an open mesh is a sheet with two "
                "sides. Of a face and its back, or a copy of it, the first counts. What starts "
                "less than two "
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
        .prepare("obstacle", &Inputs::obstacle, make_obstacle, {"mesh", "kind"})
        .check(check)
        .output("collider", &Outputs::collider,
                "The obstacle at this frame and at the frame before.")
        .previous("collider", &Inputs::last, graph::Memory::of_motion);
}

}  // namespace nodes::collider
