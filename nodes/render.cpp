#include "graph/document/frame_path.hpp"
#include "graph/document/json.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/render_balls.hpp"
#include "nodes/render_forces.hpp"
#include "nodes/render_hints.hpp"
#include "nodes/render_inputs.hpp"
#include "nodes/render_missing.hpp"
#include "nodes/render_things.hpp"
#include "nodes/render_unseen.hpp"
#include "nodes/render_upgrade.hpp"
#include "nodes/units.hpp"
#include "render/draw.hpp"
#include "render/four_views.hpp"
#include "render/stage.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <span>

namespace nodes::render {

static constexpr double degrees = 3.141592653589793 / 180;
static const Vec3f white{1, 1, 1};

static ::render::Look look_of(const Inputs& in)
{
    using ::render::Style;
    ::render::Look look;
    look.style = in.look;
    look.linear = in.linear;
    look.soft = in.look != Style::plain && in.quality != Quality::draft;
    look.light_size = in.light.size * degrees;
    look.occlusion = in.light.occlusion;
    look.rim = in.light.rim;
    look.width = in.width;
    look.height = in.height;
    look.antialias = ::render::Antialias(in.quality);
    look.shadow = in.light.shadow;
    look.light_azimuth = in.light.azimuth * degrees;
    look.light_elevation = in.light.elevation * degrees;
    look.light = static_cast<float>(in.light.strength) * in.light.colour;
    if (in.look != Style::plain) {  // a room of bright walls and floor
        look.light *= 0.82f;
        look.sky = {0.40f, 0.44f, 0.50f};
        look.bounce = {0.33f, 0.32f, 0.31f};
    }
    look.sky *= static_cast<float>(in.light.fill);
    look.bounce *= static_cast<float>(in.light.fill);
    look.floor = in.ground.colour;
    look.grid = in.ground.grid;
    look.backdrop_top = in.backdrop.top;
    look.backdrop_horizon = in.backdrop.horizon;
    look.glass = in.show.glass;
    look.shutter = in.motion_blur.shutter;
    look.exposures = in.motion_blur.samples;
    if (in.look == Style::diagram) look.floor = look.backdrop_top = look.backdrop_horizon = white;
    return look;
}

// The points of all frames, or else of the mesh at rest; with a floor below them, the stage goes
// down to that.
static std::span<const Vec3f> held_points(const Inputs& in)
{
    if (in.shot) return in.shot->positions;
    if (in.extent) return in.extent->points;
    return {};
}

// Beside the legend, where the camera fits what is drawn, with balls of `radius` about its points.
static ::render::Camera camera_of(const Inputs& in, const ::render::Scene& scene, int turns,
                                  double radius)
{
    const CameraParams& c = in.camera;
    if (in.view) return aimed_at(*in.view, scene.stage);
    if (c.kind == CameraParams::Kind::look_at) {
        const ::render::Camera stands{c.eye, c.target, {0, 1, 0}, c.field_of_view * degrees};
        return c.parallel ? ::render::parallel_from(stands) : stands;
    }
    const double turn = c.kind == CameraParams::Kind::turntable ? c.turn * turns : 0;
    const std::array<int, 2> size = c.views == CameraParams::Views::one
                                        ? std::array{in.width, in.height}
                                        : ::render::fourth_size(in.width, in.height);
    double legend = scene.legend ? ::render::width_of(*scene.legend, size[0], size[1]) : 0;
    if (legend > 0.45) legend = 0;  // a thumbnail: there is no beside
    const auto fit = [&](const auto& held) {
        return ::render::fit(held, (c.azimuth + turn) * degrees, c.elevation * degrees,
                             c.parallel ? ::render::parallel_view : c.field_of_view * degrees,
                             double(size[0]) / size[1], c.margin, legend);
    };
    const bool round = c.kind == CameraParams::Kind::turntable;
    const std::span<const Vec3f> points = held_points(in);
    if (c.hold == CameraParams::Hold::box || points.empty()) {
        geometry::Box held = scene.stage;
        if (!held.empty()) held.lo.array() -= radius, held.hi.array() += radius;
        return fit(held);
    }
    if (!round && !(radius > 0)) return fit(points);
    std::vector<Vec3f> held(points.begin(), points.end());
    if (radius > 0) held = with_balls(points, radius);
    if (round) held = ::render::turned_about(held);
    return fit(std::span<const Vec3f>(held));
}

static std::optional<double> ground_height(const GroundParams& ground, const geometry::Box& stage,
                                           const std::optional<double>& floor)
{
    if (ground.kind == GroundParams::Kind::none) return std::nullopt;
    if (ground.kind == GroundParams::Kind::at) return ground.height;
    if (floor) return floor;
    if (stage.empty()) return std::nullopt;
    return stage.lo.y();
}

constexpr const char* layers_told =
    "Layered scene whose surfaces are drawn without Polygonize: rays find them, exact in each "
    "pixel. Their one attribute is `compression`.";

constexpr const char* nothing_to_draw =
    "there is nothing to draw: link a mesh, layers, cubes, points, pins, forces or colliders";

// Empty where none has one, or some are not known.
static std::string units_of_values(const graph::Setting& setting)
{
    std::string units;
    std::size_t numbers = 0;
    bool any = false;
    for (const graph::LinkedNode& source : setting.sources) {
        if (source.input != "values") continue;
        const std::string unit = unit_of_linked(source);
        any = any || !unit.empty();
        units += (numbers++ > 0 ? "," : "") + unit;
    }
    return any && numbers == setting.links_of("values") ? units : std::string();
}

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    if (in.show.ghost > 0 && !setting.links("rest")) {
        return {{"show.ghost", "the ghost is the mesh at rest: link that to `rest`"}};
    }
    const std::string wrong = wrong_names(in.burn_in.names, setting.links_of("values"));
    if (!wrong.empty()) return {{"burn_in.names", wrong}};
    BurnInParams burn_in = in.burn_in;
    if (burn_in.units.empty()) burn_in.units = units_of_values(setting);
    if (setting.complete) setting.complete("burn_in.units", burn_in.units);
    const std::string units = wrong_units(burn_in, setting.links_of("values"));
    if (!units.empty()) return {{"burn_in.names", units}};
    const std::string still =
        wrong_before(in.motion_blur, setting.links_of("mesh"), setting.links_of("before"));
    if (!still.empty()) return {{"motion_blur.shutter", still}};
    const std::string range = range_wrong_before(in.colour);
    if (!range.empty()) return {{"colour.low", range}};
    if (in.camera.views == CameraParams::Views::four && std::min(in.width, in.height) < 16) {
        return {{"camera.views", "four views need a picture of at least 16 x 16 pixels"}};
    }
    constexpr std::array drawn{"mesh", "layers", "cubes", "points", "pins", "forces", "colliders"};
    if (std::none_of(drawn.begin(), drawn.end(), [&](auto p) { return setting.links(p); })) {
        return {{"", nothing_to_draw}};
    }
    if (!setting.upstream) return {};
    const std::vector<graph::LinkedNode> upstream = setting.upstream();
    graph::Faults hints = hint_of_floor(in.ground, upstream);
    const bool linked = setting.links("rest") || setting.links("shot");
    const bool stands = in.camera.kind == CameraParams::Kind::look_at || setting.links("view");
    const Held held{stands || linked, linked || setting.links("colliders")};
    for (auto& hint : hint_of_moving_view(in.ground, held, setting.frames, upstream)) {
        hints.push_back(std::move(hint));
    }
    return hints;
}

