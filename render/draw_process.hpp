#pragma once

// OpenGL in a process of its own, aspic-draw. Mesa crashes now and then, and what it keeps grows
// with every picture: then only that process is lost, and another one draws the picture again.
//
//   this program                          aspic-draw
//   copies the job to shared memory
//   request  -- socket -->                draws it
//                                         writes its pixels to the same memory
//   copies them out   <-- socket --       reply
//
// It ends with this program, however that ends.

#include "geometry/base/descriptor.hpp"
#include "render/draw_messages.hpp"

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace render {

// Where aspic-draw is: $ASPIC_DRAW, or beside the running program. Empty where there is none, and
// when the variable says "none".
std::filesystem::path draw_program();

// One such process, for one picture at a time.
class DrawProcess {
public:
    // Throws std::runtime_error when the program cannot be started.
    explicit DrawProcess(std::filesystem::path program);
    DrawProcess(const DrawProcess&) = delete;
    ~DrawProcess();

    // Writes the pixels of `job`. False when the process ended before they were there. `check` is
    // called now and then meanwhile; what it throws is thrown on, and the process is of no more
    // use. Throws std::runtime_error with the error of OpenGL, std::bad_alloc where memory ran out.
    bool draw(const DrawJob& job, const Pixels& to, const std::function<void()>& check);

    bool alive() const;
    // Kills it where it has not ended, and says how it did: "Segmentation fault".
    std::string end();

    const std::filesystem::path& program() const { return program_; }
    pid_t pid() const { return pid_; }
    std::size_t resident() const { return resident_; }  // bytes, after its last picture

private:
    std::filesystem::path program_;
    geometry::Descriptor memory_fd_, said_, socket_;
    SharedMemory memory_;
    std::size_t size_ = 0;  // bytes of the memory
    std::size_t resident_ = 0;
    std::vector<std::uint64_t> kept_;  // the textures that it has, by their digests
    pid_t pid_ = -1, parent_ = -1;
};

}  // namespace render
