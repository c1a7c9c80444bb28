#include "geometry/fields/field.hpp"
#include "geometry/fields/skeleton_mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "geometry/mesh/transform.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

#include <fmt/format.h>

#include <numbers>

namespace nodes::skeletons {

using geometry::BlendRule;
using geometry::Contribution;
using geometry::SkeletonKind;
using geometry::Vec3;

struct Place {
    Vec3 at{0, 0, 0};
};
struct Item {
    SkeletonKind kind = SkeletonKind::point;
    std::vector<Place> points;
    Vec3 position{0, 0, 0};
    Vec3 size{1, 1, 1};
    Vec3 rotate_degrees{0, 0, 0};
    Vec3 stretch{1, 1, 1};
    Vec3 stretch_degrees{0, 0, 0};
    Contribution contribution;
    int frame = 0;
    int part = -1;
};
struct Link {
    int a = 0, b = 0;
    double weight = 1;
};

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh;
    graph::Wire<geometry::Samples> points;
    graph::Wire<geometry::Polylines> lines;
    std::vector<Item> skeletons;
    Contribution each;
    enum class Faces { whole, triangles, edges } faces = Faces::whole;
    enum class LineKind { curve, polyline, segments } line_kind = LineKind::curve;
    BlendRule blend = BlendRule::sum;
    std::vector<Link> links;
};
struct Outputs {
    geometry::ImplicitLayer layer;
};

constexpr const char* needs_mesh =
    "a skeleton of kind = mesh or sheet needs the input 'mesh': link one";

constexpr std::size_t many = 5000;  // skeletons

static bool of_mesh(SkeletonKind kind)
{
    return kind == SkeletonKind::mesh || kind == SkeletonKind::sheet;
}

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    if (in.faces != Inputs::Faces::whole && !setting.links("mesh")) {
        return {{"faces", "faces become skeletons of the input 'mesh': link one, or set faces = "
                          "whole"}};
    }
    for (std::size_t i = 0; i < in.skeletons.size() && !setting.links("mesh"); ++i) {
        if (!of_mesh(in.skeletons[i].kind)) continue;
        return {{fmt::format("skeletons.{}.kind", i), needs_mesh}};
    }
    return {};
}

static geometry::Skeleton skeleton(const Item& item, const Inputs& in)
{
    geometry::Skeleton s;
    s.kind = item.kind;
    s.points.clear();
    for (const Place& place : item.points) s.points.push_back(place.at);
    if (item.kind == SkeletonKind::point && s.points.empty()) s.points = {item.position};
    s.half_size = item.size / 2;
    s.place = geometry::placement(item.position, item.rotate_degrees, Vec3::Ones(), Vec3::Zero());
    if (geometry::has_points(item.kind) && item.stretch != Vec3::Ones()) {
        const geometry::Mat3 axes =
            geometry::placement(Vec3::Zero(), item.stretch_degrees, Vec3::Ones(), Vec3::Zero())
                .linear();
        s.stretch = axes * item.stretch.asDiagonal() * axes.transpose();
    }
    if (of_mesh(item.kind)) {
        if (!in.mesh) {
            throw std::invalid_argument(needs_mesh);
        }
        s.mesh = std::make_shared<const geometry::SkeletonMesh>(*in.mesh);
    }
    return s;
}

static void warn_of_open_mesh(const Inputs& in, const graph::Context& context)
{
    for (std::size_t i = 0; i < in.skeletons.size(); ++i) {
        if (in.skeletons[i].kind != SkeletonKind::mesh || !in.mesh) continue;
        if (geometry::is_closed(in.mesh->triangles(), in.mesh->positions.size())) continue;
        context.warn(fmt::format(
            "skeleton {} (counted from 0) has kind = mesh, but its mesh is open: all that lies "
            "behind its triangles counts as inside. Set kind = sheet for a surface with two sides",
            i));
    }
}

// A skeleton for each line, or for each piece of it.
static std::vector<geometry::Skeleton> of_lines(const Inputs& in)
{
    std::vector<geometry::Skeleton> out;
    if (!in.lines) return out;
    for (const auto& line : in.lines->lines) {
        if (in.line_kind != Inputs::LineKind::segments) {
            const bool curved = in.line_kind == Inputs::LineKind::curve;
            out.push_back(
                {.kind = curved ? SkeletonKind::curve : SkeletonKind::polyline, .points = line});
            continue;
        }
        for (std::size_t i = 0; i + 1 < line.size(); ++i) {
            out.push_back({.kind = SkeletonKind::segment, .points = {line[i], line[i + 1]}});
        }
    }
    return out;
}

