#include "physics/math/rotation.hpp"

#include "geometry/base/random.hpp"
#include "tests/physics/every_target.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <numbers>

using geometry::Mat3;
using geometry::Random;
using geometry::Vec3;
using physics::extract_rotation;

namespace {

Vec3 vector_in_cube(const Random& random, std::uint64_t i)
{
    return Vec3(random.unit(3 * i), random.unit(3 * i + 1), random.unit(3 * i + 2)) * 2 -
           Vec3::Ones();
}

Eigen::Quaterniond any_rotation(const Random& random, std::uint64_t i)
{
    const Vec3 a = vector_in_cube(random, 2 * i), b = vector_in_cube(random, 2 * i + 1);
    return Eigen::Quaterniond(a[0], a[1], a[2], b[0]).normalized();
}

Mat3 any_matrix(const Random& random, std::uint64_t i)
{
    Mat3 a;
    for (int j = 0; j < 3; ++j) a.col(j) = vector_in_cube(random, 3 * i + std::uint64_t(j));
    return a;
}

// By singular values: R = U diag(1, 1, det U V^T) V^T, and f = tr(R^T A) at it.
struct Polar {
    Mat3 rotation;
    double value;
    double gap;  // s2 + sign s3: how well the rotation is determined
};
Polar by_singular_values(const Mat3& a)
{
    const Eigen::JacobiSVD<Mat3> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
    const Vec3& s = svd.singularValues();
    return {svd.matrixU() * Vec3(1, 1, sign).asDiagonal() * svd.matrixV().transpose(),
            s[0] + s[1] + sign * s[2], s[1] + sign * s[2]};
}

double angle_between(const Mat3& a, const Mat3& b)
{
    return 2 * std::asin(std::min(1.0, (a - b).norm() / std::sqrt(8.0)));
}

template <class T> struct Batch {
    std::size_t n;
    std::vector<T> a, q;
    explicit Batch(std::size_t count) : n(count), a(9 * count), q(4 * count) {}
    void set(std::size_t i, const Mat3& m)
    {
        for (std::size_t k = 0; k < 9; ++k)
            a[k * n + i] = T(m(Eigen::Index(k / 3), Eigen::Index(k % 3)));
    }
    void warm(std::size_t i, const Eigen::Quaterniond& r)
    {
        const double c[4] = {r.w(), r.x(), r.y(), r.z()};
        for (std::size_t k = 0; k < 4; ++k) q[k * n + i] = T(c[k]);
    }
    void run() { physics::extract_rotations(n, a.data(), n, q.data(), n); }
    Eigen::Quaterniond quaternion(std::size_t i) const
    {
        return {double(q[i]), double(q[n + i]), double(q[2 * n + i]), double(q[3 * n + i])};
    }
    Mat3 rotation(std::size_t i) const { return quaternion(i).toRotationMatrix(); }
};

}  // namespace

TEST(Rotation, EqualsThatOfTheSingularValueDecomposition)
{
    // Cold started from the identity. Rounding moves R by about eps |A| / gap; |A| is a few units.
    const Random random(1);
    constexpr std::size_t n = 20'000;
    Batch<double> fine(n);
    Batch<float> coarse(n);
    std::vector<Polar> expected(n);
    for (std::size_t i = 0; i < n; ++i) {
        const Mat3 a = any_matrix(random, i).cast<float>().cast<double>();
        expected[i] = by_singular_values(a);
        fine.set(i, a);
        coarse.set(i, a);
    }
    fine.run();
    coarse.run();
    for (std::size_t i = 0; i < n; ++i) {
        if (expected[i].gap < 0.01) continue;
        ASSERT_LT(angle_between(fine.rotation(i), expected[i].rotation), 1e-13 / expected[i].gap);
        ASSERT_LT(angle_between(coarse.rotation(i), expected[i].rotation), 4e-6 / expected[i].gap);
    }
}

