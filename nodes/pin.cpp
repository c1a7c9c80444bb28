#include "geometry/mesh/transform.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/state/hold_matter.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace nodes::pin {

using geometry::Vec3;

enum class Hold { corners, points };
enum class Where { box, sphere, below, material, ends, rim };
enum class Axis { x, y, z };
enum class Axes { xyz, x, y, z, xy, yz, xz };

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
    int on = 1;  // a number, as these alone take keyframes and expressions
    Hold hold = Hold::corners;
    Where where = Where::box;
    BoxPlace box;
    SpherePlace sphere;
    BelowPlace below;
    MaterialPlace material;
    EndsPlace ends;
    Axes axes = Axes::xyz;
    Vec3 translate{0, 0, 0};
    Vec3 rotate_degrees{0, 0, 0};
    Vec3 pivot{0, 0, 0};
    std::shared_ptr<const physics::HeldMatter> matter;
};
struct Outputs {
    physics::Pins pins;
};

constexpr const char* needs_mesh =
    "where = material needs the input 'mesh': link the mesh whose faces have the material";

constexpr const char* points_of_rim =
    "where = rim chooses corners, and hold = points needs a place: set hold = corners, or another "
    "where";

constexpr const char* points_of_plane =
    "layers = 0 chooses a plane of corners, and hold = points needs a place: set layers = 1 or "
    "more, or hold = corners";

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    if (in.where == Where::material && !setting.links("mesh")) return {{"where", needs_mesh}};
    if (in.hold == Hold::corners) return {};
    if (in.where == Where::rim) return {{"where", points_of_rim}};
    if (in.where == Where::ends && in.ends.layers == 0) return {{"ends", points_of_plane}};
    return {};
}

static geometry::Box box_of(const Inputs& in)
{
    return {in.box.centre - in.box.size / 2, in.box.centre + in.box.size / 2};
}

static double distance_of_material(const Inputs& in)
{
    return in.material.distance > 0 ? in.material.distance : in.cubes->size;
}

static std::vector<std::uint32_t> chosen(const Inputs& in)
{
    const geometry::Cubes& cubes = *in.cubes;
    switch (in.where) {
    case Where::box:
        return physics::corners_in_box(cubes, box_of(in));
    case Where::sphere:
        return physics::corners_in_sphere(cubes, in.sphere.centre, in.sphere.radius);
    case Where::below:
        return physics::corners_below(cubes, in.below.height);
    case Where::material:
        if (!in.mesh) throw std::invalid_argument(needs_mesh);
        return physics::corners_near_material(cubes, *in.mesh, in.material.name,
                                              distance_of_material(in));
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
    throw std::invalid_argument(fmt::format(
        "`follow` has {} vertices, expected {}, one per corner of the cubes: link the "
        "mesh that Plane or Sheet made with these cubes, carried along, or that of CubeMesh, which "
        "has a vertex for each corner also where Sheet cut faces (`longest_side`) or joined "
        "vertices. If what carries it tears, set torn = hide or stretch in its Embed, because "
        "cutting adds vertices",
        found, corners));
}

// Bits 1, 2, 4 for x, y, z.
static std::uint8_t bits_of(Axes axes)
{
    switch (axes) {
    case Axes::xyz:
        break;
    case Axes::x:
        return 1;
    case Axes::y:
        return 2;
    case Axes::z:
        return 4;
    case Axes::xy:
        return 3;
    case Axes::yz:
        return 6;
    case Axes::xz:
        return 5;
    }
    return physics::all_axes;
}

static physics::Outside outside(const Inputs& in)
{
    switch (in.where) {
    case Where::box:
        return physics::outside_box(box_of(in));
    case Where::sphere:
        return physics::outside_sphere(in.sphere.centre, in.sphere.radius);
    case Where::below:
        return physics::outside_below(in.below.height);
    case Where::material:
        if (!in.mesh) throw std::invalid_argument(needs_mesh);
        return physics::outside_of_material(*in.mesh, in.material.name, distance_of_material(in));
    case Where::ends:
        return physics::outside_end(*in.cubes, static_cast<int>(in.ends.axis), in.ends.end,
                                    in.ends.layers);
    case Where::rim:
        break;
    }
    throw std::invalid_argument(points_of_rim);
}

// Set-up: where the material lies changes with none of the motion.
static physics::HeldMatter find_matter(const Inputs& in)
{
    if (in.hold == Hold::corners) return {};
    const geometry::TriangleBvh tree =
        in.mesh ? geometry::TriangleBvh(*in.mesh) : geometry::TriangleBvh();
    return physics::matter_within(*in.cubes, outside(in), in.mesh ? &tree : nullptr,
                                  bits_of(in.axes));
}

// What is carried whole is so on purpose. Keyframes that stand still at this frame, and what is let
// go at another, carry it too.
static void warn_of_all(const Inputs& in, std::size_t pinned, const graph::Context& context)
{
    const bool still = in.axes == Axes::xyz && !in.follow && !context.animated() &&
                       in.translate.isZero(0) && in.rotate_degrees.isZero(0);
    if (!still || pinned == 0 || pinned < in.cubes->corner_count()) return;
    context.warn(fmt::format("all {} corners of the cubes lie in the chosen region, so this body "
                             "cannot move. Where it is not meant as an anchor, choose a smaller "
                             "region",
                             pinned));
}

static geometry::Transform motion_of(const Inputs& in)
{
    return geometry::placement(in.translate, in.rotate_degrees, Vec3::Ones(), in.pivot);
}

static void warn_of_unused_motion(const Inputs& in, const graph::Context& context)
{
    std::string unused;
    for (const auto& [name, value] :
         {std::pair("translate", &in.translate), std::pair("rotate_degrees", &in.rotate_degrees),
          std::pair("pivot", &in.pivot)}) {
        if (!value->isZero(0)) unused += (unused.empty() ? "" : ", ") + std::string(name);
    }
    if (unused.empty()) return;
    context.warn(fmt::format("no effect of {}, because what is pinned follows the mesh that is "
                             "linked to `follow`: move that mesh, or unlink it",
                             unused));
}

static void warn_of_free_axes(const Inputs& in, const graph::Context& context)
{
    std::string lost;
    for (int a = 0; a < 3; ++a) {
        if ((bits_of(in.axes) >> a & 1) != 0 || in.translate[a] == 0) continue;
        lost += (lost.empty() ? "" : ", ") + std::string(1, "xyz"[a]);
    }
    if (lost.empty()) return;
    context.warn(fmt::format("no effect of translate along {}, because `axes` leaves that free: "
                             "add it to axes, or leave it out of translate",
                             lost));
}

// Where the nearest corner is; of a rim there always are some.
static std::string nearest_corner(const Inputs& in)
{
    if (in.where == Where::rim || in.cubes->corner_count() == 0) return {};
    const physics::Outside distance = outside(in);
    Vec3 nearest = Vec3::Zero();
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t k = 0; k < in.cubes->corner_count(); ++k) {
        const Vec3 at = in.cubes->corner_position(k);
        const double d = distance(at);
        if (d < least) least = d, nearest = at;
    }
    if (!std::isfinite(least)) return {};
    return fmt::format(". The nearest one, at ({:.4g}, {:.4g}, {:.4g}), is {:.3g} m outside, and "
                       "corners are {:.3g} m apart: choose a larger region, or set hold = points",
                       nearest.x(), nearest.y(), nearest.z(), least, in.cubes->size);
}

