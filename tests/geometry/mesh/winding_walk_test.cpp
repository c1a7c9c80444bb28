#include "geometry/mesh/winding_walk.hpp"

#include "geometry/base/random.hpp"
#include "geometry/mesh/mesh.hpp"
#include "tests/geometry/test_meshes.hpp"

#include <gtest/gtest.h>

using geometry::Random;
using geometry::TriangleBvh;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::WindingWalk;

// A sphere with a box named twice in it, and a box that faces inward across its side.
TEST(WindingWalk, IsInsideWhereTheWindingNumberIs)
{
    using test_meshes::both, test_meshes::box;
    const TriMesh inner = box({0.2, 0.1, 0.3}, {0.7, 0.9, 0.8});
    const TriMesh inward = test_meshes::inside_out(box({-1.3, -0.2, -0.4}, {-0.6, 0.5, 0.2}));
    const TriangleBvh tree(both(both(test_meshes::bumpy_sphere(3), inward), both(inner, inner)));
    const Random random(5);
    std::uint64_t draw = 0;
    WindingWalk walk(tree, 0.5);
    Vec3 at = Vec3::Zero();
    int inside = 0, changes = 0;
    bool before = false;
    for (int i = 0; i < 4000; ++i) {
        // Mostly short steps; now and then a long one, back into the middle.
        const double length = i % 50 == 0 ? 1.2 : 0.3;
        if (at.norm() > 1.3) at.setZero();
        for (double& c : at) c += length * (2 * random.unit(draw++) - 1);
        const double w = tree.winding_number(at);
        const bool now = walk.inside(at);
        if (std::abs(std::abs(w) - 0.5) > 0.02) {
            EXPECT_EQ(now, std::abs(w) > 0.5) << i << " " << w;
        }
        inside += now ? 1 : 0;
        changes += now != before ? 1 : 0;
        before = now;
    }
    EXPECT_GT(inside, 1000);
    EXPECT_GT(changes, 500);
}

TEST(WindingWalk, GoesOnFromAPlaceOnAFace)
{
    const TriangleBvh cube(test_meshes::box({0, 0, 0}, {1, 1, 1}));
    WindingWalk walk(cube, 10);
    EXPECT_TRUE(walk.inside({0.3, 0.6, 0.5}));
    walk.inside({0.3, 0.6, 1});  // on a face
    EXPECT_FALSE(walk.inside({0.3, 0.6, 1.5}));
    walk.inside({0.3, 0.6, 1});
    EXPECT_TRUE(walk.inside({0.3, 0.6, 0.7}));
}
