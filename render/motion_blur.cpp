#include "render/motion_blur.hpp"

#include "geometry/base/parallel.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace render {
namespace {

constexpr std::size_t blur_grain = 16384;

bool same_faces(const TriMesh& a, const TriMesh& b)
{
    if (a.positions.size() != b.positions.size()) return false;
    if (a.topology == b.topology) return true;
    return a.topology->triangles == b.topology->triangles &&
           a.topology->normal_triangles == b.topology->normal_triangles;
}

bool went(const Surface& surface)
{
    return surface.before && same_faces(*surface.mesh, *surface.before) &&
           surface.mesh->positions != surface.before->positions;
}

bool went(const std::vector<Vec3f>& now, const std::vector<Vec3f>& before)
{
    return now.size() == before.size() && now != before;
}

// (1 - ago) now + ago before; both have as many.
void go_back(std::vector<Vec3f>& now, const std::vector<Vec3f>& before, float ago)
{
    geometry::parallel_for(now.size(), blur_grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) now[i] += ago * (before[i] - now[i]);
    });
}

std::shared_ptr<const TriMesh> mesh_at(const Surface& surface, float ago)
{
    auto mesh = std::make_shared<TriMesh>(*surface.mesh);
    const TriMesh& before = *surface.before;
    go_back(mesh->positions, before.positions, ago);
    if (mesh->normals.size() != before.normals.size()) return mesh;
    go_back(mesh->normals, before.normals, ago);
    for (std::size_t i = 0; i < mesh->normals.size(); ++i) {
        Vec3f& n = mesh->normals[i];
        const float length = n.norm();
        n = length > 1e-3f ? Vec3f(n / length) : surface.mesh->normals[i];  // turned about: as now
    }
    return mesh;
}

}  // namespace

bool moves(const Scene& scene)
{
    const auto any = [](const auto& all, const auto& test) {
        return std::any_of(all.begin(), all.end(), test);
    };
    return any(scene.surfaces, [](const Surface& s) { return went(s); }) ||
           any(scene.balls, [](const Balls& b) { return went(b.centres, b.before); }) ||
           any(scene.lines, [](const Lines& l) { return went(l.ends, l.before); });
}

Scene moment_of(const Scene& scene, double ago)
{
    Scene then = scene;
    const auto share = static_cast<float>(ago);
    for (Surface& surface : then.surfaces) {
        if (went(surface)) surface.mesh = mesh_at(surface, share);
    }
    for (Balls& balls : then.balls) {
        if (went(balls.centres, balls.before)) go_back(balls.centres, balls.before, share);
    }
    for (Lines& lines : then.lines) {
        if (went(lines.ends, lines.before)) go_back(lines.ends, lines.before, share);
    }
    return then;
}

void Exposure::add(const Image& picture, const std::vector<float>& linear)
{
    const std::size_t pixels = picture.rgba.size() / 4;
    if (count_ == 0) {
        width_ = picture.width, height_ = picture.height;
        light_.assign(3 * pixels, 0);
        linear_.assign(linear.size(), 0);
        std::fill(linear_.begin() + std::ptrdiff_t(linear.size() / 5 * 4), linear_.end(),
                  nothing_there);
    }
    ++count_;
    const auto& light = light_of_steps();
    for (std::size_t i = 0; i < pixels; ++i) {
        for (std::size_t c = 0; c < 3; ++c) light_[3 * i + c] += light[picture.rgba[4 * i + c]];
    }
    const std::size_t depths = linear.size() / 5 * 4;
    for (std::size_t i = 0; i < depths; ++i) linear_[i] += linear[i];
    for (std::size_t i = depths; i < linear.size(); ++i) {
        linear_[i] = std::min(linear_[i], linear[i]);
    }
}

Image Exposure::mean_picture() const
{
    Image image{width_, height_, std::vector<std::uint8_t>(light_.size() / 3 * 4, 255)};
    const auto share = 1 / static_cast<float>(count_);
    geometry::parallel_for(light_.size() / 3, blur_grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            for (std::size_t c = 0; c < 3; ++c) {
                image.rgba[4 * i + c] = step_of_light(share * light_[3 * i + c]);
            }
        }
    });
    return image;
}

std::vector<float> Exposure::mean_linear() const
{
    std::vector<float> mean = linear_;
    const std::size_t depths = mean.size() / 5 * 4;
    for (std::size_t i = 0; i < depths; ++i) mean[i] /= static_cast<float>(count_);
    return mean;
}

}  // namespace render
