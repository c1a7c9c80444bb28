#include "physics/body/box_regions.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

namespace {

using geometry::Box;
using geometry::Vec3;

// Boxes of up to 1 m in 10 m, far from the origin, where single precision rounds.
TEST(BoxRegions, MeetAsOneByOne)
{
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(1000, 1010), side(0, 1);
    const auto some = [&] {
        Box box;
        box.add(Vec3(place(random), place(random), place(random)));
        box.add(Vec3(box.lo + Vec3(side(random), side(random), side(random))));
        return box;
    };
    for (const std::size_t count : {0u, 1u, 8u, 9u, 200u}) {
        std::vector<Box> boxes;
        for (std::size_t i = 0; i < count; ++i) boxes.push_back(some());
        const physics::BoxRegions regions(boxes);
        int met = 0;
        for (int i = 0; i < 500; ++i) {
            Box asked = some();
            if (count > 0 && i % 5 == 0) {  // that touches one in a plane
                const Box& one = boxes[std::size_t(i) % count];
                asked.lo.x() = one.hi.x(), asked.hi.x() = asked.lo.x() + 0.1;
            }
            bool expected = false;
            for (const Box& box : boxes) expected = expected || physics::overlap(box, asked);
            EXPECT_EQ(regions.meet(asked), expected);
            met += expected ? 1 : 0;
        }
        if (count == 200) {
            EXPECT_GT(met, 50);
        }
    }
}

TEST(BoxRegions, OneWithoutEndIsMetByAll)
{
    std::vector<Box> boxes(20);
    for (Box& box : boxes) box.add(Vec3(Vec3::Ones()));
    boxes[7].hi.x() = std::numeric_limits<double>::infinity();
    Box asked;
    asked.add(Vec3(Vec3(1e300, 1, 1)));
    EXPECT_TRUE(physics::BoxRegions(boxes).meet(asked));
}

}  // namespace
