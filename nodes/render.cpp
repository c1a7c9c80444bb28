#include "geometry/mesh.hpp"
#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"
#include "render/draw.hpp"

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

struct Inputs {
    std::vector<graph::Wire<geometry::TriMesh>> mesh;
    graph::Wire<geometry::TriMesh> rest;
    int width = 960, height = 540;
    ::render::Antialias antialias = ::render::Antialias::fxaa;
    CameraParams camera;
    LightParams light;
    GroundParams ground;
    BackdropParams backdrop;
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
        .param("margin", &CameraParams::margin,
               "Share of the picture's width and height left free on each side.", {0, 0.45},
               {"kind", {"fit", "turntable"}})
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
    p.choice("kind", &GroundParams::kind, {"none", "under", "at"},
             "The floor: `none`, `under` the stage, or `at` a height.")
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

static ::render::Look look_of(const Inputs& in)
{
    ::render::Look look;
    look.width = in.width;
    look.height = in.height;
    look.antialias = in.antialias;
    look.shadow = in.light.shadow;
    look.light_azimuth = in.light.azimuth * degrees;
    look.light_elevation = in.light.elevation * degrees;
    look.light = 1.1f * static_cast<float>(in.light.strength) * in.light.colour;
    look.sky *= static_cast<float>(in.light.fill);
    look.bounce *= static_cast<float>(in.light.fill);
    look.floor = in.ground.colour;
    look.grid = in.ground.grid;
    look.backdrop_top = in.backdrop.top;
    look.backdrop_horizon = in.backdrop.horizon;
    return look;
}

static ::render::Camera camera_of(const Inputs& in, const geometry::Box& stage, int turns)
{
    const CameraParams& c = in.camera;
    if (c.kind == CameraParams::Kind::look_at) {
        return {c.eye, c.target, {0, 1, 0}, c.field_of_view * degrees};
    }
    const double turn = c.kind == CameraParams::Kind::turntable ? c.turn * turns : 0;
    return ::render::fit(stage, (c.azimuth + turn) * degrees, c.elevation * degrees,
                         c.field_of_view * degrees, double(in.width) / in.height, c.margin);
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    ::render::Scene scene;
    for (const auto& mesh : in.mesh) {
        ::render::Surface surface;
        surface.mesh = mesh;
        scene.surfaces.push_back(std::move(surface));
    }
    if (scene.surfaces.empty()) {
        throw std::invalid_argument("there is nothing to draw: link a mesh");
    }
    scene.stage = in.rest ? geometry::bounds(*in.rest) : ::render::bounds(scene);
    if (in.ground.kind != GroundParams::Kind::none && !scene.stage.empty()) {
        const bool under = in.ground.kind == GroundParams::Kind::under;
        scene.ground = under ? scene.stage.lo.y() : in.ground.height;
    }
    const auto camera = camera_of(in, scene.stage, context.frame() - context.range().first);
    std::vector<std::string> warnings;
    Outputs out{::render::draw(scene, camera, look_of(in), &warnings)};
    for (const std::string& text : warnings) context.warn(text);
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Render", 1, run)
        .summary("Draws a lit preview picture of what is linked.")
        .inputs("mesh", &Inputs::mesh, "Meshes to draw.")
        .input(
            "rest", &Inputs::rest,
            "The stage: the camera, the floor, the shadow and the grid are laid out for the "
            "bounds of this mesh. Link what does not move (the mesh at rest), so that they stand "
            "still; without it they follow what is drawn.",
            graph::Need::optional)
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
        .reads(graph::Variable::frame | graph::Variable::range)
        .output("image", &Outputs::image, "The picture.");
}

}  // namespace nodes::render
