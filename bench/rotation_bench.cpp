// Rotations of 3x3 matrices: the batch kernel, warm and cold, against Eigen's decompositions.

#include "geometry/base/random.hpp"
#include "physics/math/rotation.hpp"

#include <benchmark/benchmark.h>

#include <vector>

namespace {

using geometry::Mat3;
using geometry::Vec3;

constexpr std::size_t count = 4096;  // fits the second-level cache: the arithmetic is what is timed

// Stretched by up to a third and turned; the last rotation is `off` rad away.
struct Matrices {
    std::vector<Mat3> each;
    std::vector<Eigen::Quaterniond> last;
};
Matrices deformed(double off)
{
    const geometry::Random random(1);
    Matrices m;
    for (std::size_t i = 0; i < count; ++i) {
        const auto r = [&](std::size_t k) { return 2 * random.unit(16 * i + k) - 1; };
        const Eigen::Quaterniond turn = Eigen::Quaterniond(r(0), r(1), r(2), r(3)).normalized();
        Mat3 e;
        for (std::size_t k = 0; k < 9; ++k) e(Eigen::Index(k)) = 0.3 * r(4 + k);
        m.each.push_back(turn * (Mat3::Identity() + 0.5 * (e + e.transpose())));
        m.last.push_back(turn * Eigen::AngleAxisd(off, Vec3(r(13), r(14), r(15) + 2).normalized()));
    }
    return m;
}

template <class T> void warm_started(benchmark::State& state, double off)
{
    const Matrices m = deformed(off);
    std::vector<T> a(9 * count), start(4 * count), q;
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < 9; ++k) {
            a[k * count + i] = T(m.each[i](Eigen::Index(k / 3), Eigen::Index(k % 3)));
        }
        const Eigen::Quaterniond& l = m.last[i];
        const double c[4] = {l.w(), l.x(), l.y(), l.z()};
        for (std::size_t k = 0; k < 4; ++k) start[k * count + i] = off < 4 ? T(c[k]) : T(0);
    }
    for (auto _ : state) {
        q = start;
        physics::extract_rotations(count, a.data(), count, q.data(), count);
        benchmark::DoNotOptimize(q.data());
    }
    state.SetItemsProcessed(state.iterations() * std::int64_t(count));
}

void in_float(benchmark::State& state, double off)
{
    warm_started<float>(state, off);
}

void in_double(benchmark::State& state, double off)
{
    warm_started<double>(state, off);
}

void jacobi_svd(benchmark::State& state)
{
    const Matrices m = deformed(0);
    for (auto _ : state) {
        for (const Mat3& a : m.each) {
            const Eigen::JacobiSVD<Mat3> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
            Mat3 r = svd.matrixU() * svd.matrixV().transpose();
            benchmark::DoNotOptimize(r);
        }
    }
    state.SetItemsProcessed(state.iterations() * std::int64_t(count));
}

}  // namespace

BENCHMARK_CAPTURE(in_float, off_by_0_01_rad, 0.01);
BENCHMARK_CAPTURE(in_float, off_by_0_2_rad, 0.2);
BENCHMARK_CAPTURE(in_float, cold, 4.0);
BENCHMARK_CAPTURE(in_double, off_by_0_01_rad, 0.01);
BENCHMARK_CAPTURE(in_double, off_by_0_2_rad, 0.2);
BENCHMARK_CAPTURE(in_double, cold, 4.0);
BENCHMARK(jacobi_svd);

BENCHMARK_MAIN();
