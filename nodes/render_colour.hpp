#pragma once

// What colours the things that Render draws: the parameters, the scale of an attribute, and which
// of several meshes have it.

#include "geometry/mesh/mesh.hpp"
#include "graph/types/param_builder.hpp"
#include "graph/types/value.hpp"
#include "render/checker.hpp"
#include "render/legend.hpp"
#include "render/mesh_surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace nodes::render {

struct ColourParams {
    ::render::Paint::By by = ::render::Paint::By::material;
    geometry::Vec3f constant{0.6f, 0.6f, 0.6f};
    std::string attribute = "displacement";
    ::render::ColourMap map = ::render::ColourMap::viridis;
    enum class Range { fit, fixed, percentile } range = Range::fit;
    double low = 0, high = 1, clip = 0.02;
    double squares = 8, square = 0;
};

inline void describe(graph::ParamsOf<ColourParams>& p)
{
    p.choice("by", &ColourParams::by, {"material", "constant", "vertex", "attribute", "checker"},
             "What colours the meshes: their materials with their textures (vertices' own colours "
             "where "
             "no material is stated), one colour, their vertices' own colours, an attribute "
             "through a scale, or a checkered pattern, which shows "
             "how surfaces stretch and how texture coordinates lie. The alpha of a texture always "
             "takes effect, but in the pattern.")
        .colour("constant", &ColourParams::constant, "The one colour.", {"by", {"constant"}})
        .param(
            "attribute", &ColourParams::attribute,
            "Name of the attribute: `displacement`, `speed`, `stress`, `plastic_strain`, or any "
            "other that a mesh carries; meshes without it keep their material. Displacement from "
            "`rest` needs no attribute. Cubes also know `fill`, `young`, `density`, `component` "
            "and `matter`, and their own (LocalMatter, Voxelize).")
        .choice("map", &ColourParams::map, {"viridis", "diverging", "grey"},
                "Colours of the scale: `diverging` is for values of both signs.")
        .choice(
            "range", &ColourParams::range, {"fit", "fixed", "percentile"},
            "`fit` holds the values of each frame, of all that has the attribute, widened to round "
            "numbers, and 0 where they come near it; `fixed` runs from `low` to `high`, so that "
            "frames can be compared; "
            "`percentile` holds the values of "
            "each frame but the lowest and the highest, so that a few extremes do not take all "
            "colours: these have the colours of its ends. Where fewer than these differ at all, "
            "it holds them all; of `layers` it is as `fit`. With values of both signs, the "
            "scale of `diverging` reaches equally far to either side of 0.")
        .param("low", &ColourParams::low, "Value at the scale's low end.", {}, {"range", {"fixed"}})
        .param("high", &ColourParams::high, "Value at the scale's high end.", {},
               {"range", {"fixed"}})
        .param("clip", &ColourParams::clip,
               "Share of the values, one of each vertex, that lie beyond each end of the scale.",
               {0, 0.49}, {"range", {"percentile"}})
        .param("squares", &ColourParams::squares,
               "Squares along one unit of texture coordinates, of meshes that have them.",
               {0.01, 10'000}, {"by", {"checker"}})
        .param("square", &ColourParams::square,
               "Side of the squares on meshes without, where they lie in `rest` (without it they "
               "swim upon what moves); 0: a sixteenth of its diagonal.",
               {0, 1e9, "m"}, {"by", {"checker"}});
}

// "2 to 98 %", both with as many decimals as three digits of the first need.
inline std::string percentiles_told(double clip)
{
    const double percent = 100 * clip;
    int decimals = 0;
    for (double scale = 1; decimals < 9; ++decimals, scale *= 10) {
        if (std::abs(std::round(percent * scale) / scale - percent) <= 1e-3 * percent) break;
    }
    return fmt::format("{:.{}f} to {:.{}f} %", percent, decimals, 100 - percent, decimals);
}

// Why `low` and `high` are no ends of a scale; empty where they are. Compared as the scale holds
// them.
inline std::string wrong_range(double low, double high)
{
    if (static_cast<float>(low) < static_cast<float>(high)) return {};
    return fmt::format("a `fixed` range runs from `low` up to `high`, found {:.6g} and {:.6g}: set "
                       "`high` above `low`",
                       low, high);
}

// The same where it is known before a cook. Ends that move with the frame hold their defaults
// there.
inline std::string range_wrong_before(const ColourParams& colour)
{
    const ColourParams otherwise;
    const bool stated = colour.low != otherwise.low && colour.high != otherwise.high;
    const bool used =
        colour.by == ::render::Paint::By::attribute && colour.range == ColourParams::Range::fixed;
    return stated && used ? wrong_range(colour.low, colour.high) : std::string();
}

// The scale for `values`, and what its legend says. Throws std::invalid_argument as wrong_range()
// says.
inline ::render::Legend legend_for(const ColourParams& colour, const geometry::Attribute& values)
{
    ::render::Legend legend{values.name, values.unit, {colour.map, 0, 1}, {}};
    float &low = legend.scale.low, &high = legend.scale.high;
    const bool diverging = colour.map == ::render::ColourMap::diverging;
    if (colour.range == ColourParams::Range::fixed) {
        const std::string wrong = wrong_range(colour.low, colour.high);
        if (!wrong.empty()) throw std::invalid_argument("colour.low: " + wrong);
        low = static_cast<float>(colour.low);
        high = static_cast<float>(colour.high);
    } else if (colour.range == ColourParams::Range::fit) {
        const auto range = ::render::round_range(values.values, diverging);
        low = range[0], high = range[1];
    } else {
        const auto range = ::render::percentile_range(values.values, colour.clip);
        low = range.ends[0], high = range.ends[1];
        const bool even = diverging && low < 0 && high > 0;
        if (even) high = std::max(-low, high), low = -high;
        if (range.clips) legend.note = (even ? "at least " : "") + percentiles_told(colour.clip);
    }
    return legend;
}

// One scale for all that is coloured by an attribute, which `all` are the values of; not empty.
inline ::render::Legend legend_for(const ColourParams& colour,
                                   const std::vector<const geometry::Attribute*>& all)
{
    if (all.size() == 1) return legend_for(colour, *all[0]);
    geometry::Attribute joined{all[0]->name, all[0]->unit, {}};
    for (const geometry::Attribute* const some : all) {
        joined.values.insert(joined.values.end(), some->values.begin(), some->values.end());
    }
    return legend_for(colour, joined);
}

// `mesh` in the pattern, which sticks to it where `rest` (may be null) has as many vertices.
inline std::shared_ptr<const geometry::TriMesh>
in_checkers(const ColourParams& colour, const std::shared_ptr<const geometry::TriMesh>& mesh,
            const geometry::TriMesh* rest)
{
    const bool sticks = rest && rest->positions.size() == mesh->positions.size();
    const geometry::TriMesh& lies = sticks ? *rest : *mesh;
    double square = colour.square;
    if (square == 0) square = std::max(geometry::bounds(lies).diagonal() / 16, 1e-9);
    auto out = std::make_shared<geometry::TriMesh>(*mesh);
    out->topology = ::render::checkered(*mesh, lies, colour.squares, square);
    return out;
}

using Meshes = std::vector<graph::Wire<geometry::TriMesh>>;

// Null where the mesh has no such attribute.
inline const geometry::Attribute* find_attribute(const geometry::TriMesh& mesh,
                                                 const std::string& name)
{
    const auto found = std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
                                    [&](const auto& a) { return a.name == name; });
    return found == mesh.attributes.end() ? nullptr : &*found;
}

inline bool has_attribute(const geometry::TriMesh& mesh, const std::string& name)
{
    return find_attribute(mesh, name) != nullptr;
}

inline bool any_has(const Meshes& meshes, const std::string& name)
{
    return std::any_of(meshes.begin(), meshes.end(),
                       [&](const auto& mesh) { return has_attribute(*mesh, name); });
}

// With their displacement from `rest` (which may be null) where they have as many vertices.
inline Meshes with_displacements(Meshes meshes, const geometry::TriMesh* rest)
{
    for (auto& mesh : meshes) mesh = ::render::with_displacement(mesh, rest);
    return meshes;
}

}  // namespace nodes::render
