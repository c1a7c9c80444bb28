#pragma once

// Memory for OpenGL under a limit that this process has set for itself (RLIMIT_DATA). Mesa crashes
// where memory is refused to it, so it is asked for beforehand.

#include "render/draw_job.hpp"

#include <cstddef>

namespace render {

// What OpenGL takes for a picture, generously.
std::size_t bytes_to_draw(const DrawJob& job);

// Throws std::bad_alloc when `bytes` cannot be had within the limit.
void ask_for_room(std::size_t bytes);

// For OpenGL in this process: asks, and while one of these lives the limit refuses nothing.
class RoomToDraw {
public:
    explicit RoomToDraw(std::size_t bytes);
    ~RoomToDraw();
    RoomToDraw(const RoomToDraw&) = delete;
};

}  // namespace render
