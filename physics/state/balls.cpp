#include "physics/state/balls.hpp"

#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace physics {

std::vector<BallState> place_balls(std::span<const Ball> balls)
{
    std::vector<BallState> out;
    for (const Ball& ball : balls) out.push_back({ball.position, ball.velocity});
    return out;
}

void check_balls(std::span<const Ball> balls)
{
    for (const Ball& b : balls) {
        const auto above = [](double v) { return std::isfinite(v) && v > 0; };
        if (!above(b.radius) || !above(b.mass) || !b.position.allFinite() ||
            !b.velocity.allFinite() || !(std::isfinite(b.friction) && b.friction >= 0)) {
            throw std::invalid_argument(fmt::format(
                "ball: expected a radius and a mass above 0, a friction of at least 0 and a finite "
                "position and velocity, found radius {} m, mass {} kg and friction {}",
                b.radius, b.mass, b.friction));
        }
    }
}

geometry::TriMesh ball_mesh(std::span<const Ball> balls, std::span<const BallState> states,
                            int segments, const geometry::Vec3f& colour,
                            const geometry::Vec3f& second)
{
    using namespace geometry;
    if (balls.size() != states.size()) {
        throw std::invalid_argument(fmt::format(
            "expected the state of {} balls, found {}. Link the same balls to Simulate, "
            "in the same order",
            balls.size(), states.size()));
    }
    std::vector<TriMesh> meshes;
    for (std::size_t b = 0; b < balls.size(); ++b) {
        TriMesh mesh = uv_sphere(balls[b].radius, segments, segments / 2);
        auto topology = std::make_shared<MeshTopology>(*mesh.topology);
        topology->materials = {{"ball", colour}, {"stripe", second}};
        topology->material.clear();
        for (const auto& t : topology->triangles) {
            Vec3f middle = Vec3f::Zero();
            for (const auto v : t) middle += mesh.positions[v] / 3;
            const double turn =
                std::atan2(double(middle.z()), double(middle.x())) / (2 * std::numbers::pi);
            topology->material.push_back(std::uint16_t(int(std::floor(6 * (turn + 1))) & 1));
        }
        mesh.topology = std::move(topology);
        const auto& q = states[b].turn;
        const Mat3 turn = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
        for (Vec3f& p : mesh.positions) p = (turn * p.cast<double>() + states[b].x).cast<float>();
        for (Vec3f& n : mesh.normals) n = (turn * n.cast<double>()).cast<float>();
        meshes.push_back(std::move(mesh));
    }
    std::vector<const TriMesh*> all;
    for (const TriMesh& mesh : meshes) all.push_back(&mesh);
    return merge(all);
}

}  // namespace physics
