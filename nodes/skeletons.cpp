#include "geometry/field.hpp"
#include "geometry/transform.hpp"
#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

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
    std::vector<Item> skeletons;
    Contribution each;
    BlendRule blend = BlendRule::sum;
    std::vector<Link> links;
};
struct Outputs {
    geometry::ImplicitLayer layer;
};

static geometry::Skeleton skeleton(const Item& item, const Inputs& in)
{
    geometry::Skeleton s;
    s.kind = item.kind;
    s.points.clear();
    for (const Place& place : item.points) s.points.push_back(place.at);
    if (item.kind == SkeletonKind::point && s.points.empty()) s.points = {item.position};
    s.half_size = item.size / 2;
    s.place = geometry::placement(item.position, item.rotate_degrees, Vec3::Ones(), Vec3::Zero());
    if (item.kind == SkeletonKind::mesh) {
        if (!in.mesh) {
            throw std::invalid_argument(
                "a skeleton of kind = mesh needs triangles: link a closed mesh to the input "
                "`mesh`");
        }
        s.mesh = std::make_shared<const geometry::SkeletonMesh>(*in.mesh);
    }
    return s;
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    geometry::ImplicitLayer layer;
    std::vector<std::uint32_t> parts;
    bool any_part = false;
    const auto add = [&](geometry::Skeleton s, const Contribution& c, int frame, int part) {
        any_part |= part >= 0;
        // Its own part: numbered beyond all that may be named.
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
        for (const geometry::Vec3f& p : in.points->positions) {
            add({.kind = SkeletonKind::point, .points = {p.cast<double>()}}, in.each, next_frame++,
                0);
        }
    }
    if (layer.skeletons.empty()) {
        context.warn("there are no skeletons, so there is nothing to see or to touch: list some "
                     "under skeletons, or link points");
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
            "Distance of the surface that this skeleton has alone.", {.min = 1e-9, .unit = "m"})
        .param("stiffness", &Contribution::stiffness,
               "Slope of the field at the surface: how much harder it presses a metre deeper. "
               "stiffness * (radius - thickness) is 3 at most, so that the field falls all the "
               "way.",
               {.min = 1e-9, .unit = "1/m"})
        .param("radius", &Contribution::radius,
               "From here on the skeleton has no influence; skeletons within each other's blend.",
               {.min = 1e-9, .unit = "m"})
        .param("stiffening", &Contribution::stiffening,
               "0 is linear elasticity; 1 doubles the stiffness at full compression.", {.min = 0});
}

static void describe_place(graph::ParamsOf<Place>& p)
{
    p.param("at", &Place::at, "Where the point is.", {.unit = "m"});
}

static void describe_item(graph::ParamsOf<Item>& p)
{
    p.choice("kind", &Item::kind,
             {"point", "segment", "polyline", "triangle", "box", "ellipsoid", "plane", "mesh"},
             "What the distance is measured from. A plane is solid below its local y = 0.")
        .list("points", &Item::points, describe_place,
              "The points: 1 for a point, 2 for a segment, 3 for a triangle, 2 or more for a "
              "polyline.",
              {"kind", {"point", "segment", "polyline", "triangle"}})
        .param("position", &Item::position,
               "Where a solid's own origin is; of a point, when it has no `points`.", {.unit = "m"})
        .param("size", &Item::size, "A box's edges or an ellipsoid's axes, end to end.",
               {.min = 0, .unit = "m"}, {"kind", {"box", "ellipsoid"}})
        .param("rotate_degrees", &Item::rotate_degrees,
               "A solid's turn about x, then y, then z, each fixed in space.", {.unit = "deg"},
               {"kind", {"box", "ellipsoid", "plane", "mesh"}})
        .block("contribution", &Item::contribution, describe_contribution,
               "How its field falls with distance.")
        .param("frame", &Item::frame,
               "Which frame of the base structure it rides on: skeletons with the same number "
               "move together.",
               {.min = 0, .max = 1e6})
        .param("part", &Item::part,
               "Skeletons of one part always blend with each other; -1 is a part of its own.",
               {.min = -1, .max = 1e6});
}

void add_to(graph::Registry& registry)
{
    registry.add("Skeletons", 1, run)
        .summary("Describes an implicit layer: the skeletons that carry its field, and who blends "
                 "with whom.")
        .input("mesh", &Inputs::mesh, "For skeletons of kind = mesh: a closed mesh.",
               graph::Need::optional)
        .input("points", &Inputs::points,
               "Each of these becomes a point skeleton on a frame of its own, all of one part.",
               graph::Need::optional)
        .list("skeletons", &Inputs::skeletons, describe_item, "The skeletons, one by one.")
        .block("each", &Inputs::each, describe_contribution,
               "The contribution of each skeleton that comes from the input `points`.")
        .choice("blend", &Inputs::blend, {"sum", "largest_group", "smooth_groups", "gradient"},
                "sum blends all. largest_group blends only skeletons of one part or linked below, "
                "with creases; smooth_groups does so without. gradient is smooth_groups that "
                "neither swells joints nor blends at a distance.")
        .list<Link>("links", &Inputs::links,
                    [](graph::ParamsOf<Link>& p) {
                        p.param("a", &Link::a, "One skeleton, by its place in the list from 0.",
                                {.min = 0})
                            .param("b", &Link::b, "The other, of another part.", {.min = 0})
                            .param("weight", &Link::weight, "0 collides, 1 blends fully.",
                                   {.min = 0, .max = 1});
                    },
                    "Pairs of skeletons of different parts that blend.",
                    {"blend", {"largest_group", "smooth_groups", "gradient"}})
        .output("layer", &Outputs::layer, "The layer, as drawn in the world.");
}

}  // namespace nodes::skeletons
