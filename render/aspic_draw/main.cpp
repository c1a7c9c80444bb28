// aspic-draw: the process in which OpenGL runs, see render/draw_process.hpp. It answers one request
// after the other until the program that started it is gone, or asks for nothing for a minute.

#include "render/draw_messages.hpp"
#include "render/renderer.hpp"

#include <malloc.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <thread>

namespace {

using render::DrawReply;
using render::DrawRequest;

constexpr int idle_ms = 60'000;

std::uint64_t resident_bytes()
{
    unsigned long all = 0, resident = 0;
    if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
        if (std::fscanf(file, "%lu %lu", &all, &resident) != 2) resident = 0;
        std::fclose(file);
    }
    return std::uint64_t{resident} * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

// Mesa crashes where memory is refused to it; whether there is enough was asked before.
void lift_limits()
{
    rlimit limit{};
    if (::getrlimit(RLIMIT_DATA, &limit) == 0) {
        limit.rlim_cur = limit.rlim_max;
        ::setrlimit(RLIMIT_DATA, &limit);
    }
    limit = {0, 0};
    ::setrlimit(RLIMIT_CORE, &limit);
}

// Mesa frees what it takes for a picture piece by piece and takes it again for the next pass: it
// stays here, and no page of it is made anew. What is too much for the next picture ends with the
// process, see fill_in.cpp.
void keep_memory()
{
    ::mallopt(M_TRIM_THRESHOLD, 256 << 20);
    ::mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the most that glibc takes
    ::mallopt(M_TOP_PAD, 16 << 20);
}

// Ends this process with the one that started it, in the middle of a picture too. PR_SET_PDEATHSIG
// would end it with the thread that started it, which may be long before.
void end_with_parent()
{
    std::thread([] {
        pollfd other_end{render::draw_socket, 0, 0};  // hanging up is always told
        while (::poll(&other_end, 1, -1) < 1) {
        }
        ::_exit(0);
    }).detach();
}

void draw(const DrawRequest& request, render::SharedMemory& memory,
          std::unique_ptr<render::Renderer>& renderer)
{
    if (!renderer) renderer = std::make_unique<render::Renderer>();
    const render::DrawPlaces at = render::places_of(request);
    std::byte* const start = memory.map(at.end);
    const auto part = [&]<class T>(std::size_t place, std::uint64_t count, const T*) {
        return std::span<const T>(reinterpret_cast<const T*>(start + place), count);
    };
    render::DrawJob job;
    job.numbers = request.numbers;
    job.vertices = part(at.vertices, request.vertices, static_cast<const render::Vertex*>(nullptr));
    job.indices = part(at.indices, request.indices, static_cast<const std::uint32_t*>(nullptr));
    job.opaque = part(at.opaque, request.opaque, static_cast<const render::Batch*>(nullptr));
    job.clear = part(at.clear, request.clear, static_cast<const render::Batch*>(nullptr));
    job.uvs = part(at.uvs, request.uvs, static_cast<const std::array<float, 2>*>(nullptr));
    constexpr const render::TracedPixel* traced_type = nullptr;
    job.traced = part(at.traced, request.traced, traced_type);
    job.traced_samples = part(at.traced_samples, request.traced_samples, traced_type);
    job.traced_shadow =
        part(at.traced_shadow, request.traced_shadow, static_cast<const float*>(nullptr));
    const std::byte* texels = start + at.texels;
    for (const render::SentTexture& t :
         part(at.textures, request.textures, static_cast<const render::SentTexture*>(nullptr))) {
        render::JobTexture& texture = job.textures.emplace_back();
        texture = {t.digest, t.width, t.height, t.normals, nullptr};
        if (!t.sent) continue;
        texture.rgba = reinterpret_cast<const std::uint8_t*>(texels);
        texels += texture.bytes();
    }
    renderer->draw(
        job, {{reinterpret_cast<std::uint8_t*>(start + at.pixels), at.linear - at.pixels},
              {reinterpret_cast<float*>(start + at.linear), render::linear_floats(job.numbers)}});
}

DrawReply answer(const DrawRequest& request, render::SharedMemory& memory,
                 std::unique_ptr<render::Renderer>& renderer)
{
    DrawReply reply;
    try {
        if (request.layout != render::draw_layout) {
            throw std::runtime_error("aspic-draw is of another build than the program that asks");
        }
        draw(request, memory, renderer);
    } catch (const std::bad_alloc&) {
        reply.is = DrawReply::Is::out_of_memory;
    } catch (const std::exception& error) {
        reply.is = DrawReply::Is::failed;
        std::strncpy(reply.why.data(), error.what(), reply.why.size() - 1);
    }
    reply.resident = resident_bytes();
    return reply;
}

}  // namespace

int main()
{
    DrawRequest request;
    render::SharedMemory memory(render::draw_memory);
    std::unique_ptr<render::Renderer> renderer;
    int type = 0;
    socklen_t size = sizeof type;
    if (::getsockopt(render::draw_socket, SOL_SOCKET, SO_TYPE, &type, &size) != 0) {
        std::fputs("aspic-draw is run by aspic to draw pictures\n", stderr);
        return 2;
    }
    lift_limits();
    keep_memory();
    end_with_parent();
    for (;;) {
        pollfd asked{render::draw_socket, POLLIN, 0};
        const int ready = ::poll(&asked, 1, idle_ms);
        if (ready == 0) break;
        if (ready < 0) continue;
        const ssize_t got = ::recv(render::draw_socket, &request, sizeof request, 0);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) break;
        if (got != ssize_t{sizeof request}) request.layout = 0;
        const DrawReply reply = answer(request, memory, renderer);
        ::send(render::draw_socket, &reply, sizeof reply, MSG_NOSIGNAL);
    }
    ::_exit(0);  // Mesa's own threads are not waited for
}
