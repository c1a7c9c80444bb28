#include "geometry/embed/smooth_normals.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/mesh/mesh.hpp"

namespace geometry {
namespace {

constexpr std::size_t normals_a_task = 4096;

// One gradient for each corner of the cubes; counts 0 where there is none.
struct CornerGradients {
    std::vector<Mat3> sum;             // K, not yet divided
    std::vector<std::uint8_t> counts;  // K
};

// The sums over the cubes around those corners that carry something.
CornerGradients corner_gradients(const Binding& binding, const Cubes& cubes,
                                 std::span<const Vec3> x, std::span<const std::uint8_t> torn)
{
    CornerGradients g;
    g.sum.assign(cubes.corner_count(), Mat3::Zero());
    g.counts.assign(cubes.corner_count(), 0);
    std::vector<std::uint8_t> needed(cubes.corner_count(), 0);
    for (const std::uint32_t c : binding.used) {
        for (const std::uint32_t k : cubes.corners[c]) needed[k] = 1;
    }
    const int axis = flat_axis(cubes);
    const std::size_t upper = axis < 0 ? 0 : std::size_t{1} << axis;
    const std::vector<Vec3> normal = axis < 0 ? std::vector<Vec3>{} : plane_normals(cubes, x, torn);
    const double per_metre = 1 / cubes.size;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        if (!torn.empty() && torn[c] != 0) continue;
        const auto& corners = cubes.corners[c];
        for (std::size_t a = 0; a < 8; ++a) {
            const std::uint32_t k = corners[a];
            if (needed[k] == 0 || (a & upper) != 0) continue;
            for (std::size_t d = 0; d < 3; ++d) {
                const std::size_t bit = std::size_t{1} << d;
                const auto column = static_cast<Eigen::Index>(d);
                if (bit == upper) {
                    g.sum[k].col(column) += normal[k];
                } else {
                    g.sum[k].col(column) +=
                        per_metre * (x[corners[a | bit]] - x[corners[a & ~bit]]);
                }
            }
            ++g.counts[k];
        }
    }
    return g;
}

// cof(F) n, see embed_kernels.cpp.
Vec3 turned(const Mat3& F, const Vec3& n)
{
    return n.x() * F.col(1).cross(F.col(2)) + n.y() * F.col(2).cross(F.col(0)) +
           n.z() * F.col(0).cross(F.col(1));
}

}  // namespace

void smooth_normals(TriMesh& carried, const Binding& binding, const TriMesh& rest,
                    const Cubes& cubes, std::span<const Vec3> x, std::span<const std::uint8_t> torn)
{
    if (cubes.is_sheet()) return;
    const CornerGradients g = corner_gradients(binding, cubes, x, torn);
    const int axis = flat_axis(cubes);
    parallel_for(rest.normals.size(), normals_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const std::uint32_t v = binding.normal_vertex[n];
            if (v >= binding.cube.size()) continue;
            const std::uint32_t c = binding.used[binding.cube[v]];
            if (!torn.empty() && torn[c] != 0) continue;
            Vec3 p = binding.local[v].cwiseMax(0.0f).cwiseMin(1.0f).cast<double>();
            if (axis >= 0) p[axis] = 0;
            Mat3 F = Mat3::Zero();
            bool whole = true;
            for (std::size_t a = 0; a < 8; ++a) {
                const double w = (a & 1 ? p.x() : 1 - p.x()) * (a & 2 ? p.y() : 1 - p.y()) *
                                 (a & 4 ? p.z() : 1 - p.z());
                if (w == 0) continue;
                const std::uint32_t k = cubes.corners[c][a];
                whole = whole && g.counts[k] > 0;
                if (whole) F += w / double(g.counts[k]) * g.sum[k];
            }
            const Vec3 m = turned(F, rest.normals[n].cast<double>());
            const double length = m.norm();
            if (whole && length > 1e-12 && std::isfinite(length)) {
                carried.normals[n] = (m / length).cast<float>();
            }
        }
    });
}

}  // namespace geometry
