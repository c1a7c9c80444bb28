#include "render/contact_sheet.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/scene_seconds.hpp"
#include "nodes/wire_types.hpp"
#include "nodes/written_path.hpp"
#include "render/captions.hpp"
#include "render/choose_frames.hpp"
#include "render/png.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace nodes::contact_sheet {

constexpr const char* no_value =
    "by value, frames are chosen by the number that is linked to `value`: link a Measure";

enum class Choose { spread, change, value };

struct Inputs {
    std::vector<graph::Wire<render::Image>> image;
    std::vector<graph::Wire<double>> value;
    Choose choose = Choose::spread;
    int count = 12, columns = 4, width = 1600;
    std::filesystem::path path = "contact_sheet.png";
};
struct Outputs {
    render::Image image;
    graph::WrittenFile file;
};

// All pictures are in memory until the sheet is laid out.
constexpr int most_looked_at = 500;

static std::vector<int> some_frames(const Inputs& in, const graph::FrameRange& range)
{
    const bool all = in.choose != Choose::spread;
    return render::spread_frames(range.first, range.last,
                                 all ? std::max(in.count, most_looked_at) : in.count);
}

// Places among those gathered, without those that stand for frames that were not cooked.
static std::vector<std::size_t> different_frames(const std::vector<int>& frames, std::size_t count)
{
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < count; ++i) {
        if (i == 0 || frames[i] != frames[i - 1]) places.push_back(i);
    }
    return places;
}

static std::vector<std::size_t> chosen_places(const Inputs& in, const std::vector<int>& frames)
{
    const auto places = different_frames(frames, in.image.size());
    if (in.choose == Choose::spread) return places;
    std::vector<std::size_t> chosen;
    if (in.choose == Choose::change) {
        std::vector<const render::Image*> pictures;
        for (const std::size_t i : places) pictures.push_back(in.image[i].get());
        chosen = render::spread_by_change(render::changes_of(pictures), std::size_t(in.count));
    } else {
        if (in.value.size() != in.image.size()) throw std::invalid_argument(no_value);
        std::vector<double> values;
        for (const std::size_t i : places) values.push_back(*in.value[i]);
        chosen = render::extremes_of(values, std::size_t(in.count));
    }
    for (std::size_t& place : chosen) place = places[place];
    return chosen;
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    const std::vector<int>& frames = context.gathered;
    std::vector<render::Tile> tiles;
    for (const std::size_t i : chosen_places(in, frames)) {
        const double time = context.range().time(frames[i]);
        tiles.push_back(
            {in.image[i].get(),
             fmt::format("frame {}   {}", frames[i], seconds_text(time, context.slow_motion()))});
        if (in.value.empty()) continue;
        tiles.back().label += "   " + render::number_text(*in.value[i]);
    }
    const auto path = context.output_folder / in.path;
    Outputs out{render::contact_sheet(tiles, in.columns, in.width), {path.string()}};
    render::write_png(path, out.image);
    return out;
}

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    if (in.choose == Choose::value && !setting.links("value")) return {{"choose", no_value}};
    return wrong_path(in.path, {".png"}, 1);
}

void add_to(graph::Registry& registry)
{
    registry.add("ContactSheet", 1, run)
        .summary(
            "Writes the pictures of several frames side by side into one PNG file: evenly "
            "spaced ones, or those where something happens. Seconds below them are those of the "
            "scene: by the `slow_motion` of Render where it is stated, or else by the `dt` of "
            "Simulate, Vibrate or ReadState.",
            {"montage", "thumbnails", "overview", "keyframes", "highlights"})
        .gather("image", &Inputs::image, some_frames, "The picture, read at the chosen frames.")
        .gather("value", &Inputs::value, some_frames,
                "A number of the same frames, as Measure gives it, which is written below each "
                "picture.",
                graph::Need::optional)
        .choice("choose", &Inputs::choose, {"spread", "change", "value"},
                "Which frames: `spread` takes evenly spaced ones; `change` takes them closer "
                "together the more the picture changes; `value` takes those where `value` turns "
                "back, the greatest swings first. These two look at all frames (at 500 evenly "
                "spaced ones, where there are more), hold their pictures in memory, and show fewer "
                "than `count` where fewer differ.")
        .param("count", &Inputs::count, "Number of frames, including the first and the last.",
               {1, 1000})
        .param("columns", &Inputs::columns, "Number of pictures in a row.", {1, 100})
        .param("width", &Inputs::width, "Width of the sheet.", {64, 8192, "px"})
        .path_out("path", &Inputs::path, "Path of the file, below the output folder.")
        .reads(graph::Variable::range | graph::Variable::pace)
        .check(check)
        .sink()
        .output("image", &Outputs::image, "The sheet.")
        .output("file", &Outputs::file, "The written file.");
}

}  // namespace nodes::contact_sheet
