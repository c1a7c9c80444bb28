#include "geometry/beside_program.hpp"
#include "geometry/iso_grid.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <stdexcept>
#include <string>

namespace geometry {
namespace {

using Mesher = void (*)(const IsoField& field, double cell, double adaptivity,
                        std::size_t max_triangles, TriMesh& mesh);

// From geometry/openvdb/mesher.cpp. Loaded when it is first asked for: OpenVDB would take 50 ms of
// every start.
Mesher load()
{
    const std::filesystem::path library = beside_program("libaspic-openvdb.so");
    if (library.empty()) {
        throw std::runtime_error(
            "this program was built without OpenVDB: install the Debian packages libopenvdb-dev "
            "and "
            "libboost-iostreams-dev, run `cmake --preset release`, and build again");
    }
    void* const module = ::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
    void* const mesher = module ? ::dlsym(module, "aspic_polygonize_openvdb") : nullptr;
    if (!mesher) {
        throw std::runtime_error(std::string("OpenVDB's mesher could not be loaded: ") +
                                 ::dlerror() + "; install what is missing, or build again");
    }
    return reinterpret_cast<Mesher>(mesher);
}

}  // namespace

TriMesh polygonize_openvdb(const IsoField& field, double cell, double adaptivity,
                           std::size_t max_triangles)
{
    static const Mesher mesher = load();
    TriMesh mesh;
    max_triangles = std::min(max_triangles, unlimited);
    try {
        mesher(field, cell, adaptivity, max_triangles, mesh);
    } catch (const TooManyTriangles&) {
        throw too_many_triangles(field, cell, max_triangles);
    }
    return mesh;
}

}  // namespace geometry
