#include "geometry/io/read_camera.hpp"

#include "geometry/io/file_axes.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace geometry {
namespace {

const ImportedCamera& camera_named(const ImportedScene& scene, const std::string& name)
{
    std::string names;
    for (const ImportedCamera& camera : scene.cameras) {
        if (name.empty() || camera.name == name) return camera;
        names += (names.empty() ? "" : ", ") + camera.name;
    }
    if (names.empty()) throw std::runtime_error("it has no camera: export one with the scene");
    throw std::runtime_error("it has no camera \"" + name + "\", but " + names);
}

// Between two samples: what moves less than a 120th of a second is straight.
Transform placed_at(const ImportedCamera& camera, double time)
{
    const auto& samples = camera.to_world;
    if (samples.empty()) throw std::runtime_error("its camera has no place");
    const double last = double(samples.size() - 1);
    const double at = std::clamp(time * ImportedCamera::samples_a_second, 0.0, last);
    const auto i = static_cast<std::size_t>(at);
    const std::size_t j = std::min(i + 1, samples.size() - 1);
    using Rows = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
    const Eigen::Map<const Rows> a(samples[i].data()), b(samples[j].data());
    Transform T = Transform::Identity();
    T.matrix().topRows<3>() = a + (at - double(i)) * (b - a);
    return T;
}

}  // namespace

FileCamera read_camera(const std::filesystem::path& path, const std::string& name, double time,
                       double aspect, const ReadOptions& options)
{
    const ImportedScene scene = import_cameras(path, options.import);
    try {
        if (!scene.error.empty()) {
            throw std::runtime_error(why_not_understood(path, scene.error));
        }
        const ImportedCamera& camera = camera_named(scene, name);
        Transform file_to_world = Transform::Identity();
        file_to_world.linear() = to_metres(scene, options);
        const Transform T = file_to_world * placed_at(camera, time);
        FileCamera out;
        out.name = camera.name;
        out.eye = T * camera.position.cast<double>();
        out.ahead = T.linear() * camera.ahead.cast<double>();
        out.up = T.linear() * camera.up.cast<double>();
        if (!out.eye.allFinite() || !(out.ahead.norm() > 0) || !(out.up.norm() > 0)) {
            throw std::runtime_error("its camera \"" + camera.name + "\" has no direction");
        }
        const double scale = std::cbrt(std::abs(T.linear().determinant()));
        out.ahead.normalize();
        out.up.normalize();
        const double shape = camera.aspect > 0 ? double(camera.aspect) : aspect;
        if (camera.half_width > 0) {
            out.height = 2 * scale * double(camera.half_width) / shape;
        } else {
            out.angle = 2 * std::atan(std::tan(0.5 * double(camera.width_angle)) / shape);
            if (!(out.angle > 2e-3 && out.angle < 3)) {
                throw std::runtime_error("its camera \"" + camera.name +
                                         "\" has no usable angle of view");
            }
        }
        for (const ImportedFile& f : scene.files) {
            if (f.path != std::filesystem::absolute(path).string()) {
                out.side_files.emplace_back(f.path);
            }
        }
        return out;
    } catch (const std::runtime_error& error) {
        throw std::runtime_error(path.string() + ": " + error.what());
    }
}

}  // namespace geometry
