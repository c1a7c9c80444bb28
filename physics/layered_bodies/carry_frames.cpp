#include "physics/layered_bodies/carry_frames.hpp"

#include "geometry/mesh/mesh.hpp"
#include "physics/math/polar.hpp"

namespace physics {

using geometry::Mat3;

std::size_t CarriedFrames::bytes() const
{
    return probes ? probes->positions.size() * 32 : 0;
}

CarriedFrames bind_frames(std::span<const Transform> frames, const SurfaceSamples& samples,
                          const geometry::Cubes& cubes)
{
    CarriedFrames carried;
    geometry::TriMesh probes;
    carried.step = 0.5 * cubes.size;
    const std::size_t n = frames.size();
    std::vector<std::size_t> count(n, 0);
    carried.centre.assign(n, Vec3::Zero());
    for (std::size_t s = 0; s < samples.skeletons(); ++s) {
        const std::uint32_t f = samples.frame[s];
        for (std::size_t i = samples.first[s]; i < samples.first[s + 1]; ++i) {
            carried.centre[f] += samples.origin[i];
            ++count[f];
        }
    }
    for (std::size_t f = 0; f < n; ++f) {
        if (count[f] > 0) carried.centre[f] /= static_cast<double>(count[f]);
        carried.centre[f] = frames[f] * carried.centre[f];
        const auto add = [&](const Vec3& p) { probes.positions.push_back(p.cast<float>()); };
        add(carried.centre[f]);
        for (int k = 0; k < 3; ++k) {
            add(carried.centre[f] + carried.step * Vec3::Unit(k));
            add(carried.centre[f] - carried.step * Vec3::Unit(k));
        }
    }
    carried.binding = geometry::bind(probes, cubes);
    carried.probes = std::make_shared<const geometry::TriMesh>(std::move(probes));
    return carried;
}

std::vector<Transform> carry(const CarriedFrames& carried, std::span<const Transform> frames,
                             const geometry::Cubes& cubes, std::span<const Vec3> x)
{
    const geometry::TriMesh now = geometry::embed(carried.binding, *carried.probes, cubes, x);
    std::vector<Transform> out;
    for (std::size_t f = 0; f < carried.centre.size(); ++f) {
        const auto at = [&](std::size_t k) {
            return Vec3(now.positions[7 * f + k].cast<double>());
        };
        Mat3 F;
        for (std::size_t k = 0; k < 3; ++k) {
            F.col(static_cast<Eigen::Index>(k)) =
                (at(1 + 2 * k) - at(2 + 2 * k)) / (2 * carried.step);
        }
        Mat3 R = Mat3::Identity();
        if (F.allFinite()) R = polar_of(F).R;
        Transform t = Transform::Identity();
        t.translate(at(0)).rotate(R).translate(-carried.centre[f]);
        out.push_back(t * frames[f]);
    }
    return out;
}

}  // namespace physics