static Outputs let_go(const Inputs& in)
{
    if (in.hold == Hold::points) return {physics::matter_at(*in.cubes, {}, motion_of(in))};
    return {physics::pins_at(*in.cubes, {}, motion_of(in))};
}

static Outputs hold_points(const Inputs& in, const graph::Context& context)
{
    if (in.matter->cubes.empty())
        context.warn("no material of the cubes lies in the chosen region: nothing is pinned");
    return {in.follow ? physics::matter_on(*in.cubes, *in.matter, in.follow->positions)
                      : physics::matter_at(*in.cubes, *in.matter, motion_of(in), in.pivot)};
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (in.follow) {
        require_a_vertex_a_corner(in);
        warn_of_unused_motion(in, context);
    } else {
        warn_of_free_axes(in, context);
    }
    if (in.on == 0) return let_go(in);
    if (in.hold == Hold::points) return hold_points(in, context);
    auto corners = chosen(in);
    if (corners.empty())
        context.warn("no corner of the cubes lies in the chosen region: nothing is pinned" +
                     nearest_corner(in));
    warn_of_all(in, corners.size(), context);
    Outputs out{in.follow
                    ? physics::pins_on(*in.cubes, std::move(corners), in.follow->positions)
                    : physics::pins_at(*in.cubes, std::move(corners), motion_of(in), in.pivot)};
    if (in.axes != Axes::xyz) out.pins.axes.assign(out.pins.corner.size(), bits_of(in.axes));
    return out;
}

static graph::ShownWhen when(const char* place)
{
    return {"where", {place}};
}

static void describe(graph::ParamsOf<BoxPlace>& p)
{
    p.param("centre", &BoxPlace::centre, "Centre of the box.", {.unit = "m"})
        .param("size", &BoxPlace::size, "Edge lengths along x, y and z.", {.min = 0, .unit = "m"});
}

static void describe(graph::ParamsOf<SpherePlace>& p)
{
    p.param("centre", &SpherePlace::centre, "Centre of the sphere.", {.unit = "m"})
        .param("radius", &SpherePlace::radius, "Radius of the sphere.", {.min = 0, .unit = "m"});
}

static void describe(graph::ParamsOf<BelowPlace>& p)
{
    p.param("height", &BelowPlace::height, "Largest y of what is pinned.", {.unit = "m"});
}

static void describe(graph::ParamsOf<MaterialPlace>& p)
{
    p.param("name", &MaterialPlace::name, "Name of the material or group.")
        .param("distance", &MaterialPlace::distance,
               "Largest distance from what is pinned to its faces; 0: the edge of a cube.",
               {.min = 0, .unit = "m"});
}

