#pragma once

// How a picture lies on faces: what is beyond its edges, and what its alpha does.

#include <cstdint>

namespace geometry {

struct TextureUse {
    enum class Wrap : std::uint8_t { repeat, clamp, mirror } u = Wrap::repeat, v = Wrap::repeat;
    // cutout: what is below `cutoff` is not there.
    enum class Alpha : std::uint8_t { ignored, cutout, blended } alpha = Alpha::ignored;
    float cutoff = 0.5f;

    bool operator==(const TextureUse&) const = default;
};

}  // namespace geometry