static ::render::Image picture_of(const Inputs& in, const ::render::Scene& scene,
                                  const ::render::Camera& camera,
                                  std::vector<std::string>& warnings,
                                  const std::function<void()>& check)
{
    const ::render::Look look = look_of(in);
    if (in.camera.views == CameraParams::Views::one) {
        return ::render::draw(scene, camera, look, &warnings, check);
    }
    geometry::Box box;
    for (const Vec3f& p : held_points(in)) box.add(p.cast<double>());
    if (box.empty() || in.camera.hold == CameraParams::Hold::box) box = scene.stage;
    return ::render::four_views(scene, box, camera, in.camera.margin, look, &warnings, check);
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    ::render::Scene scene;
    const Coloured by_attribute = coloured(in);
    require_displacement(in, by_attribute);
    warn_of_no_colours(in, context);
    add_legend(scene, in, by_attribute);
    add_meshes(scene, in, by_attribute.meshes);
    add_layers(scene, in);
    add_cubes(scene, in, by_attribute.cubes);
    add_points(scene, in);
    const geometry::Box drawn = ::render::bounds(scene);
    if (in.mesh.empty() && !in.layers && !in.cubes && !in.points && in.pins.empty() &&
        in.forces.empty() && in.colliders.empty()) {
        throw std::invalid_argument(nothing_to_draw);
    }
    const double radius = radius_of_balls(scene);
    const auto floor = ::render::solid_floor(in.colliders);
    scene.stage =
        ::render::stage_of(in.shot ? in.shot.get() : in.rest.get(), in.cubes.get(), drawn, floor);
    if (scene.stage.empty() && in.show.forces) scene.stage = stage_of_forces(in.forces);
    add_ghost(scene, in.show, in.rest, in.mesh, in.layout);
    add_loads(scene, in.show, {in.pins, forces_now(in), in.colliders}, in.cubes.get(),
              in.ground.kind);
    scene.ground = ground_height(in.ground, scene.stage, floor);
    if (!in.legend) scene.legend.reset();
    scene.label = burn_in_text(in.burn_in, in.values, context.frame(), context.time(),
                               graph::frame_text(in.label, context.frame()), context.slow_motion());

    const auto camera = camera_of(in, scene, context.frame() - context.range().first, radius);
    std::vector<std::string> warnings;
    const auto check = [&] {
        if (context.stop.stop_requested()) throw graph::Cancelled();
    };
    Outputs out{picture_of(in, scene, camera, warnings, check)};
    warn_of_boxes(scene, context);
    for (const std::string& text : warnings) context.warn(text);
    warn_of_unseen(in.camera.kind, bool(in.view), in.ground, double(in.width) / in.height, scene,
                   camera, drawn, floor.has_value(), context);
    return out;
}

