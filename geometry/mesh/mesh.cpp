#include "geometry/mesh/mesh.hpp"

namespace geometry {

Box bounds(const TriMesh& mesh)
{
    Box box;
    for (const Vec3f& p : mesh.positions) box.add(p.cast<double>());
    return box;
}

}  // namespace geometry
