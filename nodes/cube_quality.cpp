#include "nodes/cube_quality.hpp"

#include "geometry/cells/voxel_grid.hpp"
#include "geometry/mesh/mesh.hpp"
#include "graph/document/json.hpp"
#include "physics/bricks/bending_error.hpp"
#include "physics/modal/size_for_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace nodes {
namespace {

// Cubes along the longest side, of the coarsest that are tried.
constexpr int least_resolution = 6;

double error_of(const WantedQuality& wanted)
{
    switch (wanted.quality) {
    case Quality::draft:
        return 0.2;
    case Quality::good:
        return 0.05;
    case Quality::exact:
        return 0.01;
    default:
        return wanted.error;
    }
}

const char* name_of(Quality quality)
{
    switch (quality) {
    case Quality::draft:
        return "draft";
    case Quality::good:
        return "good";
    case Quality::exact:
        return "exact";
    default:
        return "by_error";
    }
}

std::string percent(double share)
{
    return share < 10 ? fmt::format("{:.2g} %", 100 * share) : "over 1000 %";
}

// Of the vibration that is most wrong: "cubes of 0.1, 0.05 and 0.025 m give 9.1, 9.4 and 9.5 Hz as
// the second lowest frequency, with order 1.9".
std::string reason_of(const physics::SizeForError& found)
{
    std::string sizes, hertz;
    const std::size_t n = found.tried.size(), first = n > 3 ? n - 3 : 0;
    for (std::size_t i = first; i < n; ++i) {
        const physics::TriedSize& t = found.tried[i];
        const char* between = i == first ? "" : i + 1 == n ? " and " : ", ";
        sizes += between + fmt::format("{:.3g}", t.size);
        hertz += between + (t.omega_sq.empty()
                                ? std::string("an unknown number of")
                                : fmt::format("{:.4g}", std::sqrt(t.omega_sq[found.vibration]) /
                                                            (2 * std::numbers::pi)));
    }
    constexpr std::array which{"", "second ", "third "};
    return fmt::format("cubes of {} m give {} Hz as the {}lowest frequency, {}", sizes, hertz,
                       which.at(found.vibration),
                       n < 3              ? "too few sizes to know an error"
                       : found.order == 0 ? "with no order of convergence yet"
                       : found.order == 1 ? "with an order of 1 or less, taken as 1"
                                          : fmt::format("with order {:.2g}", found.order));
}

// What is said where the error is not reached.
std::string shortfall_of(const physics::SizeForError& found, const WantedQuality& wanted)
{
    const std::string error = percent(error_of(wanted));
    if (found.would_do > 0) {
        return fmt::format("an error of {} takes cubes of about {:.2g} m, more than max_cubes = {} "
                           "allows; ",
                           error, found.would_do, wanted.max_cubes);
    }
    return fmt::format(
        "no size was found for an error of {} among as many cubes as may be tried "
        "(30,000 to 100,000, and max_cubes = {}); compare results with finer cubes; ",
        error, wanted.max_cubes);
}

// "with an error of about 7 % in stiffness (5 % wanted)".
std::string error_text(const physics::SizeForError& found, double wanted)
{
    if (!std::isfinite(found.error)) return "with an error that is not known";
    const std::string by = found.order > 0 ? "their order" : "order 1, if they have it,";
    if (found.foretold && found.reached) {
        return fmt::format("as {} promises an error of {}", by, percent(wanted));
    }
    const std::string error = fmt::format("an error of about {} in stiffness ({} wanted)",
                                          percent(found.error), percent(wanted));
    return found.foretold
               ? fmt::format("about the finest that it allows, as {} promises {}", by, error)
               : "with " + error;
}

}  // namespace

double size_of_quality(const geometry::TriMesh& mesh, bool solid, const WantedQuality& wanted,
                       const std::function<geometry::Cubes(double)>& cubes_of,
                       const graph::Context& context)
{
    physics::SizeSearch search;
    const double coarsest = geometry::size_for(geometry::triangle_bounds(mesh), least_resolution);
    search.start = coarsest;
    search.error = error_of(wanted);
    search.most = wanted.max_cubes;
    search.most_tried = std::min(search.most_tried, wanted.max_cubes);
    // A wall thinner than all cubes, or a gap as wide, could look alike in all.
    if (const auto wall = solid ? physics::thinnest_wall(mesh) : std::nullopt) {
        search.finest_needed = 1.01 * wall->thickness;
        // One that lies along the grid is then whole cubes thick, which is exact.
        const double halvings = std::ceil(std::log2(wall->thickness / coarsest));
        search.start = wall->thickness * std::exp2(-halvings);
    }
    bool first = true;
    const auto tried = [&](double size) -> std::optional<geometry::Cubes> {
        if (context.stop.stop_requested()) throw graph::Cancelled();
        try {
            auto cubes = cubes_of(size);
            first = false;
            return cubes;
        } catch (const std::invalid_argument&) {
            if (first) throw;
            return std::nullopt;
        }
    };
    const physics::SizeForError found = physics::size_for_error(tried, search);
    context.warn(fmt::format("quality = {}: {}chose cubes of {:.3g} m, {}: {}",
                             name_of(wanted.quality),
                             found.reached ? "" : shortfall_of(found, wanted), found.size,
                             error_text(found, search.error), reason_of(found)));
    return found.size;
}

void write_out_size(graph::Json& node)
{
    graph::Json* const params = node.find("params");
    graph::Json* const size = params ? params->find("size") : nullptr;
    if (!size || params->find("quality")) return;
    // A wrong word is told as a quality, and "2 cm" as a size.
    if (size->text() && size->text()->find_first_of("=0123456789") == std::string::npos) {
        graph::rename(*params, "size", "quality");
        return;
    }
    graph::Json* const chosen = size->find("auto");
    graph::Json* const error = chosen ? chosen->find("error") : nullptr;
    if (!error || size->object()->size() != 1 || chosen->object()->size() != 1) return;
    graph::Json value = *error;
    *size = std::move(value);
    graph::rename(*params, "size", "error");
    graph::put_missing(*params, "quality", std::string("by_error"));
}

}  // namespace nodes
