#include "render/compare.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::compare {

struct Inputs {
    graph::Wire<::render::Image> a, b;
    ::render::CompareMode mode = ::render::CompareMode::side_by_side;
    double wipe = 0.5, gain = 4;
    std::string label_a = "A", label_b = "B";
};
struct Outputs {
    ::render::Image image;
};

static Outputs run(const Inputs& in, const graph::Context&)
{
    return {::render::compare(*in.a, *in.b, {in.mode, in.wipe, in.gain, in.label_a, in.label_b})};
}

void add_to(graph::Registry& registry)
{
    registry.add("Compare", 1, run)
        .summary("Shows two pictures of one size side by side, wiped or subtracted.",
                 {"difference", "subtract", "a/b", "before and after", "split", "wipe"})
        .input("a", &Inputs::a, "The one picture, left of the other or of the line.")
        .input("b", &Inputs::b, "The other picture, as wide and high as `a`.")
        .choice("mode", &Inputs::mode, {"side_by_side", "wipe", "difference"},
                "side_by_side: both whole, in a picture twice as wide. wipe: `a` left of a line "
                "and `b` right of it. difference: how far `b` is from `a`, by a scale of colours.")
        .param("wipe", &Inputs::wipe,
               "Where the line stands, as a share of the width: 0 shows `b` alone, 1 `a` alone. "
               "Give it keys, and the line moves.",
               {0, 1}, {"mode", {"wipe"}})
        .param("gain", &Inputs::gain,
               "What differences are multiplied by: the scale ends at 100 % / `gain` of black to "
               "white, in all frames. The channel (red, green or blue) that differs most counts.",
               {0.1, 255}, {"mode", {"difference"}})
        .param("label_a", &Inputs::label_a, "Text at the top of `a`.")
        .param("label_b", &Inputs::label_b, "Text at the top of `b`.")
        .output("image", &Outputs::image,
                "The comparison, in 8-bit colours: linear light and depths are left out.");
}

}  // namespace nodes::compare
