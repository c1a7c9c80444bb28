#pragma once

// A job's pixels from OpenGL. They come from processes of their own (draw_process.hpp); where there
// is no aspic-draw, from this one.

#include "render/draw_job.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace render {

// Writes the pixels as Renderer::draw does. May be called from several
// threads at once. `check` is called now and then while another process draws; what it throws is
// thrown on. A process that ends on a picture is replaced and the picture drawn again, twice.
// Throws std::runtime_error when it ends each time, when OpenGL is missing or too old, and when
// OpenGL reports an error; std::bad_alloc where memory does not suffice.
void fill_in(const DrawJob& job, const Pixels& to, const std::function<void()>& check = {});

// The processes that wait for a picture, by their ids.
std::vector<int> idle_draw_processes();

}  // namespace render