static void describe(graph::ParamsOf<EndsPlace>& p)
{
    p.choice("axis", &EndsPlace::axis, {"x", "y", "z"},
             "Axis along which corners are farthest out.")
        .choice("end", &EndsPlace::end, {"both", "low", "high"}, "End of the axis to pin.")
        .param("layers", &EndsPlace::layers,
               "Number of layers of cubes to pin; 0: only the outermost plane of corners.",
               {.min = 0, .max = 1'000'000});
}

static void describe_motion(graph::NodeBuilder<Inputs, Outputs>& node)
{
    node.param("translate", &Inputs::translate,
               "Translation from rest of what is pinned; keyframe it to move that.", {.unit = "m"})
        .param("rotate_degrees", &Inputs::rotate_degrees,
               "Rotation of what is pinned about the pivot: about x, then y, then z, each axis "
               "fixed in space.",
               {.unit = "deg"})
        .param("pivot", &Inputs::pivot,
               "Centre of the rotation, at rest. Within a frame, what is pinned goes along arcs "
               "about it.",
               {.unit = "m"})
        .param("on", &Inputs::on,
               "1 holds what is chosen, 0 lets it go. A frame number in an expression releases a "
               "body (=frame < 24), as keyframes with interpolation = step do. What is held anew "
               "jumps to its targets. For Simulate: Vibrate refuses modes that change over "
               "frames.",
               {.min = 0, .max = 1});
}

void add_to(graph::Registry& registry)
{
    auto node = registry.add("Pin", 1, run);
    node.summary("Holds a part of the cubes in place, or moves it along a keyframed path.",
                 {"constraint", "anchor", "attach", "fix", "hold", "hinge", "joint"})
        .input("cubes", &Inputs::cubes, "The cubes at rest that are pinned.")
        .input("mesh", &Inputs::mesh,
               "The mesh at rest, for where = material. With hold = points, the material is what "
               "is inside of it; without, what a cube holds is taken as spread evenly.",
               graph::Need::optional)
        .input("follow", &Inputs::follow,
               "Pinned corners follow the vertices of this mesh at this frame. It is the mesh that "
               "Plane or Sheet made with these cubes, carried along by something else. Where Sheet "
               "cut faces (`longest_side`) or joined vertices, and for cubes of Voxelize, take the "
               "mesh of CubeMesh: through a Transform, it scales what is pinned, too.",
               graph::Need::optional)
        .choice(
            "hold", &Inputs::hold, {"corners", "points"},
            "What is held in the chosen region. corners: the corners of the cubes, exactly; a "
            "clamp ends at a plane of corners, up to a cube from where the region does. "
            "points: the material, by springs from its points, wherever cubes lie; it gives "
            "way by about what the cubes strain within a third of a cube. Take points where "
            "cubes are coarse against what is clamped, or tilted to it. A rigid body (`rigid` of "
            "Simulate) turns about one line of corners as about a hinge, and about one corner "
            "as about a ball joint. Corners off one line clamp it, and points always do, "
            "however small their region. What is held inside a "
            "collider takes corners: contact pushes points out. Of Simulate, for methods "
            "bricks and springs, and for Modes.")
        .choice("where", &Inputs::where, {"box", "sphere", "below", "material", "ends", "rim"},
                "How the corners or points are chosen. box, sphere: all inside it. below: all up "
                "to a height. material: all near the faces of a material or group. ends: all at "
                "the ends of the model along an axis. rim: all corners on the outside of the "
                "model; for a plane or a sheet, its border and those of its holes.")
        .block<BoxPlace>("box", &Inputs::box, describe, "Pins what is inside a box.", when("box"))
        .block<SpherePlace>("sphere", &Inputs::sphere, describe, "Pins what is inside a sphere.",
                            when("sphere"))
        .block<BelowPlace>("below", &Inputs::below, describe, "Pins what is up to a height.",
                           when("below"))
        .block<MaterialPlace>("material", &Inputs::material, describe,
                              "Pins what is near the faces of a material or group.",
                              when("material"))
        .block<EndsPlace>("ends", &Inputs::ends, describe,
                          "Pins what is farthest out along an axis.", when("ends"))
        .choice("axes", &Inputs::axes, {"xyz", "x", "y", "z", "xy", "yz", "xz"},
                "Axes of the world along which it is held; along the others they are free. "
                "One axis makes a roller, or a plane of symmetry; x, for example, holds a plane "
                "across x, in which corners slide. Several pins of a corner add up. Methods "
                "bricks and springs alone take fewer axes than xyz.");
    describe_motion(node);
    node.prepare("matter", &Inputs::matter, find_matter,
                 {"cubes", "mesh", "hold", "where", "box", "sphere", "below", "material", "ends",
                  "axes"})
        .check(check)
        .output("pins", &Outputs::pins, "What is pinned, and its targets at this frame.");
}

}  // namespace nodes::pin
