// A preconditioner that takes contacts into account, against the inverse of the whole matrix.

#include "physics/bricks/step_responses.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <random>

namespace {

using namespace physics;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t corners = 12, numbers = 4 * corners;

// A_0^-1 of a body whose numbers are all coupled; the fourth of each corner is not used.
MatrixXd inverse_at_rest(std::mt19937& random, const Aligned<double>& fixed)
{
    std::normal_distribution<double> any;
    const auto size = static_cast<Index>(numbers);
    MatrixXd root(size, size);
    for (Index i = 0; i < root.size(); ++i) root.data()[i] = any(random);
    MatrixXd a = root * root.transpose() + MatrixXd::Identity(root.rows(), root.rows());
    for (std::size_t i = 0; i < numbers; ++i) {
        if (i % 4 < 3 && fixed[i] == 0) continue;
        a.row(Index(i)).setZero(), a.col(Index(i)).setZero();
        a(Index(i), Index(i)) = 1;
    }
    MatrixXd out = a.inverse();
    for (std::size_t i = 0; i < numbers; ++i) {
        if (i % 4 == 3 || fixed[i] != 0) out(Index(i), Index(i)) = 0;
    }
    return out;
}

// Between four corners, stiff in all directions, or across a plane only.
ContactBlock<float> contact(std::uint32_t first, bool all, float stiffness)
{
    ContactBlock<float> out{};
    for (std::uint32_t a = 0; a < 4; ++a) {
        out.corners[a] = (first + 3 * a) % corners;
        out.weight[a] = a < 2 ? 0.5f : -0.25f * static_cast<float>(a - 1);
    }
    out.count = 4;
    if (all) {
        out.matrix = {2 * stiffness, 0, stiffness, stiffness, 0, 3 * stiffness};
    } else {
        out.matrix = {stiffness, 0, stiffness, 0, 0, stiffness};  // along (1, 0, 1)
    }
    return out;
}

TEST(StepResponses, GiveTheInverseWithTheContacts)
{
    std::mt19937 random(7);
    Aligned<double> fixed(numbers, 0);
    fixed[4 * 3 + 1] = 1;
    const MatrixXd m = inverse_at_rest(random, fixed);
    int applied = 0;
    const auto inverse = [&](const float* r, float* z) {
        ++applied;
        const VectorXd x = m * Eigen::Map<const Eigen::VectorXf>(r, m.rows()).cast<double>();
        for (std::size_t i = 0; i < numbers; ++i) z[i] = static_cast<float>(x[Index(i)]);
    };
    StepResponses responses;
    const auto check = [&](const std::vector<ContactBlock<float>>& contacts) {
        responses.make(contacts, fixed, numbers, inverse);
        Aligned<float> r(numbers, 0), z(numbers, 0), pushed(numbers, 0);
        std::normal_distribution<float> any;
        for (std::size_t i = 0; i < numbers; ++i) {
            if (i % 4 < 3 && fixed[i] == 0) r[i] = any(random);
        }
        inverse(r.data(), z.data());
        responses.take_contacts(z.data());
        // (A_0 + sum W^T K W) z is r.
        for (const auto& c : contacts) c.add_times(z.data(), pushed.data());
        VectorXd rest(m.rows());
        for (std::size_t i = 0; i < numbers; ++i) {
            rest[Index(i)] = fixed[i] == 0 ? double(r[i]) - double(pushed[i]) : 0;
        }
        const VectorXd again = m * rest;
        for (std::size_t i = 0; i < numbers; ++i) {
            EXPECT_NEAR(again[Index(i)], double(z[i]), 2e-4) << i;
        }
    };
    responses.start(0.1, Aligned<double>(numbers, 1));
    const std::vector<ContactBlock<float>> two{contact(0, true, 10), contact(2, false, 40)};
    EXPECT_EQ(responses.missing(two), 6u);
    check(two);
    // What a contact presses with may change: its response stays.
    const std::vector<ContactBlock<float>> three{contact(2, true, 5), contact(0, false, 3),
                                                 contact(5, true, 20)};
    EXPECT_EQ(responses.missing(three), 3u);
    applied = 0;
    check(three);
    EXPECT_EQ(applied, 4);  // three responses, and the one that is checked
    // Another place, or another step, has another inverse.
    responses.start(0.1, Aligned<double>(numbers, 1));
    EXPECT_EQ(responses.missing(three), 0u);
    responses.start(0.1, Aligned<double>(numbers, 2));
    EXPECT_EQ(responses.missing(three), 9u);
}

TEST(StepResponses, LeaveWhatNothingTouchesAsItIs)
{
    StepResponses responses;
    responses.start(0.1, Aligned<double>(numbers, 1));
    responses.make({}, Aligned<double>(numbers, 0), numbers, [](const float*, float*) { FAIL(); });
    Aligned<float> z(numbers, 2);
    responses.take_contacts(z.data());
    EXPECT_EQ(z, Aligned<float>(numbers, 2));
}

}  // namespace
