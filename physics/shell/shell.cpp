#include "physics/shell/shell.hpp"

#include "physics/bricks/time_step.hpp"
#include "physics/shell/shell_elasticity.hpp"
#include "physics/shell/triangle_elasticity.hpp"
#include "physics/state/pins.hpp"

namespace physics {

State advance(const ShellBody& body, State state, const Loads& loads, double dt,
              const StepOptions& options)
{
    check_pins(loads.pins, body.base.corners);
    require_all_axes(loads.pins, "method shell");
    require_corners(loads.pins, "method shell");
    if (body.triangles) {
        TriangleElasticity elasticity(body, loads.pins);
        if (state.plastic_of == PlasticOf::triangles) elasticity.load_plastic(state.plastic);
        state = advance_implicitly(body.base, elasticity, std::move(state), loads, dt, options);
        state.plastic = elasticity.plastic();
        state.plastic_strain = elasticity.plastic_strain();
        state.plastic_of = state.plastic.empty() ? PlasticOf::nothing : PlasticOf::triangles;
        return state;
    }
    ShellElasticity elasticity(body, loads.pins);
    return advance_implicitly(body.base, elasticity, std::move(state), loads, dt, options);
}

}  // namespace physics