TEST(Rotation, OfAWarmStartedStretchedBodyIsAccurateToRounding)
{
    // The case that simulations live in: A = R S with S near the identity, started 0.2 rad off.
    const Random random(2);
    constexpr std::size_t n = 5'000;
    Batch<double> fine(n);
    Batch<float> coarse(n);
    std::vector<Mat3> expected(n);
    for (std::size_t i = 0; i < n; ++i) {
        const Eigen::Quaterniond r = any_rotation(random, i);
        const Mat3 e = 0.3 * any_matrix(random, n + i);
        const Mat3 s = Mat3::Identity() + 0.5 * (e + e.transpose());
        const Eigen::Quaterniond off(
            Eigen::AngleAxisd(0.2, vector_in_cube(random, 9 * n + i).normalized()));
        expected[i] = by_singular_values(r.toRotationMatrix() * s).rotation;
        fine.set(i, r.toRotationMatrix() * s);
        coarse.set(i, r.toRotationMatrix() * s);
        fine.warm(i, r * off);
        coarse.warm(i, r * off);
    }
    fine.run();
    coarse.run();
    for (std::size_t i = 0; i < n; ++i) {
        ASSERT_LT(angle_between(fine.rotation(i), expected[i]), 1e-14);
        ASSERT_LT(angle_between(coarse.rotation(i), expected[i]), 1e-6);
    }
}

