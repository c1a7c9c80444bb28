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
    constexpr double smaller = 0.75, cubes_a_wall = 4;
    return physics::size_for_wall(std::min(thickness, cubes_a_wall * smaller * size));
}

// About how many cubes of another size the same body has: its volume, and as much again along its
// surface. The size may be larger by a little.
inline double count_at(const geometry::Cubes& cubes, double size)
{
    double volume = 0, partly = 0;
    for (const double fill : cubes.fill) {
        volume += fill;
        partly += fill < 0.999 ? 1 : 0;
    }
    const double ratio = cubes.size / size;
    return ratio * ratio * (volume * ratio + 2 * partly);
}

// "12,000", "2.3 million".
inline std::string count_text(double count)
{
    if (count >= 999'500) return fmt::format("{:.2g} million", count / 1e6);
    const double digit = std::pow(10, std::max(0.0, std::floor(std::log10(count)) - 1));
    const long rounded = std::lround(std::round(count / digit) * digit);
    return rounded < 10'000 ? fmt::format("{}", rounded)
                            : fmt::format("{},{:03}", rounded / 1000, rounded % 1000);
}

// What stiffness = calibrated can do for walls of a thickness.
inline constexpr double most_fine_cubes = 400'000;
inline constexpr double fine_through_wall = 2.5;  // the fewest that are right

inline bool can_be_calibrated(const geometry::Cubes& cubes, double thickness)
{
    return count_at(cubes, thickness / fine_through_wall) <= most_fine_cubes;
}

// m: the largest cubes that are right with it, and no larger than these.
inline double calibrated_size(double thickness, double size)
{
    return std::min(2 * thickness, size);
}

// What is advised against walls that are too stiff.
struct WallPlan {
    double size = 0;  // m, of cubes; 0: none
    std::string text;
};

// Cubes, beyond which another way is better.
inline constexpr double many_cubes = 1e6;

inline WallPlan plan_for_wall(const physics::ThinPart& part, const geometry::Cubes& cubes,
                              bool calibrates, std::size_t max_cubes)
{
    const double filled = better_size(part.thickness, cubes.size);
    const double count = count_at(cubes, filled);
    const bool too_many = count > std::min(many_cubes, double(max_cubes));
    const std::string cubes_filled = fmt::format("cubes of {:.2g} m", filled);
    if (calibrates && can_be_calibrated(cubes, part.thickness)) {
        const double size = calibrated_size(part.thickness, cubes.size);
        const std::string calibrated =
            "stiffness = calibrated" +
            (size < cubes.size ? fmt::format(" with cubes of {:.2g} m", size) : std::string());
        if (too_many) {
            return {size, fmt::format("set {}, which is within about 20 %, as {} would be about {}",
                                      calibrated, cubes_filled, count_text(count))};
        }
        return {filled, fmt::format("use {}, which are at most 20 % too stiff, or {}", cubes_filled,
                                    calibrated)};
    }
    if (count <= double(max_cubes)) {
        return {filled, fmt::format("use {}{}, which are at most 20 % too stiff", cubes_filled,
                                    too_many ? fmt::format(" (about {})", count_text(count)) : "")};
    }
    return {0,
            fmt::format("{} would be about {}, more than max_cubes = {}{}: make cubes of a part "
                        "of it alone, or keep it rigid where it hardly bends",
                        cubes_filled, count_text(count), max_cubes,
                        calibrates ? ", and stiffness = calibrated takes too many as well" : "")};
}

// A part that is hardly longer than thick shears more than it bends.
inline bool is_worth_telling(const physics::ThinPart& part)
{
    constexpr double slender = 5, promised = 1.2;  // of the cubes that are advised
    return part.factor >= (part.slenderness < slender ? 1.5 : promised);
}

// Of the parts as physics::thin_parts() gives them. Returns the size of cubes that is advised, m;
// 0: none.
inline double warn_of_thin_walls(const std::vector<physics::ThinPart>& parts,
                                 const geometry::Cubes& cubes, const physics::WallOptions& walls,
                                 std::size_t max_cubes, const graph::Context& context)
{
    const auto more = std::count_if(parts.begin(), parts.end(), is_worth_telling);
    if (more == 0) return 0;
    const physics::ThinPart& worst = *std::find_if(parts.begin(), parts.end(), is_worth_telling);
    const bool calibrates = walls.solid && !(walls.thickness > 0);
    const WallPlan plan = plan_for_wall(worst, cubes, calibrates, max_cubes);
    std::string text =
        fmt::format("{}{}: about {} times too stiff in bending; {}", graph::of_bending,
                    thin_text(worst, cubes.size), times_text(worst.factor), plan.text);
    if (more > 1) {
        text += fmt::format(" ({} part{} more {} too thin for these cubes)", more - 1,
                            more == 2 ? "" : "s", more == 2 ? "is" : "are");
    }
    context.warn(text);
    return plan.size;
}

// What keeps two pieces apart. `planned`: m, the cubes that are advised for another reason; 0:
// none.
inline std::string plan_for_gap(const geometry::GluedPieces& glued, const geometry::Cubes& cubes,
                                bool apart, double planned)
{
    const double open = 1.75 * glued.gap;  // m: pieces = apart keeps gaps of half a cube open
    const std::string also_apart = apart ? "" : "pieces = apart and ";
    if (planned > 0 && planned <= glued.size) {
        return fmt::format("cubes of {:.2g} m, as bending takes, keep these two apart", planned);
    }
    if (planned > 0 && planned <= open) {
        return fmt::format("{}cubes of {:.2g} m, as bending takes, keep these two apart",
                           also_apart, planned);
    }
    if (planned > 0 || count_at(cubes, glued.size) > many_cubes) {
        return fmt::format("{}cubes of {:.2g} m{} keep these two apart", also_apart,
                           std::min(open, cubes.size),
                           planned > 0 ? ", which bend no worse than those above," : "");
    }
    return fmt::format("use cubes of {:.2g} m{} to keep these two apart", glued.size,
                       apart ? "" : ", or pieces = apart,");
}

// `apart`: pieces were to be kept apart, but for those within `join`, m. `planned`: as above.
inline void warn_of_glued_pieces(const geometry::TriMesh& mesh, const geometry::Cubes& cubes,
                                 bool apart, double join, double planned,
                                 const graph::Context& context)
{
    const geometry::Pieces pieces = geometry::find_pieces(mesh);
    const geometry::GluedPieces glued =
        geometry::find_glued_pieces(mesh, pieces, cubes, apart ? join : 0);
    if (glued.count == 0) return;
    context.warn(fmt::format(
        "{}{} separate pieces of the mesh share corners of cubes and move as one: pieces {} and {} "
        "are {:.2g} m apart at {}; {}",
        glued.at_least ? "at least " : "", glued.count, glued.pair[0] + 1, glued.pair[1] + 1,
        glued.gap, place_text(glued.where), plan_for_gap(glued, cubes, apart, planned)));
}

}  // namespace nodes
