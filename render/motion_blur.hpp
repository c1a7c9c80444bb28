#pragma once

// Motion blur by sub-frames: what moves is drawn at several moments while a shutter is open, and
// the light of these pictures is averaged.
//   Haeberli, Akeley. The accumulation buffer: hardware support for high-quality rendering.
//   SIGGRAPH 1990.
//
//   x(ago) = (1 - ago) x + ago x_before      ago: frames before this one, 0..1

#include "render/image.hpp"
#include "render/scene.hpp"

#include <vector>

namespace render {

// Whether anything of the scene was elsewhere a frame ago.
bool moves(const Scene& scene);

// The scene as it was `ago` frames ago (0..1): vertices on straight lines from where they were,
// normals turned likewise. What has another number of vertices or other faces than a frame ago
// stays where it is.
Scene moment_of(const Scene& scene, double ago);

// Pictures of one size, summed as light.
class Exposure {
public:
    // `linear`: the picture's light and depths, see linear_floats(); or none.
    void add(const Image& picture, const std::vector<float>& linear);

    // Both of as many pictures as were added, at least one. Of depths, the nearest.
    Image mean_picture() const;
    std::vector<float> mean_linear() const;

private:
    int count_ = 0, width_ = 0, height_ = 0;
    std::vector<float> light_;  // width * height * 3, display-linear RGB
    std::vector<float> linear_;
};

}  // namespace render