TEST(Rotation, ReachesTheMaximumFromEveryStartForEveryMatrix)
{
    // tr(R^T A) has one maximum, s1 + s2 +- s3. Singular, mirrored, tiny and huge matrices, and
    // starts half a turn off, where the gradient vanishes too.
    std::vector<Mat3> hard = {Mat3::Identity(), -Mat3::Identity(), Mat3::Zero()};
    for (int k = 0; k < 3; ++k) {
        hard.push_back(Mat3(Vec3::Unit(k).asDiagonal()));                        // rank 1
        hard.push_back(Mat3((Vec3(1, 1, 1) - Vec3::Unit(k)).asDiagonal()));      // rank 2
        hard.push_back(Mat3((Vec3(1, 1, 1) - 2 * Vec3::Unit(k)).asDiagonal()));  // mirrored
        hard.push_back(Mat3((2 * Vec3::Unit(k) - Vec3(1, 1, 1)).asDiagonal()));  // half a turn
    }
    const Random random(3);
    for (std::uint64_t i = 0; i < 40; ++i) {
        const Vec3 u = vector_in_cube(random, 4 * i), v = vector_in_cube(random, 4 * i + 1);
        const Vec3 w = vector_in_cube(random, 4 * i + 2);
        hard.push_back(u * v.transpose());
        hard.push_back(u * v.transpose() + w * u.transpose());
        hard.push_back(u * v.transpose() + 1e-9 * any_matrix(random, 1000 + i));
        hard.push_back(-any_matrix(random, 2000 + i));
        const Mat3 turn = any_rotation(random, 3000 + i).toRotationMatrix();
        hard.push_back(turn * Vec3(1, 1, -1).asDiagonal() * turn.transpose());
        hard.push_back(turn * Vec3(2, 1, -0.999).asDiagonal());
    }
    const std::size_t plain = hard.size();
    for (const double size : {1e-12, 1e12}) {
        for (std::size_t i = 0; i < plain; ++i) hard.push_back(size * hard[i]);
    }
    std::vector<Eigen::Quaterniond> starts = {
        {0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    for (std::uint64_t i = 0; i < 12; ++i) starts.push_back(any_rotation(random, 5000 + i));

    const std::size_t n = hard.size() * starts.size();
    Batch<double> fine(n);
    Batch<float> coarse(n);
    for (std::size_t i = 0; i < n; ++i) {
        fine.set(i, hard[i / starts.size()]);
        coarse.set(i, hard[i / starts.size()]);
        fine.warm(i, starts[i % starts.size()]);
        coarse.warm(i, starts[i % starts.size()]);
    }
    fine.run();
    coarse.run();
    for (std::size_t i = 0; i < n; ++i) {
        const Mat3& a = hard[i / starts.size()];
        const double best = by_singular_values(a).value;
        // Eigenvalues of K + c I, which is up to 4 |A|, part when they differ by a few (4) 2^-34 or
        // 2^-16 of it.
        // equal.
        ASSERT_NEAR((fine.rotation(i).transpose() * a).trace(), best, 1e-9 * a.norm()) << a;
        ASSERT_NEAR((coarse.rotation(i).transpose() * a).trace(), best, 3e-4 * a.norm()) << a;
        ASSERT_NEAR(fine.quaternion(i).norm(), 1, 1e-15);
        ASSERT_NEAR(coarse.quaternion(i).norm(), 1, 3e-7);
    }
}

TEST(Rotation, TakesTheNearestOneToTheLastWhereManyFit)
{
    // A = u v^T fixes only v -> u; the twist about u stays free, and should stay as it was.
    const Vec3 axis(0, 0, 1);
    for (double twist = -3; twist <= 3; twist += 0.25) {
        const Eigen::Quaterniond last(Eigen::AngleAxisd(twist, axis));
        const Eigen::Quaterniond tilted = Eigen::AngleAxisd(0.3, Vec3(1, 0, 0)) * last;
        EXPECT_LT(extract_rotation(axis * axis.transpose(), last).angularDistance(last), 1e-9);
        EXPECT_LT(extract_rotation(axis * axis.transpose(), tilted).angularDistance(last), 1e-3);
        EXPECT_LT(extract_rotation(Mat3::Zero(), last).angularDistance(last), 1e-15);
    }
}

TEST(Rotation, DoesNotFollowTheNoiseOfABodyOnALine)
{
    // In single precision, where the twist about the line sees only rounding: however that comes
    // out, the body does not spin. Rounding of 5e-7 over a damping of 4e-5, six times over, is less
    // than a tenth.
    const Random random(21);
    constexpr std::size_t n = 200;
    Batch<float> lines(n);
    std::vector<Eigen::Quaterniond> last(n);
    for (std::size_t i = 0; i < n; ++i) {
        last[i] = any_rotation(random, i);
        lines.warm(i, last[i]);
    }
    for (std::size_t step = 0; step < 20; ++step) {
        for (std::size_t i = 0; i < n; ++i) {
            const Mat3 line = last[i].toRotationMatrix() * Vec3(1, 0, 0).asDiagonal();
            lines.set(i, line + 6e-8 * any_matrix(random, 1000 * (step + 1) + i));
        }
        lines.run();
        for (std::size_t i = 0; i < n; ++i) {
            const Eigen::Quaterniond now = lines.quaternion(i).normalized();
            ASSERT_LT(now.angularDistance(last[i]), 0.1) << step;
            last[i] = now;
        }
    }
}

TEST(Rotation, IsFoundWhereTwoRotationsAreNearlyEquallyNear)
{
    // A = R diag(1, e, e) from any start: a turn about the first axis is all but free. The top
    // eigenspace of K is still the next one's by a thousandth, and rounding leaves a millionth.
    const Random random(22);
    constexpr std::size_t n = 500;
    const double e = 3e-10;
    Batch<double> batch(n);
    for (std::size_t i = 0; i < n; ++i) {
        batch.set(i, any_rotation(random, i).toRotationMatrix() * Vec3(1, e, e).asDiagonal());
        batch.warm(i, any_rotation(random, n + i));
    }
    batch.run();
    for (std::size_t i = 0; i < n; ++i) {
        ASSERT_LT(batch.quaternion(i).angularDistance(any_rotation(random, i)), 1e-4) << i;
    }
}

TEST(Rotation, IsContinuousWhileABodyIsCrushedFlatAndThroughToAPoint)
{
    // A = R0 diag(1, 1 - t, (1 - t)^2) goes from the identity to rank 1 while it turns slowly: the
    // warm-started rotation turns with it, 0.01 rad a step.
    Eigen::Quaterniond last = Eigen::Quaterniond::Identity();
    for (int step = 0; step <= 400; ++step) {
        const double t = std::min(1.0, step / 200.0);
        const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.01 * step, Vec3(1, 2, 3).normalized()));
        const Mat3 a = turn.toRotationMatrix() * Vec3(1, 1 - t, (1 - t) * (1 - t)).asDiagonal();
        const Eigen::Quaterniond now = extract_rotation(a, last);
        ASSERT_LT(now.angularDistance(last), 0.0101);
        last = now;
    }
}

