#include "physics/lattice/step_report.hpp"

#include "physics/state/report_texts.hpp"
#include "physics/state/step_options.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <cmath>

namespace physics {

namespace {

// Of cells_crossed(). A single corner of a free sheet kicked at 2.5 cells a substep keeps its
// energy for ten seconds; at 3 it doubles, at 6 and more it grows a hundredfold.
constexpr double most_crossed = 2.5;

// The next of 1, 2, 5, 10, 20 ... : so that frames that differ a little advise the same.
double round_number(double v)
{
    const double ten = std::pow(10, std::floor(std::log10(v)));
    for (const double times : {1, 2, 5}) {
        if (v <= times * ten) return times * ten;
    }
    return 10 * ten;
}

// `crossed` is of the start of the frame: what is kicked slows down within it.
void warn_of_speed(FrameState& step, double crossed)
{
    if (!(crossed > most_crossed)) return;
    step.state.report.converged = false;
    const double needed = round_number(step.options.substeps * crossed / most_crossed);
    step.state.report.warnings.push_back(
        needed <= most_substeps
            ? fmt::format("The sheet moves too fast for its time step and gains energy; use at "
                          "least {} substeps.",
                          needed)
            : fmt::format("The sheet moves too fast for its time step and gains energy, even with "
                          "{} substeps; check for very large forces or pin targets.",
                          most_substeps));
}

// Measured on cantilevers: solids bend a fifth to a third too far at a fifth of their length,
// planes half too far at a tenth.
void warn_of_wide_regions(FrameState& step)
{
    const int w = step.body.whole.regions.half_width, length = step.body.slender;
    const bool plane = bends_in_space(step);
    if (step.options.stiffness != Stiffness::material || (step.flat && !plane) || length < 6) {
        return;
    }
    if ((plane ? 12 : 5) * w < length || w == 1) return;
    step.state.report.warnings.push_back(fmt::format(
        "A half width of {} is too large for a body {} cubes long: it bends further than its "
        "material. Use a half width of {}, or smaller cubes.",
        w, length, std::max(1, length / (plane ? 16 : 10))));
}

// Measured on cubes that are held on one side and sheared by their weight: with a half width of
// half their length they shear by 0.86 of what bricks do (0.6 where calibrated for bends), with a
// third by 0.94.
void warn_of_blunt_regions(FrameState& step)
{
    const int w = step.body.whole.regions.half_width, length = step.body.compact;
    if (step.options.stiffness != Stiffness::material || step.flat || w == 1) return;
    if (length == 0 || 2 * w < length) return;
    step.state.report.warnings.push_back(fmt::format(
        "A half width of {} is too large for a body {} cubes long: it shears less than its "
        "material. Use a half width of {}, or smaller cubes.",
        w, length, std::max(1, length / 4)));
}

// A thin body that bends as its material does stretches further, by what is told here.
void warn_of_stretch(FrameState& step)
{
    if (step.options.stiffness != Stiffness::material || step.flat) return;
    if (step.body.soft_stretch < 2) return;
    const bool narrower = step.body.whole.regions.half_width > 1;
    step.state.report.warnings.push_back(fmt::format(
        "The body is thin for its cubes: it bends as its material does, but stretches about {:.1f} "
        "times as far. Use {}smaller cubes, calibrate = both, or method = bricks.",
        step.body.soft_stretch, narrower ? "a smaller half width, " : ""));
}

// Where links are broken the numbers change from frame to frame, and it was told before.
void warn_of_poisson(FrameState& step)
{
    constexpr double seen = 0.1;
    if (step.resolved > 1 || step.held_regions) return;
    if (!(step.poisson - step.poisson_acts > seen)) return;
    const int needed = substeps_for_volume(step);
    step.state.report.warnings.push_back(fmt::format(
        "The lattice keeps less of its volume than its material: Poisson's ratio acts as {:.2f}, "
        "not {:.2f}. {}",
        step.poisson_acts, step.poisson,
        needed <= most_substeps
            ? fmt::format("From {} substeps on it keeps all; wider regions need fewer.", needed)
            : "Use wider regions, or a smaller Poisson's ratio."));
}

// A step takes at most all of a region's speed. Where links are broken it was told before.
void warn_of_damping(FrameState& step)
{
    constexpr double least = 0.5;  // of what is asked for
    constexpr double whole = 0.2;  // of tau damped_by: nine tenths act
    if (step.resolved > 1 || step.held_regions || !(step.tau_acts < least * step.tau)) return;
    const double needed = round_number(step.options.substeps * step.tau * step.damped_by / whole);
    step.state.report.warnings.push_back(fmt::format(
        "Damping proportional to stiffness acts as {:.2g} s, not {:.2g} s: a step damps no more. "
        "Use mass_damping of the matter{}.",
        step.tau_acts, step.tau,
        needed <= most_substeps ? fmt::format(", or at least {} substeps", needed) : ""));
}

// A lattice comes back from anything, so what is less than a quarter does not matter. Only the
// skin's are counted.
void warn_of_inverted(FrameState& step)
{
    if (step.flat || !step.state.broken.empty()) return;
    const CornerRuns& cubes = step.body.base.skin.corners;
    std::size_t count = 0;
    cubes.for_each(0, cubes.size(), [&](std::size_t, const CornerRuns::Corners& corners) {
        Mat3 sides = Mat3::Zero();
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t d = 0; d < 3; ++d) {
                sides.col(Eigen::Index(d)) +=
                    (a >> d & 1 ? 0.25 : -0.25) * step.state.x[corners[a]];
            }
        }
        count += sides.determinant() < 0;
    });
    if (4 * count < cubes.size() || count == 0) return;
    const std::string text = told_of_inverted(count, cubes.size(), false, by_substeps);
    step.state.report.warnings.push_back(text);
}

