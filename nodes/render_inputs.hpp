#pragma once

// What Render is linked to and told, and what it gives.

#include "nodes/render_blur.hpp"
#include "nodes/render_burn_in.hpp"
#include "nodes/render_colour.hpp"
#include "nodes/render_layers.hpp"
#include "nodes/render_shown.hpp"
#include "nodes/render_view.hpp"
#include "nodes/wire_types.hpp"
#include "render/cube_shell.hpp"
#include "render/extent.hpp"
#include "render/image.hpp"

#include <memory>
#include <string>
#include <vector>

namespace nodes::render {

struct CubeParams {
    enum class Draw { none, wire, solid } draw = Draw::solid;
    bool by_attribute = false;
    double scale = 0.94;
};

// In the order of render::Antialias.
enum class Quality { draft, preview, standard, final };

struct Inputs {
    std::vector<graph::Wire<geometry::TriMesh>> mesh, before;
    graph::Wire<physics::LayeredScene> layers;
    graph::Wire<geometry::TriMesh> rest, shot;
    std::shared_ptr<const ::render::Extent> extent;
    graph::Wire<::render::Camera> view;
    graph::Wire<geometry::Cubes> cubes;
    graph::Wire<physics::State> state;
    graph::Wire<geometry::Samples> points;
    std::vector<graph::Wire<physics::Pins>> pins;
    std::vector<graph::Wire<physics::Force>> forces;
    std::vector<graph::Wire<physics::Collider>> colliders;
    Numbers values;
    std::shared_ptr<const ::render::CubeShell> shell;
    std::shared_ptr<const ::render::SurfaceLayout> layout;
    int width = 960, height = 540;
    ::render::Style look = ::render::Style::studio;
    Quality quality = Quality::standard;
    ::render::Linear linear = ::render::Linear::none;
    CameraParams camera;
    LightParams light;
    GroundParams ground;
    BackdropParams backdrop;
    ColourParams colour;
    CubeParams cube;
    ShowParams show;
    bool legend = true;
    std::string label;
    BurnInParams burn_in;
    BlurParams motion_blur;
};
struct Outputs {
    ::render::Image image;
};

inline void describe(graph::ParamsOf<CubeParams>& p)
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

}  // namespace nodes::render
