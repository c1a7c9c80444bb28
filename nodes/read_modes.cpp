#include "physics/modal/modal_file.hpp"

#include "geometry/base/whole_file.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace nodes::read_modes {

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh;
    std::filesystem::path path;
};
struct Outputs {
    physics::ModalModel model;
    double lowest_frequency = 0;
};

constexpr const char* no_path = "expected the path of a file of modes, found none";

static graph::Faults check(const Inputs& in, const graph::Setting&)
{
    return in.path.empty() ? graph::Faults{{"path", no_path}} : graph::Faults{};
}

static Outputs run(const Inputs& in, const graph::Context&)
{
    if (in.path.empty()) throw std::invalid_argument(no_path);
    const auto bytes = geometry::read_whole_file(in.path);
    if (!bytes) throw std::runtime_error(in.path.string() + " cannot be read");
    Outputs out;
    try {
        out.model = physics::read_modal_file(*bytes, in.mesh);
    } catch (const std::runtime_error& error) {
        throw std::runtime_error(in.path.string() + ": " + error.what());
    }
    double lowest = std::numeric_limits<double>::infinity();
    for (const double omega_sq : out.model.omega_sq) {  // in the order of the file
        if (omega_sq > 0) lowest = std::min(lowest, omega_sq);
    }
    if (std::isfinite(lowest)) out.lowest_frequency = std::sqrt(lowest) / (2 * std::numbers::pi);
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("ReadModes", 1, run)
        .summary("Reads vibration modes of a mesh from a file of WriteModes or of another program. "
                 "No cubes and no solver are needed to play them.",
                 {"import", "modal", "eigenmodes"})
        .input("mesh", &Inputs::mesh,
               "The mesh at rest. Its vertices are those of the file, in the same order.")
        .path_in("path", &Inputs::path, "The file. recipes.md describes the format.")
        .check(check)
        .output("model", &Outputs::model, "The modes at the vertices, for Vibrate.")
        .output("lowest_frequency", &Outputs::lowest_frequency,
                "Frequency of the lowest mode that is not a rigid motion, Hz; 0 if there is none.");
}

}  // namespace nodes::read_modes
