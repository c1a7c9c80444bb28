#include "physics/bricks/elastic_energy.hpp"

#include "physics/bricks/brick_elasticity.hpp"

namespace physics {

double elastic_energy(const BricksBody& body, const State& state)
{
    BrickElasticity elasticity(body);
    elasticity.load_rotations(state.rotation);
    if (state.plastic_of == PlasticOf::bricks) elasticity.load_plastic(state.plastic);
    return elasticity.energy(by_slot(body.base, state.x).data());
}

}  // namespace physics
