#include "render/drawn_part.hpp"

#include <algorithm>
#include <cmath>

namespace render {
namespace {

// For samples beside the middle of a pixel, and for rounding.
constexpr float rim = 3;  // pixels

// Lines and the smallest balls are as wide as this at least, wherever they are.
float widest(const DrawJob& job)
{
    float most = 0;
    for (const auto batches : {job.opaque, job.clear}) {
        for (const Batch& batch : batches) {
            if (batch.shape != Batch::Shape::triangles) most = std::max(most, batch.size);
        }
    }
    return most;
}

}  // namespace

DrawnPart drawn_part(const DrawJob& job)
{
    const FrameNumbers& f = job.numbers.frame;
    const auto width = float(job.numbers.width), height = float(job.numbers.height);
    const auto& m = f.clip_from_stage;
    constexpr float beyond = 1e30f;
    float left = beyond, right = -beyond, top = beyond, bottom = -beyond;
    for (int k = 0; k < 8; ++k) {
        const float x = k & 1 ? f.drawn_high[0] : f.drawn_low[0];
        const float y = k & 2 ? f.drawn_high[1] : f.drawn_low[1];
        const float z = k & 4 ? f.drawn_high[2] : f.drawn_low[2];
        const auto row = [&](std::size_t r) {
            return m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r];
        };
        const float ahead = row(3);
        // The box is larger than what it holds, and may begin before the near plane.
        if (!(ahead > 0.1f * f.eye[3])) return {0, 0, job.numbers.width, job.numbers.height};
        const float across = (0.5f + 0.5f * row(0) / ahead) * width;
        const float down = (0.5f + 0.5f * row(1) / ahead) * height;
        left = std::min(left, across);
        right = std::max(right, across);
        top = std::min(top, down);
        bottom = std::max(bottom, down);
    }
    const float beside = rim + widest(job);
    const auto within = [](float at, float most) { return int(std::clamp(at, 0.0f, most)); };
    DrawnPart part;
    part.x = within(std::floor(left - beside), width);
    part.y = within(std::floor(top - beside), height);
    part.width = std::max(within(std::ceil(right + beside), width) - part.x, 0);
    part.height = std::max(within(std::ceil(bottom + beside), height) - part.y, 0);
    return part;
}

}  // namespace render
