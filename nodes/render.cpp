#include "geometry/measure.hpp"
#include "geometry/mesh_edges.hpp"
#include "graph/frame_path.hpp"
#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"
#include "render/cube_quantity.hpp"
#include "render/draw.hpp"
#include "render/legend.hpp"
#include "render/marker.hpp"

#include <cmath>

namespace nodes::render {

using geometry::Vec3;
using geometry::Vec3f;

static constexpr double degrees = 3.141592653589793 / 180;

struct CameraParams {
    enum class Kind { fit, turntable, look_at } kind = Kind::fit;
    double azimuth = 35, elevation = 20, turn = 3, margin = 0.06;
    Vec3 eye{3, 2, 4}, target{0, 0, 0};
    double field_of_view = 28;
};

struct LightParams {
    double azimuth = -25, elevation = 50, strength = 1, fill = 1;
    Vec3f colour{1, 0.95f, 0.87f};
    ::render::ShadowQuality shadow = ::render::ShadowQuality::medium;
};

struct GroundParams {
    enum class Kind { none, under, at } kind = Kind::under;
    double height = 0;
    bool grid = true;
    Vec3f colour = ::render::Look{}.floor;
};

struct BackdropParams {
    Vec3f top = ::render::Look{}.backdrop_top, horizon = ::render::Look{}.backdrop_horizon;
};

struct ColourParams {
    ::render::Paint::By by = ::render::Paint::By::material;
    Vec3f constant{0.6f, 0.6f, 0.6f};
    std::string attribute = "displacement";
    ::render::ColourMap map = ::render::ColourMap::viridis;
    enum class Range { fit, fixed } range = Range::fit;
    double low = 0, high = 1;
};

struct CubeParams {
    enum class Draw { none, wire, solid } draw = Draw::solid;
    bool by_attribute = false;
    double scale = 0.94;
};

struct ShowParams {
    bool pins = true, forces = true, colliders = true, edges = false;
    double point_size = 0;
};

struct Inputs {
    std::vector<graph::Wire<geometry::TriMesh>> mesh;
    graph::Wire<geometry::TriMesh> rest;
    graph::Wire<geometry::Cubes> cubes;
    graph::Wire<physics::State> state;
    graph::Wire<geometry::Samples> points;
    std::vector<graph::Wire<physics::Pins>> pins;
    std::vector<graph::Wire<physics::Force>> forces;
    std::vector<graph::Wire<physics::Collider>> colliders;
    std::shared_ptr<const ::render::CubeShell> shell;
    std::shared_ptr<const ::render::SurfaceLayout> layout;
    int width = 960, height = 540;
    ::render::Antialias antialias = ::render::Antialias::fxaa;
    CameraParams camera;
    LightParams light;
    GroundParams ground;
    BackdropParams backdrop;
    ColourParams colour;
    CubeParams cube;
    ShowParams show;
    bool legend = true;
    std::string label;
};
struct Outputs {
    ::render::Image image;
};

static void describe(graph::ParamsOf<CameraParams>& p)
{
    p.choice("kind", &CameraParams::kind, {"fit", "turntable", "look_at"},
             "`fit` holds the whole stage in the picture; `turntable` does too, and goes round it; "
             "`look_at` stands at `eye`.")
        .param("azimuth", &CameraParams::azimuth,
               "Where the camera stands, seen from above: 0 towards +z, 90 towards +x.",
               {.unit = "deg"}, {"kind", {"fit", "turntable"}})
        .param("elevation", &CameraParams::elevation,
               "How far above the horizon the camera stands.", {-89, 89, "deg"},
               {"kind", {"fit", "turntable"}})
        .param("turn", &CameraParams::turn, "How far the camera goes round in each frame.",
               {.unit = "deg"}, {"kind", {"turntable"}})
        .param(
            "margin", &CameraParams::margin,
            "Share of the picture's width and height left free on each side; on the right as much "
            "as a legend takes, where that is more.",
            {0, 0.45}, {"kind", {"fit", "turntable"}})
        .param("eye", &CameraParams::eye, "Where the camera stands.", {.unit = "m"},
               {"kind", {"look_at"}})
        .param("target", &CameraParams::target, "What the camera looks at.", {.unit = "m"},
               {"kind", {"look_at"}})
        .param("field_of_view", &CameraParams::field_of_view,
               "Angle that the picture's height spans; small flattens perspective.",
               {1, 150, "deg"});
}

static void describe(graph::ParamsOf<LightParams>& p)
{
    p.param("azimuth", &LightParams::azimuth,
            "Where the key light comes from, seen from above: 0 from +z, 90 from +x.",
            {.unit = "deg"})
        .param("elevation", &LightParams::elevation, "How far above the horizon the key light is.",
               {1, 90, "deg"})
        .param("strength", &LightParams::strength, "Strength of the key light.", {0, 20})
        .param("fill", &LightParams::fill, "Strength of the light from all around.", {0, 20})
        .colour("colour", &LightParams::colour, "Colour of the key light.")
        .choice("shadow", &LightParams::shadow, {"off", "low", "medium", "high"},
                "Fineness of the key light's shadow: none, or 512, 1024 or 2048 squared texels.");
}

static void describe(graph::ParamsOf<GroundParams>& p)
{
    p.choice(
         "kind", &GroundParams::kind, {"none", "under", "at"},
         "The floor: `none`, `under` the stage (on a linked level collider where there is one), or "
         "`at` a height.")
        .param("height", &GroundParams::height, "Height of the floor.", {.unit = "m"},
               {"kind", {"at"}})
        .param("grid", &GroundParams::grid,
               "Lines on the floor a power of ten metres apart, every tenth one stronger.")
        .colour("colour", &GroundParams::colour, "Colour of the floor.");
}

static void describe(graph::ParamsOf<BackdropParams>& p)
{
    p.colour("top", &BackdropParams::top, "Colour of the backdrop overhead.")
        .colour("horizon", &BackdropParams::horizon,
                "Colour of the backdrop at the horizon, into which the floor fades.");
}

static void describe(graph::ParamsOf<ColourParams>& p)
{
    p.choice(
         "by", &ColourParams::by, {"material", "constant", "vertex", "attribute"},
         "What colours the meshes: their materials, one colour, their vertices' own colours, or "
         "an attribute through a scale.")
        .colour("constant", &ColourParams::constant, "The one colour.", {"by", {"constant"}})
        .param(
            "attribute", &ColourParams::attribute,
            "Name of the attribute: `displacement`, `speed`, `stress`, or any other that the mesh "
            "carries. Displacement from `rest` needs no attribute. Cubes also know `fill`, "
            "`young`, `density`, `component` and `matter`.")
        .choice("map", &ColourParams::map, {"viridis", "diverging", "grey"},
                "Colours of the scale: `diverging` is for values of both signs.")
        .choice("range", &ColourParams::range, {"fit", "fixed"},
                "`fit` holds the values of each frame, widened to round numbers; `fixed` runs from "
                "`low` to `high`, so that frames can be compared.")
        .param("low", &ColourParams::low, "Value at the scale's low end.", {}, {"range", {"fixed"}})
        .param("high", &ColourParams::high, "Value at the scale's high end.", {},
               {"range", {"fixed"}});
}

static void describe(graph::ParamsOf<CubeParams>& p)
{
    p.choice("draw", &CubeParams::draw, {"none", "wire", "solid"},
             "How linked cubes are drawn: not at all, their edges, or solid.")
        .param("by_attribute", &CubeParams::by_attribute,
               "Whether solid cubes take the colour of `colour.attribute`; otherwise that of their "
               "component.")
        .param("scale", &CubeParams::scale,
               "Size at which a solid cube is drawn, as a share of its own, so that neighbours can "
               "be told apart.",
               {0.05, 1});
}

static void describe(graph::ParamsOf<ShowParams>& p)
{
    p.param("pins", &ShowParams::pins, "Whether linked pins are marked.")
        .param("forces", &ShowParams::forces, "Whether linked forces are drawn as arrows.")
        .param("colliders", &ShowParams::colliders, "Whether linked colliders are drawn.")
        .param("edges", &ShowParams::edges, "Whether the edges of the meshes' faces are drawn.")
        .param("point_size", &ShowParams::point_size,
               "Diameter of linked points; 0 chooses it by the size of the stage.", {0, 1e9, "m"});
}

static ::render::Look look_of(const Inputs& in)
{
    ::render::Look look;
    look.width = in.width;
    look.height = in.height;
    look.antialias = in.antialias;
    look.shadow = in.light.shadow;
    look.light_azimuth = in.light.azimuth * degrees;
    look.light_elevation = in.light.elevation * degrees;
    look.light = static_cast<float>(in.light.strength) * in.light.colour;
    look.sky *= static_cast<float>(in.light.fill);
    look.bounce *= static_cast<float>(in.light.fill);
    look.floor = in.ground.colour;
    look.grid = in.ground.grid;
    look.backdrop_top = in.backdrop.top;
    look.backdrop_horizon = in.backdrop.horizon;
    return look;
}

// Beside the legend, where the camera fits what is drawn.
static ::render::Camera camera_of(const Inputs& in, const ::render::Scene& scene, int turns)
{
    const CameraParams& c = in.camera;
    if (c.kind == CameraParams::Kind::look_at) {
        return {c.eye, c.target, {0, 1, 0}, c.field_of_view * degrees};
    }
    const double turn = c.kind == CameraParams::Kind::turntable ? c.turn * turns : 0;
    double legend = scene.legend ? ::render::width_of(*scene.legend, in.width, in.height) : 0;
    if (legend > 0.45) legend = 0;  // a thumbnail: there is no beside
    return ::render::fit(scene.stage, (c.azimuth + turn) * degrees, c.elevation * degrees,
                         c.field_of_view * degrees, double(in.width) / in.height, c.margin, legend);
}

// The scale for `values`, and what its legend says.
static ::render::Legend legend_for(const ColourParams& colour, const geometry::Attribute& values)
{
    ::render::Legend legend{values.name, values.unit, {colour.map, 0, 1}};
    if (colour.range == ColourParams::Range::fit) {
        const auto range = ::render::round_range(values.values);
        legend.scale.low = range[0];
        legend.scale.high = range[1];
    } else {
        legend.scale.low = static_cast<float>(colour.low);
        legend.scale.high = static_cast<float>(colour.high);
    }
    return legend;
}

// The mesh with the attribute that it is to be coloured by: its own, or displacement from `rest`.
static graph::Wire<geometry::TriMesh> with_attribute(const graph::Wire<geometry::TriMesh>& mesh,
                                                     const Inputs& in)
{
    const std::string& name = in.colour.attribute;
    const bool has = std::any_of(mesh->attributes.begin(), mesh->attributes.end(),
                                 [&](const auto& a) { return a.name == name; });
    if (has || name != "displacement" || !in.rest ||
        in.rest->positions.size() != mesh->positions.size()) {
        return mesh;
    }
    auto out = std::make_shared<geometry::TriMesh>(*mesh);
    std::vector<float> values(mesh->positions.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = (mesh->positions[i] - in.rest->positions[i]).norm();
    }
    out->attributes.push_back({name, "m", std::move(values)});
    return out;
}

static ::render::Lines edges_of(const geometry::TriMesh& mesh)
{
    ::render::Lines lines;
    const auto uses = geometry::edge_uses(mesh.triangles(), mesh.positions.size());
    for (std::size_t i = 0; i < uses.size(); ++i) {
        if (i > 0 && uses[i].a == uses[i - 1].a && uses[i].b == uses[i - 1].b) continue;
        lines.ends.push_back(mesh.positions[uses[i].a]);
        lines.ends.push_back(mesh.positions[uses[i].b]);
    }
    lines.colour = {0.02f, 0.02f, 0.03f};
    return lines;
}

static void add_meshes(::render::Scene& scene, const Inputs& in)
{
    for (const auto& linked : in.mesh) {
        ::render::Surface surface;
        surface.layout = in.layout;
        surface.paint.by = in.colour.by;
        surface.paint.colour = in.colour.constant;
        surface.paint.attribute = in.colour.attribute;
        surface.mesh = linked;
        if (in.colour.by == ::render::Paint::By::attribute) {
            surface.mesh = with_attribute(linked, in);
            for (const auto& a : surface.mesh->attributes) {
                if (a.name != in.colour.attribute) continue;
                if (!scene.legend) scene.legend = legend_for(in.colour, a);
                surface.paint.scale = scene.legend->scale;
            }
        }
        if (in.show.edges) scene.lines.push_back(edges_of(*linked));
        scene.surfaces.push_back(std::move(surface));
    }
}

// The colour of each cube's component or matter, at its vertices.
static void colour_by_category(geometry::TriMesh& mesh, const geometry::Attribute& values)
{
    mesh.colours.resize(mesh.positions.size());
    for (std::size_t i = 0; i < mesh.colours.size(); ++i) {
        const auto category = static_cast<std::uint32_t>(std::max(0.0f, values.values[i]));
        mesh.colours[i] = ::render::linear_from_srgb(::render::category_colour(category));
    }
}

static void add_cubes(::render::Scene& scene, const Inputs& in)
{
    if (!in.cubes || in.cube.draw == CubeParams::Draw::none) return;
    const auto x = in.state ? in.state->x : geometry::corner_positions(*in.cubes);
    if (in.cube.draw == CubeParams::Draw::wire) {
        scene.lines.push_back(::render::cube_lines(*in.shell, x));
        scene.lines.back().colour = {0.01f, 0.03f, 0.06f};
        return;
    }
    using By = ::render::Paint::By;
    ::render::Surface surface;
    surface.layout = in.shell->layout;
    auto mesh = std::make_shared<geometry::TriMesh>(
        ::render::solid_cubes(*in.shell, x, static_cast<float>(in.cube.scale)));
    const auto values = [&](const std::string& name) {
        return ::render::cube_quantity(name, *in.cubes, *in.shell, in.state.get());
    };
    if (in.cube.by_attribute && !::render::is_category(in.colour.attribute)) {
        mesh->attributes.push_back(values(in.colour.attribute));
        if (!scene.legend) scene.legend = legend_for(in.colour, mesh->attributes.back());
        surface.paint = {By::attribute, in.colour.constant, in.colour.attribute,
                         scene.legend->scale};
    } else if (in.cube.by_attribute || !in.cubes->component.empty()) {
        colour_by_category(*mesh, values(in.cube.by_attribute ? in.colour.attribute : "component"));
        surface.paint.by = By::vertex_colour;
    } else {
        surface.paint.by = By::constant;
        surface.paint.colour = ::render::linear_from_srgb(::render::category_colour(0));
    }
    surface.mesh = std::move(mesh);
    scene.surfaces.push_back(std::move(surface));
}

static void add_points(::render::Scene& scene, const Inputs& in)
{
    if (!in.points) return;
    ::render::Balls balls;
    balls.centres = in.points->positions;
    balls.radius = static_cast<float>(in.show.point_size / 2);
    if (in.show.point_size == 0) {
        balls.radius = static_cast<float>(0.0025 * ::render::bounds(scene).diagonal());
        if (scene.surfaces.empty() && scene.lines.empty()) {
            geometry::Box box;
            for (const auto& p : balls.centres) {
                if (p.allFinite()) box.add(p.cast<double>());
            }
            balls.radius = static_cast<float>(0.0025 * box.diagonal());
        }
    }
    for (const auto matter : in.points->matter) {
        balls.colours.push_back(::render::linear_from_srgb(::render::category_colour(matter)));
    }
    if (balls.colours.size() != balls.centres.size()) balls.colours = {Vec3f(0.3f, 0.5f, 0.7f)};
    scene.balls.push_back(std::move(balls));
}

static ::render::Surface marker(std::shared_ptr<const geometry::TriMesh> mesh, const Vec3f& colour)
{
    ::render::Surface surface;
    surface.mesh = std::move(mesh);
    surface.paint.by = ::render::Paint::By::constant;
    surface.paint.colour = colour;
    return surface;
}

// What acts on the body, sized for the stage.
static void add_loads(::render::Scene& scene, const Inputs& in)
{
    const double size = scene.stage.diagonal();
    if (in.show.pins) {
        for (const auto& pins : in.pins) {
            ::render::Balls balls;
            balls.radius = static_cast<float>(in.cubes ? 0.16 * in.cubes->size : 0.004 * size);
            balls.smallest = 3;
            balls.shadow = false;
            balls.colours = {Vec3f(0.85f, 0.16f, 0.02f)};
            for (const Vec3& p : pins->target) balls.centres.push_back(p.cast<float>());
            scene.balls.push_back(std::move(balls));
        }
    }
    if (in.show.forces) {
        double weight = 1;
        if (in.cubes) {
            weight = 0;
            for (const double m : in.cubes->mass) weight += 9.81 * m;
        }
        for (const auto& force : in.forces) {
            for (auto& mesh : ::render::force_arrows(*force, scene.stage, weight)) {
                scene.surfaces.push_back(
                    marker(std::make_shared<const geometry::TriMesh>(std::move(mesh)),
                           {0.05f, 0.30f, 0.65f}));
                scene.surfaces.back().shadow = false;
            }
        }
    }
    if (!in.show.colliders) return;
    for (const auto& collider : in.colliders) {
        const bool plane = collider->kind == physics::Collider::Kind::plane;
        const bool level = (collider->pose.linear() * Vec3::UnitY()).normalized().y() > 0.9999;
        if (plane && level && in.ground.kind == GroundParams::Kind::under) continue;
        auto mesh = ::render::collider_surface(*collider, scene.stage);
        if (!mesh) continue;
        scene.surfaces.push_back(marker(std::move(mesh), {0.28f, 0.33f, 0.38f}));
        if (plane) {
            scene.surfaces.back().opacity = 0.35f;
            scene.surfaces.back().shadow = false;
        }
    }
}

// The highest level plane that things collide with.
static std::optional<double> solid_floor(const Inputs& in)
{
    std::optional<double> height;
    for (const auto& c : in.colliders) {
        const bool level = (c->pose.linear() * Vec3::UnitY()).normalized().y() > 0.9999;
        if (c->kind != physics::Collider::Kind::plane || !level) continue;
        height = std::max(height.value_or(c->pose.translation().y()), c->pose.translation().y());
    }
    return height;
}

// What does not move, where it is known; down to the floor when the model may fall onto it.
static geometry::Box stage_of(const geometry::Box& drawn, const Inputs& in)
{
    geometry::Box box;
    if (in.rest) {
        box = geometry::bounds(*in.rest);
    } else if (in.cubes) {
        for (const Vec3& p : geometry::corner_positions(*in.cubes)) box.add(p);
    } else {
        box = drawn;
    }
    const auto floor = solid_floor(in);
    if (floor && !box.empty() && *floor < box.lo.y() && box.lo.y() - *floor < 3 * box.diagonal()) {
        box.lo.y() = *floor;
    }
    return box;
}

static std::optional<double> ground_height(const ::render::Scene& scene, const Inputs& in)
{
    if (in.ground.kind == GroundParams::Kind::none) return std::nullopt;
    if (in.ground.kind == GroundParams::Kind::at) return in.ground.height;
    if (const auto floor = solid_floor(in)) return floor;
    if (scene.stage.empty()) return std::nullopt;
    return scene.stage.lo.y();
}

// Warns of a picture that can show nothing of `drawn`, the bounds of what is linked.
static void warn_of_empty(const Inputs& in, const ::render::Scene& scene,
                          const ::render::Camera& camera, geometry::Box drawn,
                          const graph::Context& context)
{
    for (const auto& balls : scene.balls) {
        drawn.lo.array() -= double(balls.radius);
        drawn.hi.array() += double(balls.radius);
    }
    if (drawn.empty() || ::render::may_see(camera, drawn, double(in.width) / in.height)) return;
    context.warn(in.camera.kind == CameraParams::Kind::look_at
                     ? "nothing that is linked lies in the picture: turn camera.target to it, or "
                       "let the camera fit it"
                     : "nothing that is linked lies in the picture any more: the camera fits where "
                       "it is at rest; free a margin, or choose look_at for camera.kind");
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    ::render::Scene scene;
    add_meshes(scene, in);
    add_cubes(scene, in);
    add_points(scene, in);
    const geometry::Box drawn = ::render::bounds(scene);
    if (in.mesh.empty() && !in.cubes && !in.points && in.pins.empty() && in.forces.empty() &&
        in.colliders.empty()) {
        throw std::invalid_argument(
            "there is nothing to draw: link a mesh, cubes, points, pins, forces or colliders");
    }
    scene.stage = stage_of(drawn, in);
    add_loads(scene, in);
    scene.ground = ground_height(scene, in);
    if (!in.legend) scene.legend.reset();
    scene.label = graph::frame_text(in.label, context.frame());

    const auto camera = camera_of(in, scene, context.frame() - context.range().first);
    std::vector<std::string> warnings;
    Outputs out{::render::draw(scene, camera, look_of(in), &warnings)};
    for (const std::string& text : warnings) context.warn(text);
    warn_of_empty(in, scene, camera, drawn, context);
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

void add_to(graph::Registry& registry)
{
    registry.add("Render", 1, run)
        .summary("Draws a lit preview picture of what is linked.")
        .inputs("mesh", &Inputs::mesh, "Meshes to draw.")
        .input(
            "rest", &Inputs::rest,
            "The stage: the camera, the floor and the shadow are laid out for the bounds of this "
            "mesh. Link what does not move (the mesh at rest), so that they stand still; without "
            "it they follow what is drawn.",
            graph::Need::optional)
        .input("cubes", &Inputs::cubes, "Cubes to draw.", graph::Need::optional)
        .input("state", &Inputs::state, "Where the corners of the cubes are; at rest without it.",
               graph::Need::optional)
        .input("points", &Inputs::points, "Points to draw as small balls.", graph::Need::optional)
        .inputs("pins", &Inputs::pins, "Pinned corners to mark.")
        .inputs("forces", &Inputs::forces, "Forces to draw as arrows.")
        .inputs("colliders", &Inputs::colliders, "Colliders to draw; a level plane is the floor.")
        .prepare("shell", &Inputs::shell, prepare_shell, {"cubes"})
        .prepare("layout", &Inputs::layout, prepare_layout, {"rest"})
        .param("width", &Inputs::width, "Width of the picture.", {1, 8192, "px"})
        .param("height", &Inputs::height, "Height of the picture.", {1, 8192, "px"})
        .choice("antialias", &Inputs::antialias, {"none", "fxaa", "samples4"},
                "Smoothing of edges: `none`, `fxaa` on the finished picture, or four samples a "
                "pixel where something changes.")
        .block<CameraParams>("camera", &Inputs::camera, describe, "From where it is seen.")
        .block<LightParams>("light", &Inputs::light, describe,
                            "A key light that casts a shadow, and light from all around.")
        .block<GroundParams>("ground", &Inputs::ground, describe,
                             "A floor that receives the shadow.")
        .block<BackdropParams>("backdrop", &Inputs::backdrop, describe, "What is behind it all.")
        .block<ColourParams>("colour", &Inputs::colour, describe, "What colours things.")
        .block<CubeParams>("cube", &Inputs::cube, describe, "How cubes are drawn.")
        .block<ShowParams>("show", &Inputs::show, describe, "What else is drawn, and how.")
        .param("legend", &Inputs::legend, "Whether a scale of colours is explained in the picture.")
        .param("label", &Inputs::label,
               "Text in the lower left corner; #### stands for the frame's number.")
        .reads(graph::Variable::frame | graph::Variable::range)
        .output("image", &Outputs::image, "The picture.");
}

}  // namespace nodes::render