TEST(Rotation, KeepsTheLastOneForAMatrixThatIsNotFinite)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double inf = std::numeric_limits<double>::infinity();
    const Eigen::Quaterniond last(Eigen::AngleAxisd(1, Vec3(0, 1, 0)));
    for (const double bad : {nan, inf, -inf}) {
        for (int k = 0; k < 9; ++k) {
            Mat3 a = Mat3::Identity();
            a(k / 3, k % 3) = bad;
            EXPECT_LT(extract_rotation(a, last).angularDistance(last), 1e-15);
        }
    }
    const Eigen::Quaterniond broken(nan, 0, 0, inf);
    EXPECT_EQ(extract_rotation(Mat3::Identity(), broken).w(), 1);
}

TEST(Rotation, HasTheSameBitsInAnyLaneOnAnyTarget)
{
    const Random random(7);
    constexpr std::size_t n = 1'003;
    Batch<float> first(n);
    for (std::size_t i = 0; i < n; ++i) {
        first.set(i, i % 5 == 0 ? Mat3(-any_matrix(random, i)) : any_matrix(random, i));
        first.warm(i, any_rotation(random, n + i));
    }
    const Batch<float> start = first;
    first.run();
    on_every_target([&](const char* target) {
        Batch<float> again = start;
        again.run();
        EXPECT_EQ(again.q, first.q) << target;
        for (const std::size_t i : {0u, 7u, 500u, 1002u}) {
            Batch<float> one(1);
            for (std::size_t k = 0; k < 9; ++k) one.a[k] = start.a[k * n + i];
            for (std::size_t k = 0; k < 4; ++k) one.q[k] = start.q[k * n + i];
            one.run();
            for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(one.q[k], first.q[k * n + i]);
        }
    });
}

TEST(Rotation, OfNoMatricesDoesNothing)
{
    Batch<float> none(0);
    none.run();
    EXPECT_TRUE(none.q.empty());
}

TEST(Rotation, InThePlaneIsTheClosedForm)
{
    // The rotation nearest to R(t) S, S positive definite, is R(t); to -I, half a turn; to a mirror
    // image of equal stretch, none better than another: the last one stays.
    const std::vector<double> angles = {-3, -1.5, 0, 0.7, 3.1};
    const std::size_t n = angles.size();
    std::vector<double> a(4 * n), cs(2 * n, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
        const Eigen::Matrix2d r = Eigen::Rotation2Dd(angles[i]).toRotationMatrix();
        const Eigen::Matrix2d m = r * (Eigen::Matrix2d() << 2, 0.3, 0.3, 0.5).finished();
        for (std::size_t k = 0; k < 4; ++k)
            a[k * n + i] = m(Eigen::Index(k / 2), Eigen::Index(k % 2));
    }
    physics::extract_rotations_2d(n, a.data(), n, cs.data(), n);
    for (std::size_t i = 0; i < n; ++i) {
        EXPECT_NEAR(cs[i], std::cos(angles[i]), 1e-15);
        EXPECT_NEAR(cs[n + i], std::sin(angles[i]), 1e-15);
    }
    const double mirror[4] = {1, 0, 0, -1}, none[4] = {0, 0, 0, 0},
                 half[4] = {-1e-20, 0, 0, -1e-20};
    for (const double* m : {mirror, none}) {
        double last[2] = {0.6, 0.8};
        physics::extract_rotations_2d(1, m, 1, last, 1);
        EXPECT_NEAR(last[0], 0.6, 1e-15);
        EXPECT_NEAR(last[1], 0.8, 1e-15);
    }
    double turned[2] = {1, 0};
    physics::extract_rotations_2d(1, half, 1, turned, 1);
    EXPECT_EQ(turned[0], -1);
    EXPECT_EQ(turned[1], 0);
    float fresh[2] = {0, 0};
    const float zero[4] = {};
    physics::extract_rotations_2d(1, zero, 1, fresh, 1);
    EXPECT_EQ(fresh[0], 1);
}
