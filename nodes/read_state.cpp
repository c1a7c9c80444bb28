#include "geometry/io/read_positions.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace nodes::read_state {

using geometry::Vec3;

struct Inputs {
    graph::Wire<geometry::Cubes> cubes;
    std::filesystem::path path;
    double dt = 0;
    graph::Wire<physics::State> last;
};
struct Outputs {
    physics::State state;
};

constexpr const char* no_path = "expected the path of a file of corners, found none";

static graph::Faults check(const Inputs& in, const graph::Setting&)
{
    return in.path.empty() ? graph::Faults{{"path", no_path}} : graph::Faults{};
}

static void require_corners(const std::vector<geometry::Vec3f>& found, const Inputs& in)
{
    const std::string file = in.path.string();
    if (found.size() != in.cubes->corner_count()) {
        throw std::invalid_argument(
            fmt::format("{}: expected {} points, one for each corner of the cubes, found {}: write "
                        "the file from a CubeMesh of the same cubes",
                        file, in.cubes->corner_count(), found.size()));
    }
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (found[i].allFinite()) continue;
        throw std::invalid_argument(
            fmt::format("{}: expected finite coordinates, found others at point {}", file, i + 1));
    }
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (in.path.empty()) throw std::invalid_argument(no_path);
    const std::vector<geometry::Vec3f> found = geometry::read_positions(in.path, context.frame());
    require_corners(found, in);
    physics::State state;
    const double dt = in.dt > 0 ? in.dt : context.frame_seconds();
    const bool moved = in.last && in.last->x.size() == found.size();
    state.time = moved ? in.last->time + dt : 0;
    state.x.reserve(found.size());
    for (const geometry::Vec3f& p : found) state.x.emplace_back(p.cast<double>());
    state.v.assign(found.size(), Vec3::Zero());
    for (std::size_t i = 0; moved && i < found.size(); ++i) {
        state.v[i] = (state.x[i] - in.last->x[i]) / dt;
    }
    return {std::move(state)};
}

void add_to(graph::Registry& registry)
{
    registry.add("ReadState", 1, run)
        .summary("Reads the motion of the cubes' corners from files, so that any program can stand "
                 "in the place of Simulate.",
                 {"import", "external solver", "point cache", "pc2", "playback"})
        .input("cubes", &Inputs::cubes, "The cubes at rest.")
        .path_in("path", &Inputs::path,
                 "The file: the corners' positions in metres, y up, in the order of CubeMesh. PLY, "
                 "OBJ, or points as text (XYZ, PTS, ASC), where #### stands for the frame number; "
                 "or one point cache (PC2) for all frames.")
        .param("dt", &Inputs::dt,
               "Seconds between frames, for velocities; 0: the duration of a frame. The velocity "
               "of a corner is its displacement since the frame before, divided by this.",
               {.min = 0, .max = 1e4, .unit = "s"})
        .reads(graph::Variable::frame | graph::Variable::fps)
        .pace({graph::Pace::By::seconds_a_frame, "dt"})
        .check(check)
        .output("state", &Outputs::state,
                "Positions and velocities of the corners, for Embed, Render and Measure.")
        .previous("state", &Inputs::last);
}

}  // namespace nodes::read_state
