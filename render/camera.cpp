#include "render/camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace render {

Vec3 direction(double azimuth, double elevation)
{
    return {std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
            std::cos(azimuth) * std::cos(elevation)};
}

Vec3 corner_of(const Box& box, int k)
{
    return {k & 1 ? box.hi.x() : box.lo.x(), k & 2 ? box.hi.y() : box.lo.y(),
            k & 4 ? box.hi.z() : box.lo.z()};
}

namespace {

// Whether a box is as good as a point.
bool is_point(const Box& box)
{
    return box.diagonal() <= 1e-12 * box.centre().cwiseAbs().maxCoeff() || box.diagonal() == 0;
}

void grow(Box& box)
{
    box.lo.array() -= 0.5;
    box.hi.array() += 0.5;
}

// With the camera's axes r (right), u (up), b (towards the camera), a point p at p.b behind the
// plane through the target needs the eye at a distance of at least |p.r| / tan + p.b: that is one
// half-space of eyes for each side of the picture. Along each of r and u the two sides cross in one
// place; the farther of the two crossings is taken, and the other axis is centred in what is free.
// With more free on the right, the eye goes to the right as far as the points would reach in there.
Camera fit_points(std::span<const Vec3> points, const Box& box, double azimuth, double elevation,
                  double field_of_view, double aspect, double margin, double right_free)
{
    // Straight from above there is no sideways: stay just short of it.
    const double limit = 1.5707;
    const Vec3 b = direction(azimuth, std::clamp(elevation, -limit, limit));
    const Vec3 r = Vec3(0, 1, 0).cross(b).normalized();
    const Vec3 u = b.cross(r);

    const auto within = [&](double share) {
        return (1 - 2 * std::clamp(share, 0.0, 0.45)) * std::tan(field_of_view / 2);
    };
    const double tan_y = within(margin), tan_x = tan_y * aspect;
    const double tan_right = aspect * within(std::max(margin, right_free));
    const Vec3 centre = box.centre();
    // How far to the right (left, up, down) each point pushes its side of the picture: the largest
    // of  p.axis + tan p.b  over the points.
    double right = -1e300, left = -1e300, top = -1e300, bottom = -1e300, front = -1e300;
    double alike = -1e300;  // right, with no more free there
    for (const Vec3& point : points) {
        const Vec3 p = point - centre;
        right = std::max(right, p.dot(r) + tan_right * p.dot(b));
        alike = std::max(alike, p.dot(r) + tan_x * p.dot(b));
        left = std::max(left, -p.dot(r) + tan_x * p.dot(b));
        top = std::max(top, p.dot(u) + tan_y * p.dot(b));
        bottom = std::max(bottom, -p.dot(u) + tan_y * p.dot(b));
        front = std::max(front, p.dot(b));
    }
    const double distance = std::max({(right + left) / (tan_right + tan_x),
                                      (top + bottom) / (2 * tan_y), front + 1e-3 * box.diagonal()});
    Camera camera;
    const double sideways = std::max((alike - left) / 2, right - tan_right * distance);
    camera.target = centre + r * sideways + u * ((top - bottom) / 2);
    camera.eye = camera.target + distance * b;
    camera.field_of_view = field_of_view;
    return camera;
}

}  // namespace

Camera fit(const Box& asked, double azimuth, double elevation, double field_of_view, double aspect,
           double margin, double right_free)
{
    Box box = asked;
    if (box.empty()) box.add(Vec3(Vec3::Zero()));
    if (!box.lo.allFinite() || !box.hi.allFinite() || !std::isfinite(box.diagonal())) {
        throw std::invalid_argument("the camera cannot fit a box that is not finite");
    }
    if (is_point(box)) grow(box);
    std::array<Vec3, 8> corners;
    for (int k = 0; k < 8; ++k) corners[std::size_t(k)] = corner_of(box, k);
    return fit_points(corners, box, azimuth, elevation, field_of_view, aspect, margin, right_free);
}

Camera fit(std::span<const Vec3f> points, double azimuth, double elevation, double field_of_view,
           double aspect, double margin, double right_free)
{
    std::vector<Vec3> all;
    Box box;
    for (const Vec3f& p : points) {
        if (!p.allFinite())
            throw std::invalid_argument("the camera cannot fit points that are not finite");
        all.push_back(p.cast<double>());
        box.add(all.back());
    }
    if (all.empty() || is_point(box)) {
        return fit(box, azimuth, elevation, field_of_view, aspect, margin, right_free);
    }
    return fit_points(all, box, azimuth, elevation, field_of_view, aspect, margin, right_free);
}

std::vector<Vec3f> turned_about(std::span<const Vec3f> points)
{
    Box box;
    for (const Vec3f& p : points) box.add(p.cast<double>());
    std::vector<Vec3f> all;
    if (box.empty()) return all;
    const Vec3 centre = box.centre();
    constexpr int times = 24;
    for (int k = 0; k < times; ++k) {
        const double angle = 2 * std::numbers::pi * k / times;
        const double c = std::cos(angle), s = std::sin(angle);
        for (const Vec3f& point : points) {
            const Vec3 p = point.cast<double>() - centre;
            const Vec3 turned(c * p.x() + s * p.z(), p.y(), c * p.z() - s * p.x());
            all.push_back((centre + turned).cast<float>());
        }
    }
    return all;
}

Camera parallel_from(const Camera& camera)
{
    Camera parallel = camera;
    const double farther = std::tan(camera.field_of_view / 2) / std::tan(parallel_view / 2);
    parallel.eye = camera.target + farther * (camera.eye - camera.target);
    parallel.field_of_view = parallel_view;
    return parallel;
}

geometry::Mat3 camera_axes(const Camera& camera)
{
    const Vec3 ahead = (camera.target - camera.eye).normalized();
    Vec3 right = ahead.cross(camera.up);
    if (!(right.norm() > 1e-9)) right = ahead.unitOrthogonal();
    right.normalize();
    geometry::Mat3 axes;
    axes.row(0) = right;
    axes.row(1) = right.cross(ahead);
    axes.row(2) = ahead;
    return axes;
}

std::optional<Vec3> place_in_picture(const Camera& camera, const Vec3& point, double aspect)
{
    const Vec3 p = camera_axes(camera) * (point - camera.eye);
    const double height =
        2 * std::tan(camera.field_of_view / 2) * p.z();  // m, of the picture there
    if (!(height > 0)) return std::nullopt;
    return Vec3(0.5 + p.x() / (aspect * height), 0.5 - p.y() / height, 1 / height);
}

bool may_see(const Camera& camera, const Box& box, double aspect)
{
    const geometry::Mat3 axes = camera_axes(camera);
    const double tan_y = std::tan(camera.field_of_view / 2), tan_x = tan_y * aspect;
    std::array<bool, 5> beyond;
    beyond.fill(true);
    for (int k = 0; k < 8; ++k) {
        const Vec3 p = axes * (corner_of(box, k) - camera.eye);
        beyond[0] &= p[2] < 0;
        beyond[1] &= p[0] > tan_x * p[2];
        beyond[2] &= -p[0] > tan_x * p[2];
        beyond[3] &= p[1] > tan_y * p[2];
        beyond[4] &= -p[1] > tan_y * p[2];
    }
    return std::find(beyond.begin(), beyond.end(), true) == beyond.end();
}

}  // namespace render