static ::render::CubeShell prepare_shell(const Inputs& in)
{
    return in.cubes ? ::render::cube_shell(*in.cubes) : ::render::CubeShell{};
}

static ::render::SurfaceLayout prepare_layout(const Inputs& in)
{
    return in.rest ? ::render::surface_layout(*in.rest) : ::render::SurfaceLayout{};
}

static ::render::Extent prepare_extent(const Inputs& in)
{
    return in.rest ? ::render::extent_of(in.rest->positions) : ::render::Extent{};
}

constexpr const char* burn_in_told =
    "What else is written there, above the label: a line for each number of `values`, and what is "
    "asked for here.";

constexpr const char* forces_told =
    "Forces to draw as arrows, a torque as one with two heads along its axis. Those at a place of "
    "the rest shape go with the material there: by `cubes` and `state`, or else by a mesh of as "
    "many vertices as `rest`.";

void add_to(graph::Registry& registry)
{
    registry.add("Render", 2, run)
        .summary("Draws a lit picture of what is linked.",
                 {"camera", "picture", "draw", "viewport", "opengl", "light"})
        .upgrade(1,
                 "the default look was plain, with a grid on a dark floor; antialias became "
                 "quality; the camera held a box",
                 say_old_look)
        .inputs("mesh", &Inputs::mesh, "Meshes to draw; a point cloud as small balls.")
        .input("layers", &Inputs::layers, layers_told, graph::Need::optional)
        .input("rest", &Inputs::rest, rest_told, graph::Need::optional)
        .input("shot", &Inputs::shot, shot_told, graph::Need::optional)
        .input("view", &Inputs::view, view_told, graph::Need::optional)
        .input("cubes", &Inputs::cubes, "Cubes to draw.", graph::Need::optional)
        .input("state", &Inputs::state,
               "State of the cubes at this frame; without it they are drawn at rest.",
               graph::Need::optional)
        .input("points", &Inputs::points, "Points to draw as small balls.", graph::Need::optional)
        .inputs("pins", &Inputs::pins, "Pinned corners to mark.")
        .inputs("forces", &Inputs::forces, forces_told)
        .inputs("colliders", &Inputs::colliders, "Colliders to draw; a level plane is the floor.")
        .inputs("before", &Inputs::before, before_told)
        .inputs("values", &Inputs::values, "Numbers to show in the picture, as Measure gives them.")
        .prepare("shell", &Inputs::shell, prepare_shell, {"cubes"})
        .prepare("layout", &Inputs::layout, prepare_layout, {"rest"})
        .prepare("extent", &Inputs::extent, prepare_extent, {"rest"})
        .param("width", &Inputs::width, "Width of the picture.", {1, 8192, "px"})
        .param("height", &Inputs::height, "Height of the picture.", {1, 8192, "px"})
        .choice("look", &Inputs::look, {"studio", "clay", "diagram", "matcap", "plain"},
                "studio: materials in soft light, in a bright studio. clay: the same, all of one "
                "clay. diagram: flat colours with outlines on white. matcap: lit by the direction "
                "of the surface alone. plain: one hard light, the fastest.")
        .choice("quality", &Inputs::quality, {"draft", "preview", "standard", "final"},
                quality_told)
        .choice("linear", &Inputs::linear, {"none", "whole", "cut_out"}, linear_told)
        .block<CameraParams>("camera", &Inputs::camera, describe, "Viewpoint.")
        .block<LightParams>("light", &Inputs::light, describe,
                            "A key light that casts a shadow, and light from all around.")
        .block<GroundParams>("ground", &Inputs::ground, describe,
                             "A floor that receives the shadow.")
        .block<BackdropParams>("backdrop", &Inputs::backdrop, describe,
                               "Colours of the background.")
        .block<ColourParams>("colour", &Inputs::colour, describe, "Source of the colours.")
        .block<CubeParams>("cube", &Inputs::cube, describe, "How cubes are drawn.")
        .block<ShowParams>("show", &Inputs::show, describe,
                           "Which other things are drawn, and how.")
        .param("legend", &Inputs::legend, "Whether the picture has a legend for its colour scale.")
        .param("label", &Inputs::label,
               "Text in the lower left corner; #### stands for the frame number.")
        .block<BurnInParams>("burn_in", &Inputs::burn_in, describe, burn_in_told)
        .block<BlurParams>("motion_blur", &Inputs::motion_blur, describe,
                           "Blur of what moves while the shutter is open.")
        .reads(graph::Variable::frame | graph::Variable::range | graph::Variable::pace)
        .pace({graph::Pace::By::slow_motion, "burn_in.slow_motion"})
        .short_forms({name_values, {}})
        .check(check)
        .output("image", &Outputs::image, "The picture.");
}

}  // namespace nodes::render
