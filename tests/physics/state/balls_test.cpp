#include "geometry/mesh/mesh.hpp"
#include "physics/state/balls.hpp"

#include <gtest/gtest.h>

#include <array>

namespace {

using namespace physics;

TEST(Balls, ShowTheirTurningByTwoColoursInTurn)
{
    const std::vector<Ball> balls{{.radius = 0.2}, {.radius = 0.1}};
    std::vector<BallState> states(2);
    states[0].x = Vec3(1, 2, 3);
    states[1].turn = Eigen::Vector4d(std::sqrt(0.5), 0, std::sqrt(0.5), 0);  // 90 degrees about y
    const geometry::TriMesh mesh = ball_mesh(balls, states, 24, {1, 0, 0}, {0, 0, 1});
    const auto& topology = *mesh.topology;
    ASSERT_EQ(topology.material.size(), topology.triangles.size());
    std::array<std::size_t, 2> times{};
    for (std::size_t t = 0; t < topology.triangles.size(); ++t) {
        const auto& material = topology.materials.at(topology.material[t]);
        const bool second = material.colour == geometry::Vec3f(0, 0, 1);
        ++times[second ? 1 : 0];
        geometry::Vec3f at = geometry::Vec3f::Zero();
        for (const auto v : topology.triangles[t]) at += mesh.positions[v] / 3;
        const bool of_first = t < topology.triangles.size() / 2;
        // Sixths about the ball's own axis, which is y; the second has turned by 90 degrees.
        Vec3 own = at.cast<double>() - states[of_first ? 0 : 1].x;
        if (!of_first) own = Vec3(-own.z(), own.y(), own.x());
        const double turn = std::atan2(own.z(), own.x()) * 3 / std::numbers::pi;
        EXPECT_EQ(second, (static_cast<int>(std::floor(turn + 6)) & 1) == 1) << t;
    }
    EXPECT_EQ(times[0], times[1]);
}

TEST(Balls, AStateOfOtherBallsIsRefused)
{
    const std::vector<Ball> balls(2);
    EXPECT_THROW(ball_mesh(balls, std::vector<BallState>(1), 24, {1, 0, 0}, {0, 0, 1}),
                 std::invalid_argument);
}

}  // namespace
