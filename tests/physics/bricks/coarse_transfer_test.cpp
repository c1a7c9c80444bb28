// Against the motions of nodes and corners as they are defined, and the transpose of that.

#include "physics/bricks/coarse_transfer.hpp"

#include "geometry/base/random.hpp"
#include "physics/bricks/coarse_energy.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace {

using namespace physics;
using Eigen::Index;
using Eigen::VectorXd;

constexpr double rounding = 3e-6;  // of single precision, in numbers up to 1

std::vector<float> numbers(std::size_t n, std::uint64_t seed)
{
    const geometry::Random random(seed);
    std::vector<float> out(n);
    for (std::size_t i = 0; i < n; ++i) out[i] = static_cast<float>(random.unit(i) - 0.5);
    return out;
}

double dot(const std::vector<float>& a, const std::vector<float>& b)
{
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

// Cubes at random places, where lines have gaps.
struct Coarse {
    explicit Coarse(int ratio)
        : cubes(fixtures::blob(1, 300, 0.5)),
          grid(coarsen({cubes.cell, cubes.corners, cubes.corner}, ratio)),
          motions(numbers(6 * grid.node.size(), 1)), slot(cubes.corner_count())
    {
        // Slots in another order than corners.
        for (std::size_t k = 0; k < slot.size(); ++k) {
            slot[k] = static_cast<std::uint32_t>(slot.size() - 1 - k);
        }
    }

    // 6: how the corners of each coarse cell that are its own move and turn.
    template <class Visit> void for_corners(const Visit& visit) const
    {
        for (std::size_t c = 0; c < grid.cell.size(); ++c) {
            VectorXd nodes(48);
            for (std::size_t i = 0; i < 48; ++i) {
                nodes[Index(i)] = double(motions[6 * std::size_t{grid.nodes[c][i / 6]} + i % 6]);
            }
            for (const auto k : grid.corners.of(c)) {
                const auto motion = corner_motion(
                    place_in_cell(cubes.corner[k], grid.cell[c], grid.ratio), grid.ratio);
                const Eigen::Vector3d moved = motion * nodes;
                Eigen::Vector3d turned = Eigen::Vector3d::Zero();
                for (Index a = 0; a < 8; ++a) {
                    turned += motion.middleCols<3>(6 * a) * nodes.segment<3>(6 * a + 3);
                }
                visit(k, moved, turned);
            }
        }
    }

    geometry::Cubes cubes;
    CoarseGrid grid;
    std::vector<float> motions;
    std::vector<std::uint32_t> slot;
};

// Of each corner, rows of a rotation with a fourth number of 0.
std::vector<float> rotations(std::size_t count)
{
    const auto random = numbers(4 * count, 2);
    std::vector<float> out(12 * count, 0);
    for (std::size_t k = 0; k < count; ++k) {
        const Eigen::Quaternionf q =
            Eigen::Quaternionf(random[4 * k], random[4 * k + 1], random[4 * k + 2], 1).normalized();
        const Eigen::Matrix3f m = q.toRotationMatrix();
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t i = 0; i < 3; ++i) out[12 * k + 4 * i + j] = m(Index(i), Index(j));
        }
    }
    return out;
}

TEST(CoarseTransfer, CornersMoveAsTheirNodesDo)
{
    for (const int ratio : {2, 4}) {
        const Coarse of(ratio);
        const auto turns = rotations(of.slot.size());
        for (const bool turned : {false, true}) {
            std::vector<float> z(4 * of.slot.size(), 0);
            prolong_corners(of.grid, of.cubes.corner, of.motions.data(), of.slot.data(),
                            turned ? turns.data() : nullptr, z.data());
            of.for_corners([&](std::uint32_t k, Eigen::Vector3d moved, const Eigen::Vector3d&) {
                const float* const m = &turns[12 * std::size_t{k}];
                const float* const found = &z[4 * std::size_t{of.slot[k]}];
                const Eigen::Vector3d t = moved;
                for (Index i = 0; i < 3 && turned; ++i) {
                    const float* const row = m + 4 * i;
                    moved[i] =
                        double(row[0]) * t[0] + double(row[1]) * t[1] + double(row[2]) * t[2];
                }
                for (Index i = 0; i < 3; ++i) EXPECT_NEAR(double(found[i]), moved[i], rounding);
                EXPECT_EQ(found[3], 0);
            });
        }
    }
}

TEST(CoarseTransfer, NodesMoveAndTurnAsCoarserOnesDo)
{
    const Coarse of(2);
    std::vector<float> d(6 * of.slot.size(), 7);
    auto z = numbers(d.size(), 5);
    const auto before = z;
    prolong_nodes(of.grid, of.cubes.corner, of.motions.data(), d.data(), z.data());
    of.for_corners([&](std::uint32_t k, const Eigen::Vector3d& moved,
                       const Eigen::Vector3d& turned) {
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t at = 6 * std::size_t{k} + i;
            EXPECT_NEAR(double(d[at]), moved[Index(i)], rounding);
            EXPECT_NEAR(double(d[at + 3]), 0.5 * turned[Index(i)], rounding);  // in its own cells
            EXPECT_FLOAT_EQ(z[at], before[at] + d[at]);
        }
    });
}

// f . P m = P^T f . m
TEST(CoarseTransfer, ForcesOnNodesAreThoseOfTheTranspose)
{
    for (const int ratio : {2, 4}) {
        const Coarse of(ratio);
        const auto turns = rotations(of.slot.size());
        Aligned<float> room, by_node;
        const auto on_nodes = [&] { return std::vector<float>(by_node.begin(), by_node.end()); };
        for (const CornerTurns turned : {CornerTurns{nullptr}, CornerTurns{turns.data()}}) {
            auto force = numbers(4 * of.slot.size(), 3);
            for (std::size_t k = 0; k < of.slot.size(); ++k) force[4 * k + 3] = 0;
            std::vector<float> z(force.size(), 0);
            prolong_corners(of.grid, of.cubes.corner, of.motions.data(), of.slot.data(), turned,
                            z.data());
            restrict_corners(of.grid, of.cubes.corner, force.data(), of.slot.data(), turned, room,
                             by_node);
            EXPECT_NEAR(dot(force, z), dot(on_nodes(), of.motions), 1e-4);
        }
        const auto force = numbers(6 * of.slot.size(), 4);
        std::vector<float> d(force.size(), 0), z(d);
        prolong_nodes(of.grid, of.cubes.corner, of.motions.data(), d.data(), z.data());
        restrict_nodes(of.grid, of.cubes.corner, force.data(), room, by_node);
        EXPECT_NEAR(dot(force, d), dot(on_nodes(), of.motions), 1e-4);
    }
}

}  // namespace
