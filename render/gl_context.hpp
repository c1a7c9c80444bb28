#pragma once

// OpenGL without a window. The rest of the renderer draws into framebuffer objects with whatever
// context this file gives it, so another way to make one (EGL, once OSMesa is gone) is a change to
// gl_context.cpp alone.

#include <atomic>
#include <memory>
#include <string>

namespace render {

// An OpenGL 4.5 core context. One thread at a time may draw with it.
class GlContext {
public:
    // Throws std::runtime_error when the machine's OpenGL is older, saying what it has.
    GlContext();
    ~GlContext();
    GlContext(const GlContext&) = delete;

    // While one of these lives, the context is current in the thread that made it. OSMesa does not
    // object when a context is current in two threads, it misbehaves: this throws std::logic_error.
    class Current {
    public:
        explicit Current(GlContext& context);
        ~Current();
        Current(const Current&) = delete;

    private:
        GlContext& context_;
    };

private:
    struct Native;
    std::unique_ptr<Native> native_;
    std::atomic<bool> in_use_ = false;
};

// OSMesa's library, which is loaded when the first context is made.
inline constexpr const char* opengl_library = "libOSMesa.so.8";

// What draws, for people: "4.5 (Core Profile) Mesa 22.3.6, llvmpipe (LLVM 15.0.6, 256 bits)".
// Throws what making a context throws.
std::string gl_version();

}  // namespace render
