#include "geometry/beside_program.hpp"
#include "geometry/polygonize.hpp"

#include <dlfcn.h>

#include <stdexcept>
#include <string>

namespace geometry {
namespace {

using Mesher = void (*)(const IsoField& field, double cell, double adaptivity, TriMesh& mesh);

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

TriMesh polygonize_openvdb(const IsoField& field, double cell, double adaptivity)
{
    static const Mesher mesher = load();
    TriMesh mesh;
    mesher(field, cell, adaptivity, mesh);
    return mesh;
}

}  // namespace geometry
