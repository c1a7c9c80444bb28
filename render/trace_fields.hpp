#pragma once

// Surfaces without triangles, found along the rays of a picture's pixels and of its shadow map's
// texels, as a drawing backend takes them.

#include "render/draw_list.hpp"
#include "render/look.hpp"
#include "render/scene.hpp"

namespace render {

// Fills in `list.traced`; the rest of the list must be there. Throws std::invalid_argument where a
// field is to be coloured by an attribute that it does not have.
void trace_fields(const Scene& scene, const Look& look, DrawList& list);

}  // namespace render
