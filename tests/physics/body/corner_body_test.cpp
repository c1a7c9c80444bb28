#include "physics/body/corner_body.hpp"

#include "geometry/cubes/components.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <numeric>

using namespace physics;
using geometry::Cubes;

namespace {

// 2 x 2 x 2 cubes, and 3 x 2 x 2 more that do not touch them; every third cube is damped.
Cubes two_boxes()
{
    std::vector<geometry::Vec3i> cells;
    for (int i = 0; i < 20; ++i) cells.emplace_back(i / 4 + (i < 8 ? 0 : 2), i / 2 % 2, i % 2);
    Cubes cubes = fixtures::cubes_on(cells, 0.1);
    for (std::size_t c = 0; c < cubes.count(); c += 3) cubes.mass_damping[c] = 1 + double(c);
    return cubes;
}

}  // namespace

TEST(CornerBody, KeepsMassPartAndPlaceOfEveryCornerByItsSlot)
{
    const Cubes cubes = two_boxes();
    const auto joined = geometry::find_components(cubes, geometry::Connectivity::corner);
    ASSERT_EQ(joined.count(), 2u);
    const std::size_t n = cubes.corner_count();
    std::vector<double> mass(n, 0), damping(n, 0);
    std::vector<std::uint32_t> part(n);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        for (const auto k : cubes.corners[c]) {
            mass[k] += cubes.mass[c] / 8;
            damping[k] += cubes.mass_damping[c] * cubes.mass[c] / 8;
            part[k] = joined.label[c];
        }
    }
    std::vector<std::uint32_t> turned(n);
    std::iota(turned.rbegin(), turned.rend(), 0u);
    for (const bool own : {true, false}) {
        const CornerBody body =
            make_corner_body(cubes, own ? std::vector<std::uint32_t>{} : turned, nullptr);
        for (std::size_t k = 0; k < n; ++k) {
            const std::size_t at = body.slot_of(k);
            ASSERT_EQ(at, own ? k : n - 1 - k);
            EXPECT_EQ(body.mass[at], mass[k]) << k;
            EXPECT_EQ(body.damping_of(at), damping[k]) << k;
            EXPECT_EQ(body.part_of(at), part[k]) << k;
            const geometry::Vec3 rest = cubes.corner_position(k);
            for (std::size_t d = 0; d < 3; ++d) {
                EXPECT_EQ(body.rest[4 * at + d], rest[Eigen::Index(d)]) << k;
            }
        }
    }
}

TEST(CornerBody, StoresNoArrayWhoseEntriesAreAllTheSame)
{
    const Cubes cubes = fixtures::box(3, 2, 2, 0.1);
    const CornerBody body = make_corner_body(cubes, {}, nullptr);
    EXPECT_TRUE(body.slot.empty() && body.mass_damping.empty() && body.part.empty());
    for (std::size_t k = 0; k < body.corners; ++k) {
        EXPECT_EQ(body.slot_of(k), k);
        EXPECT_EQ(body.damping_of(k), 0);
        EXPECT_EQ(body.part_of(k), 0u);
    }
}
