#pragma once

// The parameters of Render's motion blur, and what the scene has to know for it.

#include "geometry/mesh/mesh.hpp"
#include "graph/types/node_type.hpp"
#include "graph/types/param_builder.hpp"
#include "graph/types/value.hpp"

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace nodes::render {

struct BlurParams {
    double shutter = 0;
    int samples = 8;
};

inline void describe(graph::ParamsOf<BlurParams>& p)
{
    p.param("shutter", &BlurParams::shutter,
            "How long the shutter is open, as a share of a frame; it closes at the frame. 0.5 is "
            "what cameras call 180 degrees; 0 draws no blur.",
            {0, 1})
        .param("samples", &BlurParams::samples,
               "Pictures that are averaged as light, and how many times longer a frame takes. "
               "Fast things want one for each 3 pixels of their way. At quality `final` it is "
               "rounded up to a multiple of 16, each with one sample per pixel.",
               {1, 256});
}

inline constexpr const char* before_told =
    "The meshes a frame ago, one for each of `mesh`, in the same order: `before` of Before. "
    "Between "
    "the two, motion_blur moves each vertex on a straight line. Where faces change, by tearing for "
    "one, a mesh is drawn still; so is all that is no mesh.";

// Why the links do not suit the shutter; empty where they do.
inline std::string wrong_before(const BlurParams& blur, std::size_t meshes, std::size_t before)
{
    if (blur.shutter == 0 || (meshes == before && meshes > 0)) return {};
    return fmt::format("the shutter needs to know where each mesh was a frame ago: link as many to "
                       "`before` as to `mesh`, in the same order (the node Before gives them); "
                       "found {} for {}",
                       before, meshes);
}

// Mesh `m` a frame ago; null without blur. Throws std::invalid_argument as wrong_before() says.
inline graph::Wire<geometry::TriMesh>
mesh_before(const BlurParams& blur, const std::vector<graph::Wire<geometry::TriMesh>>& mesh,
            const std::vector<graph::Wire<geometry::TriMesh>>& before, std::size_t m)
{
    if (blur.shutter == 0) return nullptr;
    const std::string wrong = wrong_before(blur, mesh.size(), before.size());
    if (!wrong.empty()) throw std::invalid_argument(wrong);
    return before[m];
}

}  // namespace nodes::render
