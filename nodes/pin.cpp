#include "geometry/transform.hpp"
#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"
#include "physics/choose_corners.hpp"

namespace nodes::pin {

using geometry::Vec3;

enum class Where { box, sphere, below, material, ends, rim };
enum class Axis { x, y, z };

struct BoxPlace {
    Vec3 centre{0, 0, 0};
    Vec3 size{1, 1, 1};
};
struct SpherePlace {
    Vec3 centre{0, 0, 0};
    double radius = 0.1;
};
struct BelowPlace {
    double height = 0;
};
struct MaterialPlace {
    std::string name;
    double distance = 0;
};
struct EndsPlace {
    Axis axis = Axis::x;
    physics::End end = physics::End::both;
    int layers = 1;
};

struct Inputs {
    graph::Wire<geometry::Cubes> cubes;
    graph::Wire<geometry::TriMesh> mesh;
    graph::Wire<geometry::TriMesh> follow;
    Where where = Where::box;
    BoxPlace box;
    SpherePlace sphere;
    BelowPlace below;
    MaterialPlace material;
    EndsPlace ends;
    Vec3 translate{0, 0, 0};
    Vec3 rotate_degrees{0, 0, 0};
    Vec3 pivot{0, 0, 0};
};
struct Outputs {
    physics::Pins pins;
};

static std::vector<std::uint32_t> chosen(const Inputs& in)
{
    const geometry::Cubes& cubes = *in.cubes;
    switch (in.where) {
    case Where::box:
        return physics::corners_in_box(
            cubes, {in.box.centre - in.box.size / 2, in.box.centre + in.box.size / 2});
    case Where::sphere:
        return physics::corners_in_sphere(cubes, in.sphere.centre, in.sphere.radius);
    case Where::below:
        return physics::corners_below(cubes, in.below.height);
    case Where::material:
        if (!in.mesh) {
            throw std::invalid_argument(
                "where = material needs the mesh whose faces carry it: link the input 'mesh'");
        }
        return physics::corners_near_material(cubes, *in.mesh, in.material.name,
                                              in.material.distance > 0 ? in.material.distance
                                                                       : cubes.size);
    case Where::ends:
        return physics::corners_at_end(cubes, static_cast<int>(in.ends.axis), in.ends.end,
                                       in.ends.layers);
    case Where::rim:
        return physics::corners_at_rim(cubes);
    }
    return {};
}

static void require_a_vertex_a_corner(const Inputs& in)
{
    const std::size_t corners = in.cubes->corner_count(), found = in.follow->positions.size();
    if (found == corners) return;
    throw std::invalid_argument(
        "expected `follow` to have " + std::to_string(corners) +
        " vertices, one for each corner of the cubes, found " + std::to_string(found) +
        ": link the mesh that Plane made with these cubes, carried along; if what carries it is "
        "torn, let its Embed hide or stretch that (torn: hide), as cutting it adds vertices");
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (in.follow) require_a_vertex_a_corner(in);
    auto corners = chosen(in);
    if (corners.empty()) context.warn("no corner of the cubes lies there: nothing is pinned");
    if (in.follow) return {physics::pins_on(*in.cubes, std::move(corners), in.follow->positions)};
    return {physics::pins_at(
        *in.cubes, std::move(corners),
        geometry::placement(in.translate, in.rotate_degrees, Vec3::Ones(), in.pivot))};
}

static graph::ShownWhen when(const char* place)
{
    return {"where", {place}};
}

void add_to(graph::Registry& registry)
{
    registry.add("Pin", 1, run)
        .summary("Holds corners of the cubes, or moves them along a keyframed path.")
        .input("cubes", &Inputs::cubes, "The cubes whose corners are chosen, at rest.")
        .input("mesh", &Inputs::mesh, "The mesh at rest, for where = material.",
               graph::Need::optional)
        .input("follow", &Inputs::follow,
               "Pinned corners go where this mesh's vertices are at this frame: the mesh that "
               "Plane made with these cubes, carried along by something else.",
               graph::Need::optional)
        .choice("where", &Inputs::where, {"box", "sphere", "below", "material", "ends", "rim"},
                "How the corners are chosen: inside a box or a sphere, below a height, near the "
                "faces of a material or group, at the ends of the model, or on all its outside, "
                "which is the border of a plane and of its holes.")
        .block<BoxPlace>(
            "box", &Inputs::box,
            [](graph::ParamsOf<BoxPlace>& p) {
                p.param("centre", &BoxPlace::centre, "The middle of the box.", {.unit = "m"})
                    .param("size", &BoxPlace::size, "Its edges along x, y and z.",
                           {.min = 0, .unit = "m"});
            },
            "Corners inside this box are pinned.", when("box"))
        .block<SpherePlace>(
            "sphere", &Inputs::sphere,
            [](graph::ParamsOf<SpherePlace>& p) {
                p.param("centre", &SpherePlace::centre, "The middle of the sphere.", {.unit = "m"})
                    .param("radius", &SpherePlace::radius, "Its radius.", {.min = 0, .unit = "m"});
            },
            "Corners inside this sphere are pinned.", when("sphere"))
        .block<BelowPlace>(
            "below", &Inputs::below,
            [](graph::ParamsOf<BelowPlace>& p) {
                p.param("height", &BelowPlace::height, "The y up to which corners are taken.",
                        {.unit = "m"});
            },
            "Corners not above this height are pinned.", when("below"))
        .block<MaterialPlace>(
            "material", &Inputs::material,
            [](graph::ParamsOf<MaterialPlace>& p) {
                p.param("name", &MaterialPlace::name, "The name of the material or group.")
                    .param("distance", &MaterialPlace::distance,
                           "How near to its faces corners are taken; 0 means one cube's edge.",
                           {.min = 0, .unit = "m"});
            },
            "Corners near the faces of this material or group are pinned.", when("material"))
        .block<EndsPlace>(
            "ends", &Inputs::ends,
            [](graph::ParamsOf<EndsPlace>& p) {
                p.choice("axis", &EndsPlace::axis, {"x", "y", "z"}, "Along which axis.")
                    .choice("end", &EndsPlace::end, {"both", "low", "high"}, "At which end of it.")
                    .param("layers", &EndsPlace::layers,
                           "How many layers of cubes; 0 pins the outermost plane of corners only.",
                           {.min = 0, .max = 1'000'000});
            },
            "The corners farthest out along an axis are pinned.", when("ends"))
        .param("translate", &Inputs::translate,
               "Where the pinned corners have gone from their rest positions; keyframe it.",
               {.unit = "m"})
        .param("rotate_degrees", &Inputs::rotate_degrees,
               "How far they have turned about the pivot: about x, then y, then z, each fixed in "
               "space.",
               {.unit = "deg"})
        .param("pivot", &Inputs::pivot, "The point that turning leaves in place.", {.unit = "m"})
        .output("pins", &Outputs::pins, "The corners and where they are at this frame.");
}

}  // namespace nodes::pin
