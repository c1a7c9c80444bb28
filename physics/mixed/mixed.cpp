#include "physics/mixed/mixed.hpp"

#include "geometry/base/no_index.hpp"
#include "physics/bricks/brick_frame.hpp"
#include "physics/bricks/rigid_pins.hpp"
#include "physics/bricks/time_step.hpp"
#include "physics/mixed/mixed_elasticity.hpp"
#include "physics/shell/shell_elasticity.hpp"
#include "physics/shell/triangle_elasticity.hpp"
#include "physics/state/measure.hpp"
#include "physics/state/pins.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace physics {
namespace {

// Those between corners of solids, by their own numbers.
std::vector<JointPoint> joints_of(const MixedBody& body, std::vector<JointPoint> joints)
{
    if (joints.empty()) return joints;
    std::vector<std::uint32_t> number(body.base.corners, geometry::no_index);
    for (std::uint32_t i = 0; i < body.solid_corner.size(); ++i) number[body.solid_corner[i]] = i;
    for (JointPoint& joint : joints) {
        for (auto& corner : joint.corner) corner = number[corner];
    }
    std::erase_if(joints, [](const JointPoint& joint) {
        return std::find(joint.corner.begin(), joint.corner.end(), geometry::no_index) !=
               joint.corner.end();
    });
    return joints;
}

// Pins of one kind, by its own corners, cubes and points of the material.
Pins pins_of(const Pins& pins, const std::vector<std::uint32_t>& own, std::size_t corners,
             const std::vector<std::uint32_t>& own_cubes, std::size_t cubes)
{
    using geometry::no_index;
    const auto numbers = [](const std::vector<std::uint32_t>& of, std::size_t all) {
        std::vector<std::uint32_t> out(all, no_index);
        for (std::uint32_t i = 0; i < of.size(); ++i) out[of[i]] = i;
        return out;
    };
    const auto corner_of = numbers(own, corners), cube_of = numbers(own_cubes, cubes);
    Pins out;
    for (std::size_t p = 0; p < pins.corner.size(); ++p) {
        const std::uint32_t corner = corner_of[pins.corner[p]];
        if (corner == no_index) continue;
        out.corner.push_back(corner);
        out.target.push_back(pins.target[p]);
        out.pivot.push_back(pivot_of(pins.pivot, p));
        if (!pins.axes.empty()) out.axes.push_back(pins.axes[p]);
    }
    if (own_cubes.empty()) return out;  // of sheets, which hold no points
    out.matter = pins.matter;
    for (auto& corner : out.matter.corner) corner = corner_of[corner];
    for (auto& cube : out.matter.cubes) cube.cube = cube_of[cube.cube];
    return out;
}

void check_sheet_pins(const MixedBody& body, const Pins& pins)
{
    for (const auto corner : pins.matter.corner) {
        if (body.base.slot_of(corner) < body.bricks.base.corners) continue;
        throw std::invalid_argument("a pin holds points of a sheet: set its `hold` to corners");
    }
    for (std::size_t p = 0; p < pins.corner.size(); ++p) {
        if (body.base.slot_of(pins.corner[p]) < body.bricks.base.corners) continue;
        if (held_axes(pins, p) == all_axes) continue;
        throw std::invalid_argument(
            "a pin holds corners of a sheet along some axes: let it hold all three");
    }
}

// Puts what both kinds hold together: corners of all, in their order. Cubes stay those of solids.
Pins join_pins(const MixedBody& body, const Pins& solids, const Pins& sheets)
{
    struct One {
        std::uint32_t corner;
        Vec3 target;
        std::uint8_t axes;
        Vec3 pivot;
        bool operator<(const One& other) const { return corner < other.corner; }
    };
    std::vector<One> all;
    const auto add = [&](const Pins& pins, const std::vector<std::uint32_t>& corner_of) {
        for (std::size_t p = 0; p < pins.corner.size(); ++p) {
            all.push_back({corner_of[pins.corner[p]], pins.target[p], held_axes(pins, p),
                           pivot_of(pins.pivot, p)});
        }
    };
    add(solids, body.solid_corner);
    add(sheets, body.sheet_corner);
    std::sort(all.begin(), all.end());
    Pins out;
    out.matter = solids.matter;
    for (auto& corner : out.matter.corner) corner = body.solid_corner[corner];
    for (const One& one : all) {
        out.corner.push_back(one.corner);
        out.target.push_back(one.target);
        out.pivot.push_back(one.pivot);
        if (!solids.axes.empty()) out.axes.push_back(one.axes);
    }
    return out;
}

// Numbers of solids' cubes as those of all, `rows` each; `none` of the sheets'.
std::vector<float> of_all(const MixedBody& body, const std::vector<float>& solids, float none)
{
    if (solids.empty()) return {};
    const std::size_t rows = solids.size() / body.solid_cube.size();
    std::vector<float> out(rows * body.cubes, none);
    for (std::size_t i = 0; i < solids.size(); ++i) {
        out[rows * body.solid_cube[i / rows] + i % rows] = solids[i];
    }
    return out;
}

std::vector<float> of_solids(const MixedBody& body, const std::vector<float>& all)
{
    const std::size_t rows = all.size() / body.cubes;
    std::vector<float> out;
    for (const auto c : body.solid_cube) {
        const auto first = all.begin() + std::ptrdiff_t(rows * c);
        out.insert(out.end(), first, first + std::ptrdiff_t(rows));
    }
    return out;
}

// The part of a state that is of the solids.
State state_of_solids(const MixedBody& body, const State& state)
{
    State out;
    for (const auto k : body.solid_corner) {
        out.x.push_back(state.x[k]);
        out.v.push_back(state.v[k]);
    }
    out.rotation = state.rotation;
    out.plastic = of_solids(body, state.plastic);
    out.plastic_of = state.plastic_of;
    return out;
}

// What the end of a frame adds to the state of the solids.
void take_solids(const MixedBody& body, State solids, State& state)
{
    constexpr float unknown = std::numeric_limits<float>::quiet_NaN();
    state.stress = of_all(body, solids.stress, unknown);
    state.energy = of_all(body, solids.energy, unknown);
    state.rotation = std::move(solids.rotation);
    state.plastic = of_all(body, solids.plastic, 0);
    state.plastic_of = solids.plastic_of;
    state.plastic_strain = of_all(body, solids.plastic_strain, 0);
    for (auto& warning : solids.report.warnings) {
        state.report.warnings.push_back(std::move(warning));
    }
}

std::unique_ptr<Elasticity> elasticity_of(const ShellBody& body, const Pins& pins)
{
    if (body.triangles) return std::make_unique<TriangleElasticity>(body, pins);
    return std::make_unique<ShellElasticity>(body, pins);
}

}  // namespace

