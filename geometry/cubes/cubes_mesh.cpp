#include "geometry/cubes/cubes_mesh.hpp"

#include "geometry/base/stop.hpp"
#include "geometry/cubes/local_matter.hpp"
#include "geometry/cubes/sheet.hpp"
#include "geometry/mesh/mesh.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace geometry {
namespace {

using Quad = std::array<std::uint32_t, 4>;

// A side of a cube as its corners, counter-clockwise from outside. Axis d, at its high or low end.
Quad side(const std::array<std::uint32_t, 8>& corners, unsigned d, bool high)
{
    const unsigned e = 1u << (d + 1) % 3, f = 1u << (d + 2) % 3, base = high ? 1u << d : 0;
    const Quad q{corners[base], corners[base | e], corners[base | e | f], corners[base | f]};
    return high ? q : Quad{q[0], q[3], q[2], q[1]};
}

// A side, and what is equal for the two cubes that share it.
struct Side {
    Quad key, quad;
};

std::vector<Triangle> outer_faces(const Cubes& cubes)
{
    if (cubes.is_sheet()) return sheet_mesh(cubes).triangles();
    std::vector<Side> sides;
    sides.reserve(6 * cubes.count());
    StopCheck check;
    for (const auto& corners : cubes.corners) {
        check();
        for (unsigned d = 0; d < 3; ++d) {
            for (const bool high : {false, true}) {
                const Quad quad = side(corners, d, high);
                Quad key = quad;
                std::sort(key.begin(), key.end());
                sides.push_back({key, quad});
            }
        }
    }
    stop_if_asked();
    std::stable_sort(sides.begin(), sides.end(),
                     [](const Side& a, const Side& b) { return a.key < b.key; });
    std::vector<Triangle> faces;
    stop_if_asked();
    for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
        while (end < sides.size() && sides[end].key == sides[begin].key) ++end;
        if (end - begin > 1) continue;
        const Quad& q = sides[begin].quad;
        faces.push_back({q[0], q[1], q[2]});
        faces.push_back({q[0], q[2], q[3]});
    }
    return faces;
}

// At each corner the mean of its cubes' values.
Attribute at_corners(const Cubes& cubes, const std::vector<double>& values, const std::string& name,
                     const std::string& unit)
{
    const std::size_t corners = cubes.is_sheet() ? 3 : 8;  // those of a triangle come first
    std::vector<double> sum(cubes.corner_count(), 0.0), count(cubes.corner_count(), 0.0);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        for (std::size_t a = 0; a < corners; ++a) {
            const std::uint32_t k = cubes.corners[c][a];
            sum[k] += values[c];
            count[k] += 1;
        }
    }
    Attribute out{name, unit, std::vector<float>(sum.size())};
    for (std::size_t k = 0; k < sum.size(); ++k) {
        out.values[k] = static_cast<float>(sum[k] / std::max(1.0, count[k]));
    }
    return out;
}

}  // namespace

TriMesh cubes_mesh(const Cubes& cubes, std::span<const Vec3> x)
{
    if (x.size() != cubes.corner_count()) {
        throw std::invalid_argument("the state is not one of these cubes: expected " +
                                    std::to_string(cubes.corner_count()) + " corners, found " +
                                    std::to_string(x.size()));
    }
    TriMesh out;
    out.positions.reserve(x.size());
    for (const Vec3& p : x) out.positions.push_back(p.cast<float>());
    auto topology = std::make_shared<MeshTopology>();
    topology->triangles = outer_faces(cubes);
    out.topology = std::move(topology);
    out.attributes = {at_corners(cubes, material_densities(cubes), "density", "kg/m^3"),
                      at_corners(cubes, cubes.young, "young", "Pa"),
                      at_corners(cubes, cubes.poisson, "poisson", ""),
                      at_corners(cubes, cubes.fill, "fill", "")};
    for (const CubeAttribute& a : cubes.attributes) {
        out.attributes.push_back(at_corners(cubes, a.values, a.name, a.unit));
    }
    return out;
}

}  // namespace geometry