// A skeleton for each face of the mesh, or for each edge.
static std::vector<geometry::Skeleton> of_faces(const Inputs& in, const graph::Context& context)
{
    std::vector<geometry::Skeleton> out;
    if (!in.mesh || in.faces == Inputs::Faces::whole) return out;
    const auto at = [&](std::uint32_t v) { return Vec3(in.mesh->positions[v].cast<double>()); };
    if (in.faces == Inputs::Faces::triangles) {
        for (const geometry::Triangle& t : in.mesh->triangles()) {
            out.push_back(
                {.kind = SkeletonKind::triangle, .points = {at(t[0]), at(t[1]), at(t[2])}});
        }
    } else {
        const auto uses = geometry::edge_uses(in.mesh->triangles(), in.mesh->positions.size());
        for (std::size_t i = 0; i < uses.size(); ++i) {
            if (i > 0 && uses[i - 1].a == uses[i].a && uses[i - 1].b == uses[i].b) continue;
            out.push_back(
                {.kind = SkeletonKind::segment, .points = {at(uses[i].a), at(uses[i].b)}});
        }
    }
    if (out.size() > many) {
        context.warn(fmt::format("the mesh becomes {} skeletons: Layered takes minutes and "
                                 "gigabytes for so many. Link a coarser mesh",
                                 out.size()));
    }
    return out;
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    warn_of_open_mesh(in, context);
    geometry::ImplicitLayer layer;
    std::vector<std::uint32_t> parts;
    bool any_part = false;
    const auto add = [&](geometry::Skeleton s, const Contribution& c, int frame, int part) {
        any_part |= part >= 0;
        // A part of its own: numbered above all numbers that a document may use.
        parts.push_back(part >= 0 ? static_cast<std::uint32_t>(part)
                                  : 0x80000000u + static_cast<std::uint32_t>(parts.size()));
        layer.skeletons.push_back(std::move(s));
        layer.contributions.push_back(c);
        layer.frame.push_back(static_cast<std::uint32_t>(frame));
    };
    int next_frame = 0;
    for (const Item& item : in.skeletons) {
        add(skeleton(item, in), item.contribution, item.frame, item.part);
        next_frame = std::max(next_frame, item.frame + 1);
    }
    if (in.points) {
        if (const std::size_t count = in.points->positions.size(); count > many) {
            context.warn(fmt::format(
                "{} points become as many skeletons: Layered takes minutes and gigabytes for so "
                "many. Set count = 1000 in Sample, or a spacing of about the thickness",
                count));
        }
        for (const geometry::Vec3f& p : in.points->positions) {
            add({.kind = SkeletonKind::point, .points = {p.cast<double>()}}, in.each, next_frame++,
                0);
        }
    }
    for (geometry::Skeleton& s : of_lines(in)) add(std::move(s), in.each, next_frame++, 0);
    for (geometry::Skeleton& s : of_faces(in, context)) {
        add(std::move(s), in.each, next_frame++, 0);
    }
    if (layer.skeletons.empty()) {
        context.warn(
            "there are no skeletons, so the layer is empty: list some under `skeletons`, "
            "link the input 'points' or 'lines', or a mesh with faces = edges or triangles");
    }
    layer.blend.rule = in.blend;
    if (any_part) layer.blend.part = std::move(parts);
    for (const Link& link : in.links) {
        layer.blend.links.push_back(
            {static_cast<std::uint32_t>(link.a), static_cast<std::uint32_t>(link.b), link.weight});
    }
    const std::vector<geometry::Transform> frames(static_cast<std::size_t>(std::max(1, next_frame)),
                                                  geometry::Transform::Identity());
    geometry::make_field(layer, frames);  // says what is wrong here, not three nodes further
    return {std::move(layer)};
}

static void describe_contribution(graph::ParamsOf<Contribution>& p)
{
    p.param("thickness", &Contribution::thickness,
            "Distance of the surface from the skeleton where it is alone.",
            {.min = 1e-9, .unit = "m"})
        .param("stiffness", &Contribution::stiffness,
               "Slope of the field at the surface: the increase of the field per metre of "
               "compression. stiffness * (radius - thickness) is at most 3, so that the field "
               "falls everywhere.",
               {.min = 1e-9, .unit = "1/m"})
        .param("radius", &Contribution::radius,
               "Radius of influence. Skeletons within each other's radius blend.",
               {.min = 1e-9, .unit = "m"})
        .param("stiffening", &Contribution::stiffening,
               "Nonlinearity of the stiffness: 0 is linear elasticity; 1 doubles the stiffness at "
               "full compression.",
               {.min = 0});
}

static void describe_place(graph::ParamsOf<Place>& p)
{
    p.param("at", &Place::at, "Position of the point.", {.unit = "m"});
}

