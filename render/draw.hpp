#pragma once

// The preview renderer: OpenGL on the processor (Mesa's llvmpipe through OSMesa). The same scene
// gives the same pixels in every run, for any number of threads.

#include "render/camera.hpp"
#include "render/image.hpp"
#include "render/look.hpp"
#include "render/scene.hpp"

namespace render {

// A picture of `scene`. May be called from several threads at once: each call borrows a context
// that no other has. What cannot be drawn is left out, and `warnings` (where given) says so.
// Throws std::invalid_argument when no picture can be made of the arguments, std::runtime_error
// when OpenGL is missing or too old.
Image draw(const Scene& scene, const Camera& camera, const Look& look,
           std::vector<std::string>* warnings = nullptr);

}  // namespace render