void warn_of_softness(FrameState& step)
{
    if (step.options.stiffness != Stiffness::material || !(step.resolved > 1)) return;
    const int least = least_substeps(step);
    const bool more = least <= most_substeps;
    step.state.report.converged = false;
    step.state.report.warnings.push_back(
        bends_in_space(step)
            ? fmt::format("The sheet is softer than its material: cells of {:.3g} m need at least "
                          "{} substeps. {}",
                          step.body.base.h, least,
                          more ? "Raise substeps, or use larger cells." : "Use larger cells.")
            : fmt::format("The lattice is softer than its material: a half width of {} needs at "
                          "least {} substeps{}. {}",
                          step.body.whole.regions.half_width, least,
                          step.body.poisson > 0
                              ? fmt::format(" ({} to keep its volume)", substeps_for_volume(step))
                              : "",
                          more ? "Raise substeps, widen the regions, or set a rate."
                               : "Widen the regions, or set a rate."));
}

}  // namespace

double cells_crossed(const FrameState& step)
{
    const Membrane& membrane = step.body.membrane;
    const auto& v = step.state.v;
    const auto fastest_of = [&](std::size_t strip) {
        double most = 0;
        membrane.for_each_cell(strip, strip + 1, [&](std::size_t, const Membrane::Cell& cell) {
            for (const std::size_t side : {1u, 2u}) {
                most = std::max(most, (v[cell[side]] - v[cell[0]]).squaredNorm());
            }
        });
        return most;
    };
    const double fastest_sq = largest_of(membrane.strip.size(), fastest_of, membrane_strips_a_task);
    return std::sqrt(fastest_sq) * step.dt / step.body.base.h;
}

int least_substeps(const FrameState& step)
{
    return int(std::min(1e9, std::ceil(step.options.substeps * step.resolved)));
}

int substeps_for_volume(const FrameState& step)
{
    return int(std::min(1e9, std::ceil(step.options.substeps * step.resolved_volume)));
}

void report_frame(FrameState& step, double crossed)
{
    step.state.report = {};
    step.state.report.steps = step.options.substeps;
    warn_of_speed(step, crossed);
    warn_of_wide_regions(step);
    warn_of_blunt_regions(step);
    warn_of_stretch(step);
    warn_of_poisson(step);
    warn_of_damping(step);
    warn_of_inverted(step);
    warn_of_softness(step);
}

}  // namespace physics
