#include "geometry/mesh/copies.hpp"

#include "geometry/base/srgb.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/mesh.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace geometry {

Vec3f turn_hue(const Vec3f& colour, double degrees)
{
    // On the hexagon of hues: which sixth, how far into it, and the way back.
    const Vec3f c = srgb_from_linear(colour);
    const float high = c.maxCoeff(), low = c.minCoeff(), spread = high - low;
    if (!(spread > 0)) return colour;
    const float hue = high == c[0]   ? (c[1] - c[2]) / spread
                      : high == c[1] ? (c[2] - c[0]) / spread + 2
                                     : (c[0] - c[1]) / spread + 4;
    const double turned = std::remainder(double(hue) + degrees / 60, 6.0);
    Vec3f out;
    for (int d = 0; d < 3; ++d) {
        const double away = std::abs(std::remainder(turned - 2 * d, 6.0));  // 0 .. 3
        out[d] = low + spread * float(std::clamp(2 - away, 0.0, 1.0));
    }
    return linear_from_srgb(out);
}

namespace {

// The names of the groups of copy `number`, counted from 1.
std::vector<std::string> numbered(std::vector<std::string> groups, std::size_t number)
{
    if (groups.empty()) groups.emplace_back();
    for (std::string& g : groups) {
        g = g.empty() ? fmt::format("{}", number) : fmt::format("{} {}", g, number);
    }
    return groups;
}

}  // namespace

TriMesh copies(const TriMesh& mesh, const CopiesLayout& layout)
{
    double total = 1;
    for (const int n : layout.count) {
        if (n < 1) {
            throw std::invalid_argument(
                fmt::format("expected at least 1 copy along each axis, found {}, {} and {}",
                            layout.count[0], layout.count[1], layout.count[2]));
        }
        total *= n;
    }
    if (total * double(std::max<std::size_t>(1, mesh.positions.size())) > 0xffff'ffff) {
        throw std::invalid_argument(
            fmt::format("{} copies of {} vertices exceed the limit of 2^32 - 1 vertices", total,
                        mesh.positions.size()));
    }
    std::vector<TriMesh> all;
    all.reserve(std::size_t(total));
    const auto [nx, ny, nz] = layout.count;
    const Vec3 middle = 0.5 * Vec3(nx - 1, ny - 1, nz - 1).cwiseProduct(layout.step) +
                        (ny > 1 ? 0.5 : 0.0) * layout.stagger;
    for (int y = 0; y < ny; ++y) {
        for (int z = 0; z < nz; ++z) {
            for (int x = 0; x < nx; ++x) {
                stop_if_asked();
                const Vec3 by = Vec3(x, y, z).cwiseProduct(layout.step) +
                                double(y % 2) * layout.stagger - middle;
                const double hue = std::fmod(layout.hue_degrees * double(all.size()), 360.0);
                TriMesh& copy = all.emplace_back(mesh);
                for (Vec3f& p : copy.positions) p = (p.cast<double>() + by).cast<float>();
                if (hue == 0 && !layout.number_groups) continue;
                MeshTopology topology = *mesh.topology;
                if (layout.number_groups) topology.groups = numbered(topology.groups, all.size());
                if (hue != 0) {
                    for (Material& m : topology.materials) m.colour = turn_hue(m.colour, hue);
                    for (Vec3f& c : copy.colours) c = turn_hue(c, hue);
                }
                copy.topology = std::make_shared<const MeshTopology>(std::move(topology));
            }
        }
    }
    std::vector<const TriMesh*> each;
    for (const TriMesh& copy : all) each.push_back(&copy);
    return merge(each);
}

}  // namespace geometry
