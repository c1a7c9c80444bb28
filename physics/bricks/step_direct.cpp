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

// What a contact adds to A, by the corners that carry it: all that is not rigid.
struct ContactElement {
    std::array<std::uint32_t, PointContact::most> corner{};
    std::array<double, PointContact::most> weight{};
    std::size_t count = 0;
};

ContactElement element_of(const Stage& stage, const PointContact& contact)
{
    ContactElement out;
    for (std::size_t i = 0; i < contact.count; ++i) {
        const auto k = contact.corners[i];
        if (contact.weight[i] == 0 || stage.rigid.of_corner(k) != RigidBodies::not_rigid) continue;
        const auto last = out.corner.begin() + std::ptrdiff_t(out.count);
        const auto found = std::find(out.corner.begin(), last, k);
        const auto at = std::size_t(found - out.corner.begin());
        if (found == last) out.corner[out.count++] = k;
        out.weight[at] += double(contact.weight[i]);
    }
    return out;
}

// Adds the corners begin .. begin + 4 and then .. then + 4 of an element, and the blocks between
// both; of each with itself where that is asked for.
void add_fours(const ContactElement& element, const geometry::Mat3& block, std::size_t begin,
               std::size_t then, std::array<bool, 2> own, ElementCorners& elements,
               std::vector<BrickMatrix>& matrices)
{
    constexpr std::size_t four = 4;
    auto& corners = elements.emplace_back();
    corners.fill(element.corner[begin]);
    BrickMatrix& matrix = matrices.emplace_back(BrickMatrix::Zero());
    const auto at = [&](std::size_t i) { return i < four ? begin + i : then + i - four; };
    for (std::size_t i = 0; i < 2 * four; ++i) {
        if (at(i) >= element.count) continue;
        corners[i] = element.corner[at(i)];
        for (std::size_t j = 0; j < 2 * four; ++j) {
            if (at(j) >= element.count) continue;
            if (i / four == j / four && !own[i / four]) continue;
            matrix.block<3, 3>(Eigen::Index(3 * i), Eigen::Index(3 * j)) =
                element.weight[at(i)] * element.weight[at(j)] * block;
        }
    }
}

// One element of eight corners, or one for each pair of four of them.
void add_element(const ContactElement& element, const geometry::Mat3& block,
                 ElementCorners& elements, std::vector<BrickMatrix>& matrices)
{
    const std::size_t n = element.count;
    if (n == 0) return;
    if (n <= 4) return add_fours(element, block, 0, n, {true, false}, elements, matrices);
    for (std::size_t a = 0; a < n; a += 4) {
        for (std::size_t b = a + 4; b < n; b += 4) {  // each with itself once
            const std::array<bool, 2> own{b == a + 4, b == a + 4 && b + 4 >= n};
            add_fours(element, block, a, b, own, elements, matrices);
        }
    }
}

// Whether a contact is an element of its own: of sheets, and beside sheets of all.
bool is_element(const Stage& stage, const PointContact& contact)
{
    constexpr std::uint32_t between_sheets = 12;  // corners
    return contact.count == between_sheets || (contact.count > 8 && stage.frame.body.solids);
}

// Corners that the factor leaves out, sorted: those that are held, and those of rigid parts, which
// are solved beside it.
std::vector<std::uint32_t> left_out(const Stage& stage)
{
    std::vector<std::uint32_t> out = stage.frame.held.whole;
    if (stage.rigid.none()) return out;
    const CornerBody& body = stage.frame.body;
    for (std::uint32_t k = 0; k < body.corners; ++k) {
        const auto slot = static_cast<std::uint32_t>(body.slot_of(k));
        if (stage.rigid.of_corner(slot) != RigidBodies::not_rigid) out.push_back(k);
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

// Of a contact with a rigid part, what it has of an elastic one: it stands there as one with a
// collider. Nothing of others.
std::optional<PointContact> elastic_side(const Stage& stage, const PointContact& contact)
{
    std::array<bool, 2> rigid{};
    for (std::size_t side = 0; side < 2; ++side) {
        if (8 * side >= contact.count) return std::nullopt;
        rigid[side] = stage.rigid.of_corner(contact.corners[8 * side]) != RigidBodies::not_rigid;
    }
    if (rigid[0] == rigid[1]) return std::nullopt;
    PointContact out = contact;
    out.count = 8;
    if (!rigid[0]) return out;
    for (std::size_t a = 0; a < 8; ++a) {
        const bool has = 8 + a < contact.count;
        out.corners[a] = contact.corners[has ? 8 + a : 8];
        out.weight[a] = has ? contact.weight[8 + a] : 0;
    }
    return out;
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
    tree = stage.elasticity.dissection(left_out(stage));
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
    const std::size_t own = cubes.size();
    ElementCorners joined;
    for (const PointContact& c : stage.contacts) {
        const geometry::Mat3 block = block_of(stage, c);
        if (const auto side = elastic_side(stage, c)) {
            stage.elasticity.add_contact(*side, block, cubes);
        } else if (is_element(stage, c)) {
            add_element(element_of(stage, c), block, joined, cubes);
        } else {
            stage.elasticity.add_contact(c, block, cubes);
        }
    }
    std::shared_ptr<const Dissection> order = tree;
    if (!joined.empty()) {
        order = stage.elasticity.dissection_with(left_out(stage), joined, stage.x.data());
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
