#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "render/contact_sheet.hpp"
#include "render/fade.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

namespace nodes::onion {

struct Inputs {
    std::vector<graph::Wire<geometry::TriMesh>> mesh;
    enum class Choose { spread, every, list } choose = Choose::spread;
    int count = 6, every = 10;
    std::string frames = "1, 12, 24";
    geometry::Vec3f colour = ::render::Fade{}.colour;
    double fade = 0.8, opacity = 1;
};
struct Outputs {
    geometry::TriMesh mesh;
};

static bool outside(int frame, const graph::FrameRange& range)
{
    return frame < range.first || frame > range.last;
}

constexpr int most_frames = 1000;

// Empty where `every` takes no more of so many frames than can be merged.
static std::string too_many(int every, int frames)
{
    if ((frames - 1) / every < most_frames) return {};
    return fmt::format("every = {} takes {} of {} frames, and at most {} become one mesh: set "
                       "`every` to {} or more",
                       every, (frames - 1) / every + 1, frames, most_frames,
                       (frames - 1) / most_frames + 1);
}

// In order, each once. Of a list, those that are cooked, or else the last.
static std::vector<int> chosen_frames(const Inputs& in, const graph::FrameRange& range)
{
    std::vector<int> frames;
    if (in.choose == Inputs::Choose::spread) {
        return ::render::spread_frames(range.first, range.last, in.count);
    }
    if (in.choose == Inputs::Choose::every) {
        const std::string why = too_many(in.every, range.count());
        if (!why.empty()) throw std::invalid_argument(why);
        // Back from the last one, which is the one that is not faded.
        for (int f = range.last; f >= range.first; f -= in.every) frames.push_back(f);
    } else {
        frames = ::render::numbers_in(in.frames);
        std::erase_if(frames, [&](int f) { return outside(f, range); });
        if (frames.empty()) frames.push_back(range.last);
    }
    std::sort(frames.begin(), frames.end());
    frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
    return frames;
}

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    if (in.choose == Inputs::Choose::every) {
        const std::string why = too_many(in.every, setting.frames);
        if (!why.empty()) return {{"every", why}};
    }
    if (in.choose != Inputs::Choose::list) return {};
    try {
        ::render::numbers_in(in.frames);
    } catch (const std::invalid_argument& error) {
        return {{"frames", error.what()}};
    }
    return {};
}

static void warn_of_others(const Inputs& in, const graph::Context& context)
{
    const graph::FrameRange& range = context.range();
    const std::vector<int>& held = context.gathered;
    for (const int frame : ::render::numbers_in(in.frames)) {
        if (outside(frame, range)) {
            context.warn(
                fmt::format("frame {} of `frames` is left out: the graph has frames {} to {}",
                            frame, range.first, range.last));
        } else if (std::find(held.begin(), held.end(), frame) == held.end()) {
            context.warn(fmt::format(
                "frame {} of `frames` is left out: it is not among those cooked now", frame));
        }
    }
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    const std::vector<int>& frames = context.gathered;
    std::vector<graph::Wire<geometry::TriMesh>> meshes;
    for (std::size_t i = 0; i < in.mesh.size(); ++i) {
        if (i > 0 && frames[i] == frames[i - 1]) continue;  // stands for one that was not cooked
        meshes.push_back(in.mesh[i]);
    }
    if (in.choose == Inputs::Choose::list) warn_of_others(in, context);
    return {::render::onion_skin(meshes, {in.colour, in.fade, in.opacity})};
}

void add_to(graph::Registry& registry)
{
    registry.add("Onion", 1, run)
        .summary("Merges a moving mesh at several frames into one, earlier ones faded, so that one "
                 "picture shows the motion.",
                 {"onion skin", "stroboscope", "trail", "motion", "echo", "time offset"})
        .gather("mesh", &Inputs::mesh, chosen_frames, "The moving mesh, read at the chosen frames.")
        .choice("choose", &Inputs::choose, {"spread", "every", "list"},
                "Which frames: `spread` takes `count` of them, from the first to the last; `every` "
                "takes every n-th, back from the last; `list` takes those of `frames`.")
        .param("count", &Inputs::count, "Number of frames, including the first and the last.",
               {1, 1000}, {"choose", {"spread"}})
        .param("every", &Inputs::every,
               "Number of frames from one to the next; at most 1000 are taken.", {1, 100000},
               {"choose", {"every"}})
        .param("frames", &Inputs::frames, "The frames, parted by commas.", {}, {"choose", {"list"}})
        .colour("colour", &Inputs::colour, "Colour towards which earlier frames are faded.")
        .param("fade", &Inputs::fade,
               "How much of that colour the earliest frame has; the last has none, and those "
               "between are evenly in between.",
               {0, 1})
        .param("opacity", &Inputs::opacity,
               "Opacity of the earliest frame. Below 1, pictures of quality `standard` take "
               "up to 1.7 times as long.",
               {0, 1})
        .check(check)
        .reads(graph::Variable::range)
        .output("mesh", &Outputs::mesh,
                "The merged mesh, the same at all frames, with faded materials and vertex "
                "colours. Earlier frames lose textures where they fade to the colour.");
}

}  // namespace nodes::onion
