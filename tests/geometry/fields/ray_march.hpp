#pragma once

// Rays by brute force, for tests: the field asked at so many places of the ray that hardly anything
// fits between them.

#include "geometry/base/random.hpp"
#include "geometry/fields/iso_rays.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

namespace geometry::ray_march {

inline double value(const IsoField& field, const Vec3& p)
{
    FieldBlock block;
    BlockValues values;
    block.add(p);
    block.pad();
    field.ask(block, values);
    return values.f[0];
}

// The first change of sign between begin and end, looked for at `steps` places and then halved.
// Infinite where there is none.
inline double first_root(const IsoField& field, const Ray& ray, int steps)
{
    FieldBlock block;
    BlockValues values;
    const double dt = (ray.end - ray.begin) / steps;
    const auto at = [&](double t) { return Vec3(ray.origin + t * ray.direction); };
    const bool inside = value(field, at(ray.begin)) >= 0;
    for (int i = 1; i <= steps; i += static_cast<int>(block.count)) {
        block.count = 0;
        for (int k = i; k <= steps && block.count < FieldBlock::capacity; ++k) {
            block.add(at(ray.begin + k * dt));
        }
        block.pad();
        field.ask(block, values);
        for (std::size_t k = 0; k < block.count; ++k) {
            if ((values.f[k] >= 0) == inside) continue;
            double high = ray.begin + (i + static_cast<int>(k)) * dt, low = high - dt;
            for (int halving = 0; halving < 45; ++halving) {
                const double middle = 0.5 * (low + high);
                ((value(field, at(middle)) >= 0) == inside ? low : high) = middle;
            }
            return high;
        }
    }
    return std::numeric_limits<double>::infinity();
}

inline Vec3 unit_vector(const Random& random, std::uint64_t i)
{
    const double z = 2 * random.unit(2 * i) - 1, a = 2 * std::numbers::pi * random.unit(2 * i + 1);
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(a), r * std::sin(a), z};
}

// Rays from a sphere about `box` to places in it, and their ends beyond it.
inline std::vector<Ray> rays_at(const Box& box, std::size_t count, std::uint64_t seed)
{
    const Random random(seed);
    std::vector<Ray> rays(count);
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3 from = box.centre() + box.diagonal() * unit_vector(random, i);
        const Vec3 share(random.unit(7 * i + 100), random.unit(7 * i + 101),
                         random.unit(7 * i + 102));
        const Vec3 to = box.lo + box.size().cwiseProduct(share);
        rays[i] = {from, (to - from).normalized(), 0, 2.5 * box.diagonal()};
    }
    return rays;
}

// Sees that trace() misses nothing that brute force finds and finds nothing behind it; that what it
// alone finds, between two steps of brute force, is on the surface. How many rays hit.
inline int expect_as_brute_force(const IsoField& field, std::span<const Ray> rays, int steps,
                                 double tolerance)
{
    const IsoCells cells = iso_cells(field);
    std::vector<RayHit> hits(rays.size());
    trace(field, cells, rays, tolerance, hits);
    int found = 0, alone = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const double brute = first_root(field, rays[i], steps);
        const double step = (rays[i].end - rays[i].begin) / steps;
        found += hits[i].there();
        EXPECT_LE(hits[i].t, brute + 2 * tolerance) << "ray " << i;
        if (!(hits[i].t < brute - 2 * tolerance)) continue;
        ++alone;
        const auto at = [&](double t) {
            return value(field, rays[i].origin + t * rays[i].direction);
        };
        EXPECT_NEAR(at(hits[i].t), 0, 30 * tolerance) << "ray " << i;
        EXPECT_LT(at(hits[i].t + 2 * step), 0) << "ray " << i << ": no sliver, but a wall";
    }
    EXPECT_LE(alone, static_cast<int>(rays.size()) / 100) << "slivers between two steps are rare";
    return found;
}

}  // namespace geometry::ray_march