State advance(const MixedBody& body, State state, const Loads& loads, double dt,
              const StepOptions& options)
{
    check_pins(loads.pins, body.base.corners);
    check_sheet_pins(body, loads.pins);
    Pins solids =
        pins_of(loads.pins, body.solid_corner, body.base.corners, body.solid_cube, body.cubes);
    const Pins sheets = pins_of(loads.pins, body.sheet_corner, body.base.corners, {}, body.cubes);
    if (!body.base.rigid.empty()) {
        check_rigid(options);
        solids = with_rigid_pins(body.bricks, solids, dt, joints_of(body, loads.joints));
    }
    Loads own = loads;
    own.pins = join_pins(body, solids, sheets);
    const State began = state_of_solids(body, state);
    BrickElasticity bricks(body.bricks);
    begin_frame(body.bricks, began, solids, options, bricks);
    const auto shell = elasticity_of(body.shell, sheets);
    MixedElasticity both(body, bricks, *shell);
    state = advance_implicitly(body.base, both, std::move(state), own, dt, options);
    if (state.report.slept) return state;
    State ended = state_of_solids(body, state);
    end_frame(body.bricks, largest_speed(began), dt, options, bricks, ended);
    take_solids(body, std::move(ended), state);
    return state;
}

}  // namespace physics
