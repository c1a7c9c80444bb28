#pragma once

// What is special about one of several bodies of Simulate, and what Simulate suggests of them.

#include "geometry/cubes/cubes.hpp"
#include "geometry/cubes/plane.hpp"
#include "graph/types/node_builder.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/report_texts.hpp"
#include "physics/state/state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

namespace nodes::simulate {

using geometry::Vec3;

struct OneBody {
    Vec3 velocity{0, 0, 0};
    Vec3 spin_degrees{0, 0, 0};
    bool rigid = false;
};
inline bool any_rigid(const std::vector<OneBody>& bodies)
{
    return std::any_of(bodies.begin(), bodies.end(), [](const auto& body) { return body.rigid; });
}

inline void describe_body(graph::ParamsOf<OneBody>& p)
{
    p.param("velocity", &OneBody::velocity,
            "Velocity of this body that is added to the initial state.", {.unit = "m/s"})
        .param("spin_degrees", &OneBody::spin_degrees,
               "Angular velocity of this body about its own centre of mass, about x, y and z, that "
               "is added to the initial state.",
               {.unit = "deg/s"})
        .param("rigid", &OneBody::rigid,
               "Whether this body keeps its shape: each of its pieces moves as a rigid body, with "
               "the mass of its cubes and the centre and inertia of its surface, and pushes and is "
               "pushed as others are (method bricks). Right, and many times faster, for what would "
               "not visibly bend: wood, stone, metal. Its Young's modulus counts for its contacts "
               "alone. Beside rigid bodies, elastic ones are solved with linear forces in each "
               "round. Needs step.integrator = implicit_euler and initial_shape = given.");
}

// Bodies that hardly strained in a frame that took many times the steps asked for, or did not
// converge: they would look the same as rigid bodies, which take few. `asked`: steps; 0: as many
// as are needed.
inline std::vector<std::string>
told_of_stiff(const std::vector<graph::Wire<geometry::Cubes>>& cubes,
              const std::vector<OneBody>& bodies, const physics::State& state, int asked)
{
    constexpr int many = 8;
    constexpr double visible = 0.005;   // strain
    constexpr double stiff_from = 1e8;  // Pa
    const bool slow = state.report.steps >= many * std::max(1, asked);
    if (!slow && !physics::stopped_short(state.report)) return {};
    std::string stiff;
    std::size_t cube = 0;
    for (std::size_t i = 0; i < cubes.size(); ++i) {
        double most = 0, softest = std::numeric_limits<double>::infinity();
        for (const double young : cubes[i]->young) {
            softest = std::min(softest, young);
            if (cube < state.stress.size()) most = std::max(most, state.stress[cube] / young);
            ++cube;
        }
        const bool rigid = i < bodies.size() && bodies[i].rigid;
        if (rigid || geometry::flat_axis(*cubes[i]) >= 0 || cubes[i]->is_sheet()) continue;
        if (!(most < visible && softest >= stiff_from)) continue;
        stiff += fmt::format("{}{}", stiff.empty() ? "" : ", ", i);
    }
    if (stiff.empty()) return {};
    const bool touched = !state.grips.empty() || !state.holds.empty();
    return {fmt::format(
        "stiff bodies {}, {}: set `rigid` = true in `bodies` (entry {}) "
        "where they would not visibly bend{}",
        touched ? "hit something" : "are driven or turn fast",
        !slow ? std::string(touched ? "and contact did not converge"
                                    : "and the steps did not converge")
        : asked > 0
            ? fmt::format("which took {} times as many steps as were asked for, or more", many)
            : fmt::format("which took {} steps a frame, or more", many),
        stiff, touched ? "" : ", or let what drives them begin and end gently")};
}

// Rigid bodies whose pins are not where they ask to be at the end of a frame, as no rigid motion
// takes all of them there, or as steps are too long for how they swing.
inline std::vector<std::string>
told_of_torn_pins(const std::vector<graph::Wire<geometry::Cubes>>& cubes,
                  const std::vector<OneBody>& bodies, const physics::Pins& pins,
                  const physics::State& state)
{
    constexpr double visible = 0.02;  // cubes
    std::vector<std::string> out;
    std::size_t first = 0, pin = 0;  // pins are sorted by corner
    for (std::size_t i = 0; i < cubes.size(); ++i) {
        const std::size_t end = first + cubes[i]->corner_count();
        bool off = false;
        for (; pin < pins.corner.size() && pins.corner[pin] < end; ++pin) {
            geometry::Vec3 miss = state.x[pins.corner[pin]] - pins.target[pin];
            for (int a = 0; a < 3; ++a) {
                if ((physics::held_axes(pins, pin) >> a & 1) == 0) miss[a] = 0;
            }
            off |= miss.norm() > visible * cubes[i]->size;
        }
        first = end;
        if (!off || i >= bodies.size() || !bodies[i].rigid) continue;
        out.push_back(fmt::format(
            "rigid body {} is not where its pins ask it to be: they, or pins and what it touches, "
            "ask for another shape or place than it can take. Pin one region of it, give its pins "
            "one motion, or set `rigid` = false{}",
            i,
            state.report.step_error > visible
                ? ". Steps that are too long do so, too: raise step.substeps; where it is 0, lower "
                  "step.error"
                : ""));
    }
    return out;
}

}  // namespace nodes::simulate
