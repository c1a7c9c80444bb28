#pragma once

// What this program and aspic-draw tell each other. Requests and replies go through a socket, one
// message each; vertices, indices, batches and pixels lie in memory that both see:
//
//   memory   | vertices | uvs | indices | opaque | clear | traced (3) | textures | pixels | linear
//            | texels |
//
// each from a multiple of 64 bytes. Of textures, `texels` has those alone that aspic-draw does not
// keep from the picture before; it keeps what a picture used until the next one.
//
// Both programs must be of one build: a message of another size, or with another `layout`, is
// refused.

#include "render/draw_job.hpp"

#include <cstddef>
#include <cstdint>

namespace render {

// Descriptors that aspic-draw starts with.
inline constexpr int draw_socket = 3, draw_memory = 4;

inline constexpr std::uint64_t draw_layout =
    1'000'000 * sizeof(PictureNumbers) + 1000 * sizeof(Vertex) + sizeof(Batch);

struct SentTexture {
    std::uint64_t digest = 0;
    std::int32_t width = 0, height = 0;
    bool normals = false;
    bool sent = false;  // its texels follow those of the ones before
};
static_assert(std::is_trivially_copyable_v<SentTexture>);

struct DrawRequest {
    std::uint64_t layout = draw_layout;
    std::uint64_t vertices = 0, uvs = 0, indices = 0, opaque = 0, clear = 0;  // how many
    std::uint64_t traced = 0, traced_samples = 0, traced_shadow = 0;
    std::uint64_t textures = 0, texel_bytes = 0;
    PictureNumbers numbers;
};
static_assert(std::is_trivially_copyable_v<DrawRequest>);

struct DrawReply {
    enum class Is : std::uint32_t { drawn, failed, out_of_memory } is = Is::drawn;
    std::uint64_t resident = 0;    // bytes of memory that aspic-draw holds
    std::array<char, 1024> why{};  // failed: the error's text, ended by a zero
};
static_assert(std::is_trivially_copyable_v<DrawReply>);

// Where each part of a request lies, bytes from the start of the memory.
struct DrawPlaces {
    std::size_t vertices, uvs, indices, opaque, clear, traced, traced_samples, traced_shadow;
    std::size_t textures, pixels, linear, texels, end;
};
inline DrawPlaces places_of(const DrawRequest& r)
{
    DrawPlaces at{};
    std::size_t next = 0;
    const auto take = [&](std::size_t bytes) {
        const std::size_t start = next;
        next = (next + bytes + 63) / 64 * 64;
        return start;
    };
    at.vertices = take(r.vertices * sizeof(Vertex));
    at.uvs = take(r.uvs * sizeof(std::array<float, 2>));
    at.indices = take(r.indices * sizeof(std::uint32_t));
    at.opaque = take(r.opaque * sizeof(Batch));
    at.clear = take(r.clear * sizeof(Batch));
    at.traced = take(r.traced * sizeof(TracedPixel));
    at.traced_samples = take(r.traced_samples * sizeof(TracedPixel));
    at.traced_shadow = take(r.traced_shadow * sizeof(float));
    at.textures = take(r.textures * sizeof(SentTexture));
    at.pixels = take(std::size_t(r.numbers.width) * std::size_t(r.numbers.height) * 4);
    at.linear = take(linear_floats(r.numbers) * sizeof(float));
    at.texels = take(r.texel_bytes);
    at.end = next;
    return at;
}

// Memory of a descriptor that another process sees too.
class SharedMemory {
public:
    explicit SharedMemory(int fd) : fd_(fd) {}
    SharedMemory(const SharedMemory&) = delete;
    ~SharedMemory();

    // The first `bytes` of it, which the descriptor must have. Throws std::bad_alloc.
    std::byte* map(std::size_t bytes);

private:
    int fd_;
    std::byte* at_ = nullptr;
    std::size_t size_ = 0;
};

}  // namespace render
