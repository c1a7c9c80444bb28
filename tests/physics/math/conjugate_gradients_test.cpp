#include "physics/math/conjugate_gradients.hpp"

#include <gtest/gtest.h>

namespace {

using namespace physics;

constexpr std::size_t n = 64;

// K of a chain of springs between 64 numbers, D = 0.01.
LinearSystem<float> chain()
{
    LinearSystem<float> system;
    system.numbers = system.room = n;
    system.diagonal.assign(n, 0.01f);
    system.inverse.assign(n, 1 / 2.01f);
    system.multiply = [](const float* p, float* y) {
        for (std::size_t i = 0; i < n; ++i) {
            const float before = i > 0 ? p[i - 1] : 0, after = i + 1 < n ? p[i + 1] : 0;
            y[i] = 2 * p[i] - before - after;
        }
    };
    return system;
}

// The largest part of r = 1 that A x leaves over.
double left_over(const LinearSystem<float>& system, const Aligned<float>& x)
{
    Aligned<float> y(n, 0);
    system.multiply(x.data(), y.data());
    double worst = 0;
    for (std::size_t i = 0; i < n; ++i) {
        worst = std::max(worst, std::abs(1.0 - double(y[i]) - 0.01 * double(x[i])));
    }
    return worst;
}

TEST(ConjugateGradients, APreconditionerThatIsNotPositiveIsLeftAlone)
{
    LinearSystem<float> system = chain();
    for (const float sign : {1.0f, -1.0f}) {
        system.precondition = [sign](const float* r, float* z) {
            for (std::size_t i = 0; i < n; ++i) z[i] = sign * r[i];
        };
        ConjugateVectors<float> work;
        work.r.assign(n, 1);
        const Solved solved = conjugate_gradients(system, 1e-4, 500, work);
        EXPECT_TRUE(solved.converged) << sign << ' ' << solved.residual;
        EXPECT_LT(left_over(system, work.x), 1e-3) << sign;
    }
}

}  // namespace
