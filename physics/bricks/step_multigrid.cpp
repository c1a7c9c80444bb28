#include "physics/bricks/step_multigrid.hpp"

#include "physics/math/for_numbers.hpp"

#include <algorithm>

namespace physics {
namespace {

// rest -= A change
void take_product(StepMultigrid& at, const LinearSystem<float>& system)
{
    system.multiply(at.change.data(), at.product.data());
    for_numbers(system.numbers, [&](std::size_t i) {
        at.rest[i] -= at.product[i] + system.diagonal[i] * at.change[i];
    });
}

// A step of the smoother: change = by_last change + by_rest D^-1 rest, z += change.
void take_step(StepMultigrid& at, const LinearSystem<float>& system, ChebyshevStep step, float* z)
{
    for_numbers(system.numbers, [&](std::size_t i) {
        at.change[i] = step.by_last * at.change[i] + step.by_rest * system.inverse[i] * at.rest[i];
        z[i] += at.change[i];
    });
    for (const auto& block : system.blocks) {
        const CornerBlock<float> at_zero{0, block.inverse};
        const std::size_t first = 4 * std::size_t{block.slot};
        float by_rest[3];
        at_zero.apply(&at.rest[first], by_rest);
        for (std::size_t i = 0; i < 3; ++i) {
            at.change[first + i] += step.by_rest * by_rest[i];
            z[first + i] += step.by_rest * by_rest[i];
        }
    }
    for (const auto i : at.held_along) at.change[i] = 0;
}

}  // namespace

// Measured in products until 1e-6 in blocks, full, filled at random and of stiffness ratio 1e6:
// degrees 1, 2, 3 take about as many where each has its best span; shorter spans take more.
void StepMultigrid::start(double largest)
{
    constexpr double span = 14;
    constexpr int degree = 2;
    smoother = chebyshev_steps(largest, span, degree);
}

void StepMultigrid::apply(const LinearSystem<float>& system, Elasticity& elasticity, const float* r,
                          float* z)
{
    const std::size_t n = system.numbers;
    rest.resize(n), change.resize(n), product.resize(system.room, 0);
    for_numbers(n, [&](std::size_t i) { rest[i] = r[i], change[i] = z[i] = 0; });
    for (std::size_t k = 0; k < smoother.size(); ++k) {
        if (k > 0) take_product(*this, system);
        take_step(*this, system, smoother[k], z);
    }
    take_product(*this, system);
    fill_numbers(change, n, 0.0f);
    for (const auto i : held_along) rest[i] = 0;
    elasticity.add_coarse(rest.data(), change.data());
    for (const auto i : held_along) change[i] = 0;
    for_numbers(n, [&](std::size_t i) { z[i] += change[i]; });
    for (const ChebyshevStep& step : smoother) {
        take_product(*this, system);
        take_step(*this, system, step, z);
    }
}

}  // namespace physics
