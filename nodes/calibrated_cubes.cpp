#include "nodes/calibrated_cubes.hpp"

#include "geometry/mesh/mesh.hpp"
#include "nodes/large_cubes.hpp"
#include "physics/modal/calibrate.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace nodes {
namespace {

constexpr int finest = 16;
constexpr double wanted_fine_cubes = most_fine_cubes / 2;

double fine_count(const geometry::Cubes& cubes, int ratio)
{
    return count_at(cubes, cubes.size / ratio);
}

// Four fine cubes through the thinnest wall, or as many as there may be.
int ratio_for(const geometry::Cubes& cubes, double thickness)
{
    constexpr double through = 4;
    int ratio = static_cast<int>(through);
    if (thickness > 0) {
        const double wanted = std::ceil(through * cubes.size / thickness - 0.01);
        ratio = static_cast<int>(std::clamp(wanted, 2.0, double(finest)));
    }
    while (ratio > 2 && fine_count(cubes, ratio) > wanted_fine_cubes) --ratio;
    return ratio;
}

// A wall, and how many fine cubes lie along a cube.
void warn_of_thin(const physics::ThinPart& part, const geometry::Cubes& cubes, int ratio,
                  const graph::Context& context)
{
    constexpr double usable = 2.2;  // cubes as thick as so many walls
    const double size = cubes.size;
    const std::string where = thin_text(part, size);
    if (size > usable * part.thickness) {
        context.warn(fmt::format(
            "{}: its calibrated stiffness may be wrong by a factor of 2; {}", where,
            can_be_calibrated(cubes, part.thickness)
                ? fmt::format("use cubes of {:.2g} m", calibrated_size(part.thickness, size))
                : fmt::format("cubes of {:.2g} m would take more than {} fine ones: make cubes of "
                              "a part of it alone",
                              calibrated_size(part.thickness, size), most_fine_cubes)));
    } else if (ratio * part.thickness < fine_through_wall * size) {
        context.warn(fmt::format("{}, and {:.2g} fine cubes: its calibrated stiffness is too high; "
                                 "use smaller cubes, or raise calibration.fine",
                                 where, ratio * part.thickness / size));
    }
}

}  // namespace

geometry::Cubes with_calibrated_stiffness(const geometry::TriMesh& mesh,
                                          const geometry::Cubes& cubes,
                                          const CalibrationParams& params,
                                          const std::function<geometry::Cubes(int)>& fine_of,
                                          const graph::Context& context)
{
    auto parts = physics::thin_parts(mesh, cubes, {true, 0});
    // Those that are right take no more fine cubes than others do.
    std::erase_if(parts, [&](const physics::ThinPart& part) {
        return !(part.factor > 1) || part.thickness > 5 * cubes.size;
    });
    const auto thinnest =
        std::min_element(parts.begin(), parts.end(),
                         [](const auto& a, const auto& b) { return a.thickness < b.thickness; });
    const bool thin = thinnest != parts.end();
    const int ratio =
        params.fine > 0 ? params.fine : ratio_for(cubes, thin ? thinnest->thickness : 0);
    if (fine_count(cubes, ratio) > most_fine_cubes) {
        throw std::invalid_argument(
            fmt::format("stiffness = calibrated with {} fine cubes along a cube takes about {:.0f} "
                        "of them, the limit is {:.0f}: {}use larger cubes, or stiffness = filled",
                        ratio, fine_count(cubes, ratio), most_fine_cubes,
                        params.fine > 2 ? "lower calibration.fine, " : ""));
    }
    physics::Report report;
    const geometry::Cubes fine = fine_of(ratio);
    geometry::Cubes out = physics::calibrated(cubes, {fine, ratio}, {params.modes}, report);
    if (!report.converged) {
        context.warn("not all motions of the fine cubes were found: the calibrated stiffness is "
                     "less accurate; lower calibration.modes, or set stiffness = filled");
    }
    if (thin) warn_of_thin(*thinnest, cubes, ratio, context);
    return out;
}

}  // namespace nodes
