#pragma once

// The preview renderer: OpenGL on the processor (Mesa's llvmpipe through OSMesa). The same scene
// gives the same pixels in every run, for any number of threads.
//
//   make_draw_list   what is drawn, and in which order       this process
//   fill_in          its pixels from OpenGL                   a process of its own
//   motion_blur      the mean of several of these, where the look asks   this process
//   smooth_edges, draw_captions                                this process

#include "render/camera.hpp"
#include "render/image.hpp"
#include "render/look.hpp"
#include "render/scene.hpp"

#include <functional>
#include <string>
#include <vector>

namespace render {

// A picture of `scene`. May be called from several threads at once. What cannot be drawn is left
// out, and `warnings` (where given) says so. `check` is called now and then while OpenGL draws;
// what it throws is thrown on. Throws std::invalid_argument when no picture can be made of the
// arguments, std::runtime_error when OpenGL is missing or too old, std::bad_alloc where memory does
// not suffice.
Image draw(const Scene& scene, const Camera& camera, const Look& look,
           std::vector<std::string>* warnings = nullptr, const std::function<void()>& check = {});

}  // namespace render
