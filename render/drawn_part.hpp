#pragma once

// Where in a picture the things lie that are drawn, so that passes for them alone spare the rest.

#include "render/draw_job.hpp"

namespace render {

// Outside of it nothing is drawn but the floor and what is behind it.
struct DrawnPart {
    int x = 0, y = 0, width = 0, height = 0;  // pixels
};

// By the box of all that is drawn. The whole picture where that box reaches up to the eye.
DrawnPart drawn_part(const DrawJob& job);

}  // namespace render
