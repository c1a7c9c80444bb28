#include "geometry/cubes/sample_points.hpp"

#include "geometry/mesh/mesh.hpp"

#include <algorithm>
#include <stdexcept>

namespace geometry {

Samples sample_points(const TriMesh& cloud, const Matter& matter, const SampleMass& mass)
{
    if (mass.by == SampleMass::By::surface_density) {
        throw std::invalid_argument("the points of a point cloud have no area: set the mass by "
                                    "density or total");
    }
    Samples out;
    Box box;
    for (const Vec3f& p : cloud.positions) {
        if (!p.allFinite()) continue;
        out.positions.push_back(p);
        box.add(p.cast<double>());
    }
    if (out.positions.empty()) {
        throw std::invalid_argument("the mesh has neither triangles nor points to sample");
    }
    const auto n = static_cast<double>(out.positions.size());
    const double longest = std::max(box.size().maxCoeff(), 1e-3);
    const double each = longest * longest * longest / n;  // m^3: only its ratios count
    out.matters = {matter};
    out.matter.assign(out.positions.size(), 0);
    out.mass.assign(out.positions.size(), static_cast<float>(each * matter.density));
    out.bulk = 0;
    if (mass.by == SampleMass::By::total) scale_mass(out, mass.total);
    return out;
}

}  // namespace geometry
