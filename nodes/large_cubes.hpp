#pragma once

// What Voxelize says of a model that its cubes are too large for: walls that are too stiff, and
// separate pieces that move as one.

#include "geometry/cubes/glued_pieces.hpp"
#include "graph/types/context.hpp"
#include "physics/bricks/bending_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace nodes {

inline std::string place_text(const geometry::Vec3& p)
{
    return fmt::format("({:.3g}, {:.3g}, {:.3g})", p.x(), p.y(), p.z());
}

// Two digits: 1.6, 23, 750.
inline std::string times_text(double factor)
{
    if (factor < 99.5) return fmt::format("{:.2g}", factor);
    const double digit = std::pow(10, std::floor(std::log10(factor)) - 1);
    return fmt::format("{:.0f}", std::round(factor / digit) * digit);
}

// "'seat' is 0.4 cubes thick (0.002 m, at (0, 0.4, 0))".
inline std::string thin_text(const physics::ThinPart& part, double size)
{
    return fmt::format(
        "{} {} {:.2g} cubes thick ({:.2g} m, at {})", part.name.empty() ? "the model" : part.name,
        part.share > 0.8 ? "is" : fmt::format("is in part ({:.0f} %)", 100 * part.share),
        part.thickness / size, part.thickness, place_text(part.where));
}

// m, two digits: cubes that bend rightly in a wall, and are smaller than those that do not.
inline double better_size(double thickness, double size)
{
    constexpr double smaller = 0.75, cubes_a_wall = 2.5;
    return physics::size_for_wall(std::min(thickness, cubes_a_wall * smaller * size));
}

// Of the parts as physics::thin_parts() gives them.
inline void warn_of_thin_walls(const std::vector<physics::ThinPart>& parts,
                               const geometry::Cubes& cubes, const physics::WallOptions& walls,
                               const graph::Context& context)
{
    constexpr double worth_telling = 1.5;
    std::size_t more = 0;
    for (const physics::ThinPart& p : parts) more += p.factor >= worth_telling ? 1 : 0;
    if (more == 0) return;
    const physics::ThinPart& worst = parts.front();
    std::string text =
        fmt::format("{}{}: about {} times too stiff in bending; use cubes of "
                    "{:.2g} m",
                    graph::of_bending, thin_text(worst, cubes.size), times_text(worst.factor),
                    better_size(worst.thickness, cubes.size));
    if (walls.solid && !(walls.thickness > 0)) text += ", or stiffness = calibrated";
    if (more > 1) {
        text += fmt::format(" ({} part{} more {} too thin for these cubes)", more - 1,
                            more == 2 ? "" : "s", more == 2 ? "is" : "are");
    }
    context.warn(text);
}

// `apart`: pieces were to be kept apart, but for those within `join`, m.
inline void warn_of_glued_pieces(const geometry::TriMesh& mesh, const geometry::Cubes& cubes,
                                 bool apart, double join, const graph::Context& context)
{
    const geometry::Pieces pieces = geometry::find_pieces(mesh);
    const geometry::GluedPieces glued =
        geometry::find_glued_pieces(mesh, pieces, cubes, apart ? join : 0);
    if (glued.count == 0) return;
    context.warn(fmt::format(
        "{} separate pieces of the mesh share corners of cubes and move as one: pieces {} and {} "
        "are {:.2g} m apart at {}; use cubes of {:.2g} m{} to keep these two apart",
        glued.count, glued.pair[0] + 1, glued.pair[1] + 1, glued.gap, place_text(glued.where),
        glued.size, apart ? "" : ", or pieces = apart,"));
}

}  // namespace nodes
