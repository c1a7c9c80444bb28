#pragma once

// Preconditioned conjugate gradients: solves A x = r over the corners of a body, for A = D + K with
// K known only by its products. Hestenes, Stiefel. Methods of conjugate gradients for solving
// linear systems. 1952.

#include "physics/math/aligned_memory.hpp"
#include "physics/math/corner_vectors.hpp"
#include "physics/math/for_numbers.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

namespace physics {

// A corner whose preconditioner is a full symmetric block, xx xy xz yy yz zz.
template <class T> struct CornerBlock {
    std::uint32_t slot = 0;
    std::array<T, 6> inverse{};

    // z = inverse r. Returns r . z.
    double apply(const T* r, T* z) const
    {
        const T *a = r + 4 * std::size_t{slot}, *b = inverse.data();
        T* out = z + 4 * std::size_t{slot};
        out[0] = b[0] * a[0] + b[1] * a[1] + b[2] * a[2];
        out[1] = b[1] * a[0] + b[3] * a[1] + b[4] * a[2];
        out[2] = b[2] * a[0] + b[4] * a[1] + b[5] * a[2];
        return static_cast<double>(a[0] * out[0] + a[1] * out[1] + a[2] * out[2]);
    }
};

template <class T> struct LinearSystem {
    std::size_t numbers = 0;                         // length of every vector, a multiple of 16
    std::function<void(const T* p, T* y)> multiply;  // y = K p; may write beyond `numbers`
    std::size_t room = 0;                            // length of y, >= numbers
    Aligned<T> diagonal;                             // D
    Aligned<T> inverse;                              // of the diagonal of A; 0 holds a number as is
    std::vector<CornerBlock<T>> blocks;              // where `inverse` is 0 for all three
    // z = about A^-1 r, symmetric and positive, 0 where numbers are held. None, and once r . z is
    // not positive: the diagonal's inverse and the blocks.
    std::function<void(const T* r, T* z)> precondition = {};
};

struct Solved {
    bool converged = true;
    int iterations = 0;
    double residual = 0;  // sqrt(r . D^-1 r), D the diagonal of A with its blocks
};

// Vectors that a solve works in; kept between solves.
template <class T> struct ConjugateVectors {
    Aligned<T> x, r, z, p, y;
};

// Solves A x = r from x = 0 until sqrt(r . D^-1 r) <= target or `limit` iterations. `work.r` holds
// the right-hand side on entry, work.x the solution on return.
template <class T>
Solved conjugate_gradients(const LinearSystem<T>& system, double target, int limit,
                           ConjugateVectors<T>& work)
{
    const std::size_t n = system.numbers;
    auto &x = work.x, &r = work.r, &z = work.z, &p = work.p, &y = work.y;
    for (Aligned<T>* v : {&x, &z, &p}) fill_numbers(*v, n, T{0});
    fill_numbers(y, system.room, T{0});
    const auto step = [&](T alpha) {
        double sum = descend(n, alpha, p.data(), y.data(), system.inverse.data(), x.data(),
                             r.data(), z.data());
        for (const auto& block : system.blocks) sum += block.apply(r.data(), z.data());
        return sum;
    };
    double size_sq = step(0), rz = 0;
    bool preconditions = system.precondition != nullptr;
    Solved out;
    while (std::sqrt(size_sq) > target && out.iterations < limit) {
        double before = rz;
        rz = size_sq;
        if (preconditions) {
            system.precondition(r.data(), z.data());
            rz = dot(n, r.data(), z.data());
        }
        if (!(rz > 0)) preconditions = false, rz = step(0), before = 0;
        turn_direction(n, static_cast<T>(before > 0 ? rz / before : 0), z.data(), p.data());
        system.multiply(p.data(), y.data());
        const double py = add_diagonal_times(n, system.diagonal.data(), p.data(), y.data());
        if (!(py > 0) || !std::isfinite(py)) break;
        size_sq = step(static_cast<T>(rz / py));
        ++out.iterations;
    }
    out.residual = std::sqrt(size_sq);
    out.converged = out.residual <= target;
    return out;
}

}  // namespace physics