static void describe_item(graph::ParamsOf<Item>& p)
{
    p.choice("kind", &Item::kind,
             {"point", "segment", "polyline", "triangle", "box", "ellipsoid", "plane", "mesh",
              "curve", "torus", "cylinder", "cone", "sheet"},
             "Shape of the skeleton, from which distances are measured. A plane is solid below its "
             "local y = 0. A mesh is closed and solid; a sheet is a mesh, open or closed, that has "
             "two sides and no inside. A curve passes through its points without corners. Torus, "
             "cylinder and cone stand along their local y.")
        .list("points", &Item::points, describe_place,
              "Points of the skeleton: 1 for a point, 2 for a segment, 3 for a triangle, 2 or more "
              "for a polyline or a curve. A curve whose last point is its first is closed.",
              {"kind", {"point", "segment", "polyline", "triangle", "curve"}})
        .param("position", &Item::position,
               "Position of the origin of a solid or sheet, or of a point skeleton that has no "
               "`points`.",
               {.unit = "m"})
        .param(
            "size", &Item::size,
            "Edge lengths of a box, or axes of an ellipsoid from end to end. Torus: outer width, "
            "and thickness along y (0: a circle). Cylinder: width and height. Cone: width of "
            "its base, height, width of its top (0: pointed).",
            {.min = 0, .unit = "m"}, {"kind", {"box", "ellipsoid", "torus", "cylinder", "cone"}})
        .param(
            "rotate_degrees", &Item::rotate_degrees,
            "Rotation of a solid or sheet about x, then y, then z, each axis fixed in space.",
            {.unit = "deg"},
            {"kind", {"box", "ellipsoid", "plane", "mesh", "torus", "cylinder", "cone", "sheet"}})
        .param("stretch", &Item::stretch,
               "How many times as thick the layer is along x, y and z: an anisotropic field. A "
               "point becomes an ellipsoid, a segment a blade. Radius and bulges stretch with it, "
               "and its slope falls. Where it is keyed, the surface moves but pushes nothing "
               "by its speed.",
               {.min = 1, .max = 100},
               {"kind", {"point", "segment", "polyline", "triangle", "curve"}})
        .param("stretch_degrees", &Item::stretch_degrees,
               "Rotation of the axes of `stretch` about x, then y, then z, each axis fixed in "
               "space. Stretch turns with the frame of the skeleton.",
               {.unit = "deg"}, {"kind", {"point", "segment", "polyline", "triangle", "curve"}})
        .block("contribution", &Item::contribution, describe_contribution,
               "How its field falls with distance.")
        .param("frame", &Item::frame,
               "Index of the base structure's frame that carries it. Skeletons with the same index "
               "move together.",
               {.min = 0, .max = 1e6})
        .param("part", &Item::part,
               "Part that it belongs to. Skeletons of one part always blend with each other; -1: a "
               "part of its own.",
               {.min = -1, .max = 1e6});
}

void add_to(graph::Registry& registry)
{
    registry.add("Skeletons", 1, run)
        .summary("Describes an implicit layer: the skeletons that carry its field, and which of "
                 "them blend.",
                 {"metaball", "implicit", "field"})
        .input("mesh", &Inputs::mesh,
               "A mesh, for skeletons of kind = mesh (closed) or sheet (any), or whose faces or "
               "edges become skeletons by `faces`.",
               graph::Need::optional)
        .input("points", &Inputs::points,
               "Points. Each becomes a point skeleton on a frame of its own, all of one part.",
               graph::Need::optional)
        .input("lines", &Inputs::lines,
               "Lines, from ReadMesh. Each becomes a skeleton on a frame of its own, all of one "
               "part; a line that ends where it begins is a closed one.",
               graph::Need::optional)
        .list("skeletons", &Inputs::skeletons, describe_item, "The skeletons.")
        .block(
            "each", &Inputs::each, describe_contribution,
            "Contribution of each skeleton that is made from the inputs `points` and `lines`, or "
            "by `faces`.")
        .choice("faces", &Inputs::faces, {"whole", "triangles", "edges"},
                "What the faces of the mesh become. whole: no skeletons of their own. triangles, "
                "edges: each triangle, or each edge of one (diagonals of quads too), a "
                "skeleton on a frame of its own, all of one part; the skin of a net, for example "
                "(ImplicitLayer, base = net).")
        .choice("line_kind", &Inputs::line_kind, {"curve", "polyline", "segments"},
                "What lines become. curve: smooth through their points. polyline: straight between "
                "them. segments: each piece a segment of its own.")
        .choice("blend", &Inputs::blend, {"sum", "largest_group", "smooth_groups", "gradient"},
                "Which skeletons blend, and how. sum: all of them. largest_group: only those of "
                "one part or linked by `links`, with creases. smooth_groups: the same without "
                "creases. gradient: like smooth_groups, but joints do not swell and nothing blends "
                "at a distance.")
        .list<Link>("links", &Inputs::links,
                    [](graph::ParamsOf<Link>& p) {
                        p.param("a", &Link::a, "Index of one skeleton in the list, counted from 0.",
                                {.min = 0})
                            .param("b", &Link::b,
                                   "Index of the other skeleton, which is of another part.",
                                   {.min = 0})
                            .param("weight", &Link::weight,
                                   "Weight of the blend: 0 collides, 1 blends fully.",
                                   {.min = 0, .max = 1});
                    },
                    "Pairs of skeletons of different parts that blend.",
                    {"blend", {"largest_group", "smooth_groups", "gradient"}})
        .check(check)
        .output("layer", &Outputs::layer, "The layer, as drawn.");
}

}  // namespace nodes::skeletons
