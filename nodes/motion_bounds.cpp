#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "render/extent.hpp"

namespace nodes::motion_bounds {

struct Inputs {
    std::vector<graph::Wire<geometry::TriMesh>> mesh;
};
struct Outputs {
    geometry::TriMesh points;
};

static std::vector<int> all_frames(const Inputs&, const graph::FrameRange& range)
{
    std::vector<int> frames;
    for (int f = range.first; f <= range.last; ++f) frames.push_back(f);
    return frames;
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    const std::vector<int>& frames = context.gathered;
    Outputs out;
    for (std::size_t i = 0; i < in.mesh.size(); ++i) {
        if (i > 0 && frames[i] == frames[i - 1]) continue;  // stands for one that was not cooked
        if (context.stop.stop_requested()) throw graph::Cancelled();
        const ::render::Extent extent = ::render::extent_of(in.mesh[i]->positions);
        out.points.positions.insert(out.points.positions.end(), extent.points.begin(),
                                    extent.points.end());
    }
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("MotionBounds", 1, run)
        .summary("Gathers the outermost points of a mesh over all frames that are cooked, for a "
                 "camera that holds the whole motion.",
                 {"camera", "framing", "fit", "bounding box", "extent", "range"})
        .gather("mesh", &Inputs::mesh, all_frames,
                "The moving mesh, read at every cooked frame. Merge joins several into one.")
        .reads(graph::Variable::range)
        .output("points", &Outputs::points,
                "The outermost points of each frame, along 162 directions: link them to `shot` of "
                "Render.");
}

}  // namespace nodes::motion_bounds
