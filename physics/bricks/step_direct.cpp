#include "physics/bricks/step_direct.hpp"

namespace physics {

// Measured on one thread, in ns. The matrices of cubes and the fronts count as much as the products
// of 3 x 3 blocks where bodies are thin.
void StepDirect::count(const Stage& stage)
{
    constexpr double block_product = 27 * 0.15, front = 2200, cube = 2000, entry = 9 * 0.8;
    constexpr double multiplied_cube = 16, iteration = 2;  // products, without the factor
    if (tree) return;
    tree = stage.elasticity.dissection(stage.frame.held.whole);
    if (!tree) return;
    const auto cubes_there = static_cast<double>(stage.elasticity.cube_count());
    const double a_product = multiplied_cube * cubes_there * stage.elasticity.product_work();
    const double fronts = front * static_cast<double>(tree->fronts.size());
    work = (block_product * tree->products + fronts + cube * cubes_there) / a_product;
    work_an_iteration = iteration + entry * tree->entries / a_product;
}

bool StepDirect::serves(const Stage& stage) const
{
    return factor && tau == stage.tau && hessian == stage.elasticity.uses_hessian();
}

bool StepDirect::make(const Stage& stage, const Aligned<double>& lumped)
{
    factor.reset();
    if (!stage.elasticity.cube_matrices(cubes)) return false;
    for (const PointContact& c : stage.contacts) {
        std::array<double, 6> s{};
        for (std::size_t i = 0; i < 6; ++i) {
            s[i] = stage.tau * (stage.tau * c.stiffness[i] + c.drag[i]);
        }
        geometry::Mat3 block;
        block << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
        stage.elasticity.add_contact(c, block, cubes);
    }
    tau = stage.tau, hessian = stage.elasticity.uses_hessian();
    const HeldCorners& held = stage.frame.held;
    std::vector<std::uint8_t> axes;
    if (!held.along.empty()) axes = axes_by_corner(held, stage.frame.body.corners);
    factor = DirectFactor::make(tree, cubes, lumped, stage.frame.body.slot, axes);
    return factor.has_value();
}

}  // namespace physics
