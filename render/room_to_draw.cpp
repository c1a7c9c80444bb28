#include "render/room_to_draw.hpp"

#include <mutex>
#include <new>
#include <sys/resource.h>

namespace render {

std::size_t bytes_to_draw(const DrawJob& job)
{
    constexpr std::size_t compiler = 48 << 20;              // of the shaders
    constexpr std::size_t a_pixel = 36, a_sample = 4 * 16;  // see GlObjects
    const PictureNumbers& n = job.numbers;
    const auto area = [](int width, int height) {
        return std::size_t(width) * std::size_t(height);
    };
    std::size_t textures = 0;
    for (const JobTexture& t : job.textures) textures += 3 * t.bytes();  // with its smaller levels
    // Light: of four samples where something is transparent, in OpenGL and read back.
    const std::size_t linear = n.linear == Linear::none ? 0 : 4 * (8 + 20) + 20;
    const std::size_t sum = n.pictures > 1 ? 16 : 0;        // of their light
    const std::size_t peeled = n.layered > 0 ? 4 * 32 : 0;  // see Peel
    return compiler + textures +
           area(n.width, n.height) * (a_pixel + a_sample + linear + sum + peeled) +
           4 * (area(n.shadow_width, n.shadow_height) + area(n.far_width, n.far_height)) +
           2 * (job.traced.size_bytes() + job.traced_samples.size_bytes() +
                job.traced_shadow.size_bytes() + job.vertices.size_bytes() + job.uvs.size_bytes() +
                job.indices.size_bytes());
}

void ask_for_room(std::size_t bytes)
{
    rlimit limit{};
    if (::getrlimit(RLIMIT_DATA, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
    ::operator delete(::operator new(bytes));  // nothing is written there
}

namespace {

// How many are drawing, and the limit that holds when nobody is.
struct Lifted {
    std::mutex mutex;
    int count = 0;
    rlimit before{};
};
Lifted& lifted()
{
    static Lifted one;
    return one;
}

}  // namespace

RoomToDraw::RoomToDraw(std::size_t bytes)
{
    Lifted& all = lifted();
    const std::lock_guard lock(all.mutex);
    if (all.count == 0) {
        if (::getrlimit(RLIMIT_DATA, &all.before) != 0) all.before = {RLIM_INFINITY, RLIM_INFINITY};
        if (all.before.rlim_cur != RLIM_INFINITY) {
            ask_for_room(bytes);
            rlimit most = all.before;
            most.rlim_cur = most.rlim_max;
            ::setrlimit(RLIMIT_DATA, &most);
        }
    }
    ++all.count;
}

RoomToDraw::~RoomToDraw()
{
    Lifted& all = lifted();
    const std::lock_guard lock(all.mutex);
    if (--all.count == 0 && all.before.rlim_cur != RLIM_INFINITY) {
        ::setrlimit(RLIMIT_DATA, &all.before);
    }
}

}  // namespace render
