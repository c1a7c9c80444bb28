#include "render/fill_in.hpp"

#include "render/draw_process.hpp"
#include "render/renderer.hpp"
#include "render/room_to_draw.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <thread>

namespace render {
namespace {

constexpr int attempts = 3;

// A process that holds this much more than a picture of its last one's size needs is replaced.
constexpr std::size_t most_kept = std::size_t{256} << 20;

// The processes that nobody is using, and how many there may be.
struct Pool {
    std::mutex mutex;
    std::condition_variable returned;
    std::vector<std::unique_ptr<DrawProcess>> idle;
    unsigned busy = 0;
    unsigned most = std::clamp(std::thread::hardware_concurrency(), 1u, 4u);
};

Pool& pool();

// Not left to whoever adopts the processes of a program that has ended.
void end_idle_processes()
{
    std::vector<std::unique_ptr<DrawProcess>> idle;
    const std::lock_guard lock(pool().mutex);
    idle.swap(pool().idle);
}

// Never destroyed: a thread may draw while the program ends.
Pool& pool()
{
    static Pool& one = [&]() -> Pool& {
        std::atexit(end_idle_processes);
        return *new Pool;
    }();
    return one;
}

// A place among those that may draw; waits for one.
class Turn {
public:
    explicit Turn(const std::function<void()>& check)
    {
        Pool& all = pool();
        std::unique_lock lock(all.mutex);
        while (all.busy >= all.most) {
            all.returned.wait_for(lock, std::chrono::milliseconds(50));
            if (!check) continue;
            lock.unlock();
            check();
            lock.lock();
        }
        ++all.busy;
    }
    Turn(const Turn&) = delete;
    ~Turn()
    {
        {
            const std::lock_guard lock(pool().mutex);
            --pool().busy;
        }
        pool().returned.notify_one();
    }
};

// One that runs `program` and waits, or a new one.
std::unique_ptr<DrawProcess> take(const std::filesystem::path& program)
{
    std::vector<std::unique_ptr<DrawProcess>> ended;  // they are waited for without the lock
    {
        const std::lock_guard lock(pool().mutex);
        auto& idle = pool().idle;
        while (!idle.empty()) {
            auto process = std::move(idle.back());
            idle.pop_back();
            if (process->program() == program && process->alive()) return process;
            ended.push_back(std::move(process));
        }
    }
    return std::make_unique<DrawProcess>(program);
}

void give_back(std::unique_ptr<DrawProcess> process)
{
    const std::lock_guard lock(pool().mutex);
    pool().idle.push_back(std::move(process));
}

void fill_in_elsewhere(const std::filesystem::path& program, const DrawJob& job, const Pixels& to,
                       const std::function<void()>& check)
{
    const std::size_t needed = bytes_to_draw(job);
    ask_for_room(needed);
    const Turn turn(check);
    std::string how;
    for (int attempt = 0; attempt < attempts; ++attempt) {
        auto process = take(program);
        if (process->draw(job, to, check)) {
            if (process->resident() < needed + most_kept) give_back(std::move(process));
            return;
        }
        how = process->end();
    }
    throw std::runtime_error("the process that draws pictures (" + program.string() + ") ended " +
                             std::to_string(attempts) + " times on this one: " + how);
}

// One context, and one thread at a time: with more of them Mesa 22.3 crashes, as llvmpipe looks
// through the scenes of all contexts for a texture while their threads take the scenes apart. Never
// destroyed: at the end of the program OSMesa's own statics may already be gone.
void fill_in_here(const DrawJob& job, const Pixels& to)
{
    static std::mutex& mutex = *new std::mutex;
    static std::unique_ptr<Renderer>& renderer = *new std::unique_ptr<Renderer>;
    const std::lock_guard lock(mutex);
    const RoomToDraw room(bytes_to_draw(job));
    if (!renderer) renderer = std::make_unique<Renderer>();
    try {
        renderer->draw(job, to);
    } catch (...) {
        renderer.reset();  // OpenGL may be in any state
        throw;
    }
}

}  // namespace

void fill_in(const DrawJob& job, const Pixels& to, const std::function<void()>& check)
{
    if (const auto program = draw_program(); !program.empty()) {
        fill_in_elsewhere(program, job, to, check);
    } else {
        fill_in_here(job, to);
    }
}

std::vector<int> idle_draw_processes()
{
    const std::lock_guard lock(pool().mutex);
    std::vector<int> ids;
    for (const auto& process : pool().idle) ids.push_back(process->pid());
    return ids;
}

}  // namespace render
