#include "runtime/farm/schedule.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace runtime;

namespace {

FarmTask task(double seconds, std::vector<std::uint32_t> after = {})
{
    FarmTask t;
    t.seconds = seconds;
    t.after = std::move(after);
    return t;
}

double work_of(const Cut& cut)
{
    double sum = 0;
    for (const FarmTask& t : cut.tasks) sum += t.seconds;
    return sum;
}

}  // namespace

TEST(Schedule, EqualTasksThatWaitForNothingGoInRounds)
{
    Cut cut;
    for (int i = 0; i < 10; ++i) cut.tasks.push_back(task(3));
    // 10 tasks on n machines are ceil(10 / n) rounds of 3 s.
    for (const std::size_t n : {1u, 2u, 3u, 7u, 10u, 1000u}) {
        EXPECT_DOUBLE_EQ(makespan(cut, n), 3 * std::ceil(10.0 / static_cast<double>(n))) << n;
    }
    EXPECT_DOUBLE_EQ(makespan(cut, 2, 0.5), 5 * 3.5) << "and each costs its start";
}

TEST(Schedule, AChainIsAsLongOnAnyNumberOfMachines)
{
    Cut cut;
    for (std::uint32_t i = 0; i < 6; ++i) {
        cut.tasks.push_back(i == 0 ? task(1) : task(i + 1.0, {i - 1}));
    }
    EXPECT_DOUBLE_EQ(makespan(cut, 1), 21);
    EXPECT_DOUBLE_EQ(makespan(cut, 100), 21);
    EXPECT_EQ(critical_path(cut), (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}));
}

TEST(Schedule, TheTaskThatMostWorkWaitsForGoesFirst)
{
    // Two short tasks stand first in the list, but 10 s wait for the third: begun at once, both
    // machines are done at 11 s; begun last, one would be done at 12 s.
    Cut cut;
    cut.tasks = {task(1), task(1), task(1), task(10, {2})};
    EXPECT_DOUBLE_EQ(makespan(cut, 2), 11);
    EXPECT_EQ(critical_path(cut), (std::vector<std::uint32_t>{2, 3}));
}

TEST(Schedule, AnyCutLiesBetweenGrahamsBounds)
{
    // Graham, Bounds on multiprocessing timing anomalies, 1969: with W s of work and a longest path
    // of L s, any list schedule on n machines takes at least max(L, W / n) and at most
    // W / n + L (1 - 1 / n).
    std::mt19937 random(5);
    std::uniform_real_distribution<double> seconds(0.1, 5);
    for (int trial = 0; trial < 50; ++trial) {
        Cut cut;
        for (std::uint32_t t = 0; t < 60; ++t) {
            std::vector<std::uint32_t> after;
            for (std::uint32_t before = 0; before < t; ++before) {
                if (random() % 20 == 0) after.push_back(before);
            }
            cut.tasks.push_back(task(seconds(random), after));
        }
        double longest = 0;
        for (const std::uint32_t t : critical_path(cut)) longest += cut.tasks[t].seconds;
        const auto to_end = seconds_to_end(cut);
        EXPECT_NEAR(*std::max_element(to_end.begin(), to_end.end()), longest, 1e-9);
        for (const std::size_t n : {1u, 2u, 4u, 60u}) {
            const double span = makespan(cut, n), share = work_of(cut) / static_cast<double>(n);
            EXPECT_GE(span, std::max(longest, share) - 1e-9);
            EXPECT_LE(span, share + longest * (1 - 1 / static_cast<double>(n)) + 1e-9);
        }
    }
}

TEST(Schedule, NothingTakesNoTime)
{
    EXPECT_DOUBLE_EQ(makespan({}, 4), 0);
    EXPECT_TRUE(critical_path({}).empty());
}
