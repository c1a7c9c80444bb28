#include "physics/math/corner_vectors.hpp"

#include "geometry/base/random.hpp"
#include "physics/math/aligned_memory.hpp"
#include "physics/math/dense_columns.hpp"
#include "tests/physics/every_target.hpp"

#include <tbb/global_control.h>

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace physics;

Aligned<float> noise(std::size_t n, std::uint64_t seed)
{
    const geometry::Random random(seed);
    Aligned<float> out(n, 0);
    for (std::size_t i = 0; i < n; ++i) out[i] = static_cast<float>(random.unit(i) - 0.5);
    return out;
}

// Every kernel on vectors of n numbers, as one list of results.
std::vector<double> everything(std::size_t n)
{
    auto a = noise(n, 1), b = noise(n, 2), c = noise(n, 3), x = noise(n, 4), r = noise(n, 5);
    Aligned<float> z(n, 0);
    std::vector<double> out;
    out.push_back(add_diagonal_times(n, a.data(), b.data(), c.data()));
    out.push_back(descend(n, 0.3f, a.data(), b.data(), c.data(), x.data(), r.data(), z.data()));
    out.push_back(dot(n, r.data(), z.data()));
    turn_direction(n, 0.7f, z.data(), a.data());
    Aligned<float> y(32, 0.0f), dots(n / 32, 0);
    add_columns(32, n / 32, b.data(), c.data(), y.data());
    column_dots(32, n / 32, b.data(), y.data(), dots.data());
    for (const auto* v : {&a, &c, &x, &r, &z, &y, &dots}) {
        for (std::size_t i = 0; i < v->size(); i += 7) out.push_back(double((*v)[i]));
    }
    return out;
}

TEST(CornerVectors, SumsAreThoseOfPlainLoops)
{
    const std::size_t n = 16 * 1000;
    const auto d = noise(n, 1), p = noise(n, 2), y0 = noise(n, 3);
    auto y = y0;
    double expected = 0, size = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const double term = double(p[i]) * (double(y0[i]) + double(d[i]) * double(p[i]));
        expected += term;
        size += std::abs(term);
    }
    // Runs of 256 terms a lane in single precision.
    EXPECT_NEAR(add_diagonal_times(n, d.data(), p.data(), y.data()), expected, 256 * 6e-8 * size);
    EXPECT_FLOAT_EQ(y[77], y0[77] + d[77] * p[77]);
}

TEST(CornerVectors, EveryProcessorAndAnyNumberOfThreadsGivesTheSameBits)
{
    for (const std::size_t n :
         {std::size_t{64}, std::size_t{1600}, std::size_t{300'000} / 32 * 32}) {
        const auto expected = everything(n);
        for (const std::size_t threads : {1u, 2u, 8u}) {
            const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
            EXPECT_EQ(everything(n), expected);
        }
        on_every_target([&](const char* target) { EXPECT_EQ(everything(n), expected) << target; });
    }
}

}  // namespace
