#pragma once

// What Simulate doubts of loads and bodies that it takes as they are.

#include "geometry/cubes/plane.hpp"
#include "nodes/simulate_bodies.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/state_models.hpp"
#include "physics/state/step_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace nodes::simulate {

// Steps take a pressure's direction from the shape that they begin with.
inline std::vector<std::string>
told_of_high_pressure(const std::vector<graph::Wire<geometry::Cubes>>& cubes,
                      const std::vector<graph::Wire<physics::Force>>& forces)
{
    constexpr double high = 0.1;  // of Young's modulus
    const auto of_pressure = [](const auto& force) {
        return force->kind == physics::Force::Kind::pressure;
    };
    if (std::none_of(forces.begin(), forces.end(), of_pressure)) return {};
    double young = std::numeric_limits<double>::infinity();
    for (const auto& model : cubes) {
        for (const double e : model->young) young = std::min(young, e);
    }
    std::vector<std::string> told;
    for (std::size_t i = 0; i < forces.size(); ++i) {
        if (!of_pressure(forces[i]) || std::abs(forces[i]->pressure) <= high * young) continue;
        told.push_back(
            fmt::format("force {} of {} is a pressure of more than a tenth of the least Young's "
                        "modulus of the body, which may then swing from step to step: lower it, or "
                        "use a stiffer material or more substeps",
                        i + 1, forces.size()));
    }
    return told;
}

// Why bodies of several links of `cubes` cannot be simulated together by a method other than
// bricks. Empty where they can.
inline std::string sheets_beside_solids(const std::vector<graph::Wire<geometry::Cubes>>& cubes)
{
    std::string flat, solid;
    for (std::size_t i = 0; i < cubes.size(); ++i) {
        std::string& list = geometry::flat_axis(*cubes[i]) >= 0 ? flat : solid;
        list += fmt::format("{}cubes[{}]", list.empty() ? "" : ", ", i);
    }
    if (flat.empty() || solid.empty()) return {};
    return fmt::format("sheets without thickness ({}) and solids ({}) are moved together by method "
                       "= bricks alone, the sheets as by method shell: set method = bricks",
                       flat, solid);
}

// Several pins that hold points of one rigid body, which are meant for a hinge more often than for
// the clamp that they are.
inline std::vector<std::string>
told_of_clamps(const std::vector<graph::Wire<geometry::Cubes>>& cubes,
               const std::vector<graph::Wire<physics::Pins>>& pins,
               const std::vector<OneBody>& bodies)
{
    std::vector<std::string> told;
    for (std::size_t i = 0; i < std::min(cubes.size(), bodies.size()); ++i) {
        if (!bodies[i].rigid) continue;
        const std::uint64_t mark = physics::mark_of(*cubes[i]);
        const auto clamps = std::count_if(pins.begin(), pins.end(), [&](const auto& some) {
            return some->cubes == mark && !some->matter.cubes.empty();
        });
        if (clamps < 2) continue;
        told.push_back(fmt::format(
            "{} pins with hold = points hold the rigid body of cubes[{}]: each holds many points, "
            "which "
            "lets nothing turn, so that they are a clamp and no hinge. For a hinge set hold = "
            "corners, in a place that holds one line of corners",
            clamps, i));
    }
    return told;
}

// A step.error that is stated where the number of steps does not follow it.
inline std::string told_of_unused_error(const physics::StepOptions& step)
{
    if (step.error == physics::StepOptions{}.error) return {};
    if (step.substeps > 0) {
        return fmt::format("step.error has no effect, because step.substeps = {}: set that to 0",
                           step.substeps);
    }
    if (step.integrator == physics::Integrator::implicit_euler) return {};
    return "step.error has no effect: it is known with step.integrator = implicit_euler alone, and "
           "others take one step a frame. Set step.substeps";
}

// Bodies so large that they hardly seem to fall, as those of a mesh in centimetres or millimetres
// that is read as metres. `dt`: s, of a frame.
inline std::vector<std::string>
told_of_giants(const std::vector<graph::Wire<geometry::Cubes>>& cubes, const Vec3& gravity,
               double dt)
{
    constexpr double large = 50;            // m; as `aspic info` has it
    constexpr double visible = 1.0 / 1000;  // of the body
    const double fall = gravity.norm() * dt * dt / 2;
    std::vector<std::string> told;
    for (std::size_t i = 0; i < cubes.size() && fall > 0; ++i) {
        geometry::Box box;
        for (const Vec3& p : geometry::corner_positions(*cubes[i])) box.add(p);
        const double longest = box.empty() ? 0 : box.size().maxCoeff();
        if (!(longest > large && fall < visible * longest)) continue;
        told.push_back(fmt::format(
            "the body of cubes[{}] is {:.3g} m long, and falls {:.2g} m in its first frame, too "
            "little to see. If its mesh is in centimetres or millimetres, set `unit` of ReadMesh, "
            "or scale it",
            i, longest, fall));
    }
    return told;
}

}  // namespace nodes::simulate
