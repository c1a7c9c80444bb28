#include "physics/lattice/ball_faces.hpp"

#include "geometry/cubes/trilinear.hpp"
#include "geometry/mesh/on_triangle.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace physics {

namespace {

using Triangle = std::array<Vec3, 3>;

Vec3 at_weights(const Triangle& t, const Vec3& weight)
{
    return weight[0] * t[0] + weight[1] * t[1] + weight[2] * t[2];
}

// A face of the skin as the ball's centre sees it, when the step begins and ends.
struct SeenFace {
    std::array<Vec3, 3> local;  // its corners, in the cube from 0 to 1
    Triangle before, after;     // m
};

SeenFace see(const ContactScene& scene, const BallState& ball, const CornerRuns::Corners& corners,
             const std::array<Vec3f, 3>& piece)
{
    SeenFace out;
    const Vec3 first = piece[0].cast<double>();
    out.local = {first, first + piece[1].cast<double>(), first + piece[2].cast<double>()};
    for (std::size_t i = 0; i < 3; ++i) {
        const auto weight = geometry::trilinear_weights(out.local[i]);
        Vec3 x = -ball.x, v = -ball.v;
        for (std::size_t a = 0; a < 8; ++a) {
            x += weight[a] * scene.state.x[corners[a]];
            v += weight[a] * scene.state.v[corners[a]];
        }
        out.before[i] = x;
        out.after[i] = x + scene.dt * v;
    }
    return out;
}

// A place on a face, by the weights of its corners.
struct FacePlace {
    Vec3 weight, normal;
    double distance;                                        // m, less than 0 on the other side
    double when = std::numeric_limits<double>::infinity();  // share of the step when it is passed
};

// The face after a share of the step.
Triangle at_share(const SeenFace& face, double share)
{
    Triangle out;
    for (std::size_t i = 0; i < 3; ++i) {
        out[i] = face.before[i] + share * (face.after[i] - face.before[i]);
    }
    return out;
}

Vec3 area_normal(const Triangle& t)
{
    return (t[1] - t[0]).cross(t[2] - t[0]);
}

// Where the centre passes through the face: at a root of a cubic, as the face may turn.
std::optional<FacePlace> place_passed(const SeenFace& face)
{
    const auto volume = [](const Triangle& t) { return -area_normal(t).dot(t[0]); };
    const double first = volume(face.before);
    if (!(first * volume(face.after) < 0)) return std::nullopt;
    double low = 0, high = 1;
    for (int i = 0; i < 40; ++i) {
        const double middle = (low + high) / 2;
        (first * volume(at_share(face, middle)) > 0 ? low : high) = middle;
    }
    const Triangle then = at_share(face, high);
    const Vec3 weight = geometry::on_triangle(then[0], then[1], then[2]).barycentric;
    // By rounding, none is to slip between two faces.
    const double size_sq = (then[1] - then[0]).squaredNorm() + (then[2] - then[0]).squaredNorm();
    if (!(at_weights(then, weight).squaredNorm() < 1e-12 * size_sq)) return std::nullopt;
    const Vec3 normal = (first > 0 ? 1 : -1) * area_normal(face.after).normalized();
    return FacePlace{weight, normal, -normal.dot(face.after[0]), high};
}

FacePlace nearest_place(const SeenFace& face)
{
    const Vec3 weight =
        geometry::on_triangle(face.after[0], face.after[1], face.after[2]).barycentric;
    const Vec3 apart = -at_weights(face.after, weight);
    const double length = apart.norm();
    return {weight, length > 0 ? Vec3(apart / length) : Vec3(Vec3::UnitY()), length};
}

// Weights of the cube's corners. A plane's upper ones are its lower ones: one weight each.
std::array<double, 8> weights_in(const CornerRuns::Corners& corners, const SeenFace& face,
                                 const Vec3& weight)
{
    auto out = geometry::trilinear_weights(at_weights(face.local, weight));
    for (std::size_t a = 0; a < 8; ++a) {
        for (std::size_t b = 0; b < a; ++b) {
            if (corners[a] != corners[b]) continue;
            out[b] += out[a];
            out[a] = 0;
        }
    }
    return out;
}

// Whether all of a cube's faces are farther from the ball than it reaches. They may lie outside.
bool is_far(const ContactScene& scene, std::uint32_t b, std::size_t c,
            const CornerRuns::Corners& corners)
{
    const BallState& ball = scene.state.balls[b];
    const Vec3 some = scene.state.x[corners[0]];
    double size_sq = 0, speed_sq = 0;  // of the cube, from that corner; seen from the ball
    for (const auto k : corners) {
        size_sq = std::max(size_sq, (scene.state.x[k] - some).squaredNorm());
        speed_sq = std::max(speed_sq, (scene.state.v[k] - ball.v).squaredNorm());
    }
    const double reach = scene.balls[b].radius + scene.body.skin.thickest +
                         2 * double(scene.body.skin.on(c).reach) * std::sqrt(size_sq) +
                         scene.dt * std::sqrt(speed_sq);
    return (some - ball.x).squaredNorm() > reach * reach;
}

struct Found {
    FaceTouch touch;
    double when;
};

// What the ball touches first, or deepest, of a cube.
std::optional<Found> touch_cube(const ContactScene& scene, std::uint32_t b, std::size_t c,
                                const CornerRuns::Corners& corners)
{
    const ContactSurface& skin = scene.body.skin;
    const SurfacePatch& patch = skin.on(c);
    const double touching = scene.balls[b].radius + skin.thickest - skin.thinner_by(c);
    std::optional<Found> best;
    for (std::uint32_t i = patch.area; i < patch.areas_end; ++i) {
        const SeenFace face = see(scene, scene.state.balls[b], corners, skin.piece[i]);
        const FacePlace place = place_passed(face).value_or(nearest_place(face));
        const double gap = place.distance - touching;
        if (!(gap < 0)) continue;
        if (best && std::pair(place.when, gap) >= std::pair(best->when, best->touch.gap)) continue;
        best = {{c, corners, weights_in(corners, face, place.weight), place.normal, gap},
                place.when};
    }
    return best;
}

}  // namespace

std::vector<FaceTouch> find_face_touches(const ContactScene& scene, std::uint32_t b)
{
    std::vector<Found> found;
    const CornerRuns& cubes = scene.body.skin.corners;
    cubes.for_each(0, cubes.size(), [&](std::size_t c, const CornerRuns::Corners& corners) {
        if (is_far(scene, b, c, corners) || (scene.torn && scene.torn->parts_of(c))) return;
        if (auto touch = touch_cube(scene, b, c, corners)) found.push_back(*touch);
    });
    std::stable_sort(found.begin(), found.end(), [](const Found& p, const Found& q) {
        return std::pair(p.when, p.touch.gap) < std::pair(q.when, q.touch.gap);
    });
    std::vector<FaceTouch> out;
    // Beside the deepest place of a flat skin, rims of the next cubes would hold up what rolls.
    constexpr double same_way = 0.7;
    for (const Found& f : found) {
        const bool alike = std::ranges::any_of(
            out, [&](const FaceTouch& kept) { return kept.normal.dot(f.touch.normal) > same_way; });
        if (!alike) out.push_back(f.touch);
        if (std::isfinite(f.when)) break;
    }
    return out;
}

}  // namespace physics
