#include "physics/bricks/step_direct.hpp"

#include <algorithm>

namespace physics {
namespace {

geometry::Mat3 block_of(const Stage& stage, const PointContact& c)
{
    std::array<double, 6> s{};
    for (std::size_t i = 0; i < 6; ++i) {
        s[i] = stage.tau * (stage.tau * c.stiffness[i] + c.drag[i]);
    }
    geometry::Mat3 block;
    block << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
    return block;
}

// What a contact between sheets adds to A: an element of the corners that carry it.
void add_element(const PointContact& contact, const geometry::Mat3& block, ElementCorners& elements,
                 std::vector<BrickMatrix>& matrices)
{
    std::array<std::uint32_t, 8> corners{};
    std::array<double, 8> weight{};
    std::size_t count = 0;
    for (std::size_t i = 0; i < contact.count; ++i) {
        if (contact.weight[i] == 0) continue;
        const auto last = corners.begin() + std::ptrdiff_t(count);
        const auto found = std::find(corners.begin(), last, contact.corners[i]);
        const auto at = std::size_t(found - corners.begin());
        if (found == last && ++count > corners.size()) return;
        corners[at] = contact.corners[i];
        weight[at] += double(contact.weight[i]);
    }
    if (count == 0) return;
    std::fill(corners.begin() + std::ptrdiff_t(count), corners.end(), corners[0]);
    elements.push_back(corners);
    BrickMatrix& matrix = matrices.emplace_back(BrickMatrix::Zero());
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = 0; j < count; ++j) {
            matrix.block<3, 3>(Eigen::Index(3 * i), Eigen::Index(3 * j)) =
                weight[i] * weight[j] * block;
        }
    }
}

}  // namespace

// Measured on one thread, in ns. The matrices of cubes and the fronts count as much as the products
// of 3 x 3 blocks where bodies are thin.
void StepDirect::count(const Stage& stage)
{
    constexpr double block_product = 27 * 0.15, front = 2200, cube = 2000;
    constexpr double in_cache = 3e5;                       // entries
    constexpr double multiplied_cube = 16, iteration = 2;  // products, without the factor
    if (tree) return;
    tree = stage.elasticity.dissection(stage.frame.held.whole);
    if (!tree) return;
    const auto cubes_there = static_cast<double>(stage.elasticity.cube_count());
    const double a_product = multiplied_cube * cubes_there * stage.elasticity.product_work();
    const double fronts = front * static_cast<double>(tree->fronts.size());
    const double entry = 9 * (tree->entries < in_cache ? 0.8 : 2.2);
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
    constexpr std::uint32_t between_sheets = 12;  // corners
    const std::size_t own = cubes.size();
    ElementCorners joined;
    for (const PointContact& c : stage.contacts) {
        const geometry::Mat3 block = block_of(stage, c);
        if (c.count == between_sheets) {
            add_element(c, block, joined, cubes);
        } else {
            stage.elasticity.add_contact(c, block, cubes);
        }
    }
    std::shared_ptr<const Dissection> order = tree;
    if (!joined.empty()) {
        order = stage.elasticity.dissection_with(stage.frame.held.whole, joined, stage.x.data());
        if (!order) order = tree, cubes.resize(own);
    }
    tau = stage.tau, hessian = stage.elasticity.uses_hessian();
    const HeldCorners& held = stage.frame.held;
    std::vector<std::uint8_t> axes;
    if (!held.along.empty()) axes = axes_by_corner(held, stage.frame.body.corners);
    factor = DirectFactor::make(order, cubes, lumped, stage.frame.body.slot, axes);
    return factor.has_value();
}

}  // namespace physics
