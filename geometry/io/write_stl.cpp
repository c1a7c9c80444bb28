// Binary STL.

#include "geometry/io/file_bytes.hpp"
#include "geometry/io/write_mesh.hpp"
#include "geometry/mesh/mesh.hpp"

#include <stdexcept>

namespace geometry {

std::string stl_bytes(const TriMesh& mesh, const FileFrame& frame)
{
    const auto& triangles = mesh.triangles();
    if (triangles.empty()) {
        throw std::invalid_argument("STL holds faces only, and the mesh has none: write points "
                                    "as PLY, OBJ or GLB");
    }
    std::string out = own_header(frame);
    out.resize(80, ' ');
    put_bytes(out, static_cast<std::uint32_t>(triangles.size()));
    out.reserve(84 + 50 * triangles.size());
    for (const auto& [a, b, c] : triangles) {
        const Vec3f &p = mesh.positions[a], &q = mesh.positions[b], &r = mesh.positions[c];
        const Vec3 n = (q - p).cast<double>().cross((r - p).cast<double>());
        const double length = n.norm();
        put_floats(out, length > 0 ? Vec3f((n / length).cast<float>()) : Vec3f(Vec3f::Zero()));
        put_floats(out, p);
        put_floats(out, q);
        put_floats(out, r);
        put_bytes(out, std::uint16_t(0));
    }
    return out;
}

}  // namespace geometry
