#include "render/trail.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::trail {

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh, last;
    ::render::TrailOf of = ::render::TrailOf::centre;
    int every = 20;
    std::string part;
    int frames = 24;
    double width = 0;
    geometry::Vec3f colour = ::render::TrailLook{}.colour, pale = ::render::TrailLook{}.pale;
    double fade = ::render::TrailLook{}.fade, opacity = 1, taper = ::render::TrailLook{}.taper;
};
struct Outputs {
    geometry::TriMesh mesh, points;
};

static Outputs run(const Inputs& in, const graph::Context& context)
{
    const auto places = ::render::trail_places(*in.mesh, in.of, in.every, in.part);
    const double width = in.width > 0 ? in.width : 0.02 * geometry::bounds(*in.mesh).diagonal();
    const double second = context.frame_seconds() / context.slow_motion();  // of the scene
    Outputs out;
    out.points = ::render::remember(in.last.get(), places, in.frames, second, float(width));
    out.mesh = ::render::trail_tubes(
        out.points, {in.colour, in.pale, in.fade, in.opacity, in.taper, in.frames * second});
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Trail", 1, run)
        .summary("Draws the paths of points of a moving mesh over the last frames as thin tubes "
                 "that fade with age.",
                 {"path", "motion path", "trajectory", "trace", "streamer", "motion trail"})
        .input("mesh", &Inputs::mesh, "The moving mesh.")
        .choice("of", &Inputs::of, {"centre", "pieces", "vertices"},
                "Whose paths: the mean of all vertices, the mean of each separate piece, or "
                "vertices.")
        .param("every", &Inputs::every, "Number of vertices from one path to the next.",
               {1, 100'000'000}, {"of", {"vertices"}})
        .param("part", &Inputs::part,
               "Name of the material or group whose vertices leave paths; empty: all.", {},
               {"of", {"vertices"}})
        .param("frames", &Inputs::frames, "Number of frames that a path reaches back.",
               {1, 100'000})
        .param("width", &Inputs::width,
               "Diameter of the tubes; 0: a fiftieth of the mesh's diagonal in the first frame.",
               {0, 1e6, "m"})
        .colour("colour", &Inputs::colour, "Colour of the newest end.")
        .colour("pale", &Inputs::pale, "Colour towards which older parts are faded.")
        .param("fade", &Inputs::fade, "How much of that colour the oldest end has.", {0, 1})
        .param("opacity", &Inputs::opacity,
               "Opacity of the oldest end. Below 1, pictures of quality `standard` take up to 1.7 "
               "times as long.",
               {0, 1})
        .param("taper", &Inputs::taper, "Share of the width that the oldest end has lost.", {0, 1})
        .reads(graph::Variable::fps | graph::Variable::pace)
        .output("mesh", &Outputs::mesh,
                "The tubes, for Render beside the mesh, with the attributes `age` (s) and `speed` "
                "(m/s), in the time of the scene: with the `dt` of Simulate, Vibrate or "
                "ReadState, a speed is that of the body. Straight lines join the places of one "
                "frame and the next. They begin anew "
                "where the number of points changes, as in a mesh that tears.")
        .output("points", &Outputs::points,
                "The places alone, frame by frame, the oldest first, with the attributes `age` (s) "
                "and `diameter` (m).")
        .previous("points", &Inputs::last);
}

}  // namespace nodes::trail
