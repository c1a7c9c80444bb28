#pragma once

// What the tests of skeletons share: random places, and a field's derivatives against differences.

#include "geometry/base/random.hpp"
#include "geometry/fields/field.hpp"

#include <gtest/gtest.h>

namespace geometry::field_checks {

inline Vec3 in_cube(const Random& random, std::uint64_t i, double half)
{
    return half * Vec3(2 * random.unit(3 * i) - 1, 2 * random.unit(3 * i + 1) - 1,
                       2 * random.unit(3 * i + 2) - 1);
}

// Gives each of these that is drawn by points a stretch of its own.
inline std::vector<Skeleton> stretched(std::vector<Skeleton> skeletons)
{
    for (std::size_t i = 0; i < skeletons.size(); ++i) {
        if (!has_points(skeletons[i].kind)) continue;
        const double along = 1 + 0.3 * static_cast<double>(i);
        const Mat3 axes = Eigen::AngleAxisd(along, Vec3(1, -2, 0.5 * along).normalized()).matrix();
        skeletons[i].stretch = axes * Vec3(1, along + 0.5, 1.4).asDiagonal() * axes.transpose();
    }
    return skeletons;
}

// Of 200 places in a cube, those where no crease of the distance is near.
struct Places {
    std::uint64_t seed;
    double half;           // of the cube
    double crease;         // Hessians that differ by more have a crease between them
    double hessian_error;  // of the differences, relative
};

// Checks each skeleton's gradient and Hessian against central differences.
inline void expect_derivatives(const Field& field, const Places& places)
{
    const Random random(places.seed);
    const double h = 1e-5;
    for (std::size_t s = 0; s < field.count(); ++s) {
        int smooth = 0;
        for (std::uint64_t i = 0; i < 200; ++i) {
            const Vec3 p = in_cube(random, i, places.half);
            const Foot at = foot(field, s, p);
            Vec3 gradient;
            Mat3 hessian;
            bool one_feature = std::abs(at.r) > 0.05;  // all within h share their nearest feature
            for (int axis = 0; axis < 3; ++axis) {
                const Foot a = foot(field, s, p - h * Vec3::Unit(axis));
                const Foot b = foot(field, s, p + h * Vec3::Unit(axis));
                gradient[axis] = (b.r - a.r) / (2 * h);
                hessian.col(axis) = (b.n - a.n) / (2 * h);
                one_feature &= (a.hessian - b.hessian).cwiseAbs().maxCoeff() < places.crease;
            }
            if (!one_feature) continue;
            ++smooth;
            EXPECT_LT((gradient - at.n).norm(), 1e-6) << "skeleton " << s;
            EXPECT_LT((hessian - at.hessian).norm(), places.hessian_error * (1 + hessian.norm()))
                << "skeleton " << s;
            if (stretch_of(field, s)) {
                EXPECT_LE(at.n.norm(), 1 + 1e-13);
                EXPECT_GE(at.n.norm(), 1 / field.stretch[s].most - 1e-13);
            } else {
                EXPECT_NEAR(at.n.norm(), 1, 1e-13);
            }
        }
        EXPECT_GT(smooth, 100) << "skeleton " << s;
    }
}

}  // namespace geometry::field_checks
