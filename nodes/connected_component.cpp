#include "geometry/cubes/components.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

#include <cstdio>
#include <stdexcept>

namespace nodes::connected_component {

enum class Keep { all, largest, heaviest, point };

struct Inputs {
    graph::Wire<geometry::Cubes> cubes;
    Keep keep = Keep::largest;
    geometry::Connectivity connectivity = geometry::Connectivity::face;
    geometry::Vec3 point{0, 0, 0};
};
struct Outputs {
    geometry::Cubes cubes;
};

static std::string what_was_dropped(const geometry::Components& found, std::uint32_t kept)
{
    std::size_t cubes = 0;
    double mass = 0;
    for (std::size_t i = 0; i < found.count(); ++i) cubes += found.cubes[i], mass += found.mass[i];
    char text[200];
    std::snprintf(text, sizeof text,
                  "dropped %zu of %zu components: %zu of %zu cubes, %.3g of %.3g kg",
                  found.count() - 1, found.count(), cubes - found.cubes[kept], cubes,
                  mass - found.mass[kept], mass);
    return text;
}

// Whether cubes of another component stand for all of the same cell, so that any may hold the
// point.
static bool is_shared(const geometry::Cubes& cubes, const geometry::Components& found,
                      std::uint32_t nearest)
{
    if (cubes.part.empty()) return false;
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        if (cubes.cell[c] == cubes.cell[nearest] && found.label[c] != found.label[nearest] &&
            (cubes.part[c] & cubes.part[nearest]) != 0) {
            return true;
        }
    }
    return false;
}

// The component at the point.
static std::uint32_t component_at(const geometry::Cubes& cubes, const geometry::Components& found,
                                  const geometry::Vec3& point, const graph::Context& context)
{
    const geometry::NearestCube nearest = geometry::nearest_cube(cubes, point);
    if (nearest.distance > 0) {
        char text[120];
        std::snprintf(text, sizeof text,
                      "the point lies in no cube: the component of the nearest cube was kept, "
                      "%.3g m away",
                      nearest.distance);
        context.warn(text);
    }
    if (is_shared(cubes, found, nearest.cube)) {
        context.warn("cubes of several bodies lie at the point: the body with most material in its "
                     "cube there was kept; choose a point deeper inside the body");
    }
    return found.label[nearest.cube];
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    const geometry::Cubes& cubes = *in.cubes;
    if (cubes.count() == 0) {
        throw std::invalid_argument("the input 'cubes' is empty: expected at least one cube");
    }
    geometry::Components found = geometry::find_components(
        cubes, in.connectivity,
        in.keep == Keep::heaviest ? geometry::Largest::by_mass : geometry::Largest::by_count);
    if (in.keep == Keep::all) {
        Outputs out{cubes};
        out.cubes.component = std::move(found.label);
        return out;
    }
    std::uint32_t chosen = 0;
    if (in.keep == Keep::point) chosen = component_at(cubes, found, in.point, context);
    if (found.count() == 1) {
        Outputs out{cubes};
        out.cubes.component.assign(cubes.count(), 0);
        return out;
    }
    context.warn(what_was_dropped(found, chosen));
    std::vector<std::uint8_t> keep(cubes.count());
    for (std::size_t c = 0; c < keep.size(); ++c) keep[c] = found.label[c] == chosen;
    Outputs out{geometry::kept(cubes, keep)};
    out.cubes.component.assign(out.cubes.count(), 0);
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("ConnectedComponent", 1, run)
        .summary(
            "Finds the connected components of cubes, keeps one or all, and reports what it drops.",
            {"connectivity", "islands", "pieces", "largest piece"})
        .input("cubes", &Inputs::cubes, "The cubes to split into components.")
        .choice("keep", &Inputs::keep, {"all", "largest", "heaviest", "point"},
                "Which component to keep. all: every cube is kept, and components are only "
                "numbered. largest: the component with the most cubes. heaviest: the component "
                "with the most mass. point: the component at a given point.")
        .choice("connectivity", &Inputs::connectivity, {"face", "edge", "corner"},
                "What connects two cubes: a shared face (6 neighbours), a shared edge too (18), or "
                "a shared corner too (26).")
        .param("point", &Inputs::point,
               "A point in the rest shape. The component of the nearest cube is kept.",
               {.unit = "m"}, {"keep", {"point"}})
        .output("cubes", &Outputs::cubes,
                "The kept cubes, each with the number of its component; the largest is 0.");
}

}  // namespace nodes::connected_component
