#pragma once

// Neighbouring points side by side, and the field's values at them: what the vectorised kernels
// read and write. One array a coordinate, so that a vector holds as many points as it has lanes.

#include "geometry/base/vec.hpp"

#include <algorithm>

namespace geometry {

// Up to `capacity` points side by side. Lanes from `count` up to the next multiple of 8 hold any
// finite number; kernels may read and write them.
struct FieldBlock {
    static constexpr std::size_t capacity = 256;
    std::size_t count = 0;
    alignas(64) double x[capacity], y[capacity], z[capacity];

    void add(const Vec3& p)
    {
        x[count] = p.x();
        y[count] = p.y();
        z[count] = p.z();
        ++count;
    }
    Vec3 point(std::size_t i) const { return {x[i], y[i], z[i]}; }
    // Repeats the last point up to a whole vector.
    void pad()
    {
        if (count == 0) return;
        for (std::size_t i = count; i < (count + 7) / 8 * 8; ++i) {
            x[i] = x[count - 1];
            y[i] = y[count - 1];
            z[i] = z[count - 1];
        }
    }
};

// A value and its gradient for each point of a block.
struct BlockValues {
    alignas(64) double f[FieldBlock::capacity], gx[FieldBlock::capacity], gy[FieldBlock::capacity],
        gz[FieldBlock::capacity];

    void clear(std::size_t n)
    {
        const std::size_t padded = (n + 7) / 8 * 8;
        for (double* a : {f, gx, gy, gz}) std::fill(a, a + padded, 0.0);
    }
    Vec3 gradient(std::size_t i) const { return {gx[i], gy[i], gz[i]}; }
};

}  // namespace geometry
