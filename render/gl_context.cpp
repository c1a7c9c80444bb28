#include "render/gl_context.hpp"

#define GLAD_GL_IMPLEMENTATION
#include <glad/gl.h>
#undef GLAD_GL_IMPLEMENTATION  // for files that are compiled together with this one

#include <GL/osmesa.h>

#include <dlfcn.h>

#include <array>
#include <mutex>
#include <stdexcept>
#include <string>

namespace render {

namespace {

constexpr int wanted_major = 4, wanted_minor = 5;

std::string wanted(const std::string& found)
{
    return "rendering needs OpenGL 4.5 core from OSMesa (Debian package libosmesa6 22.3 or "
           "later); " +
           found;
}

// OSMesa brings a compiler along, LLVM: 100 MB of libraries and most of what it takes to start a
// program. So it is loaded when something is drawn, and never unloaded, because its threads live
// as long as the program.
struct Mesa {
    decltype(&OSMesaCreateContextAttribs) create;
    decltype(&OSMesaDestroyContext) destroy;
    decltype(&OSMesaMakeCurrent) make_current;
    decltype(&OSMesaGetProcAddress) address;

    Mesa()
    {
        void* const library = dlopen(opengl_library, RTLD_NOW | RTLD_LOCAL);
        if (!library) throw std::runtime_error(wanted(std::string("can't load it: ") + dlerror()));
        const auto find = [&](auto& function, const char* name) {
            function = reinterpret_cast<std::decay_t<decltype(function)>>(dlsym(library, name));
            if (!function) throw std::runtime_error(wanted(std::string("it has no ") + name));
        };
        find(create, "OSMesaCreateContextAttribs");
        find(destroy, "OSMesaDestroyContext");
        find(make_current, "OSMesaMakeCurrent");
        find(address, "OSMesaGetProcAddress");
    }
};

const Mesa& mesa()
{
    static const Mesa loaded;
    return loaded;
}

// OSMesaGetProcAddress answers for any name, so versions are asked for, never functions tested.
// The pointers are the same for every context: they are loaded once.
void load_functions()
{
    static std::mutex loading;
    static bool loaded = false;
    const std::lock_guard lock(loading);
    if (loaded) return;
    const int version = gladLoadGL(reinterpret_cast<GLADloadfunc>(mesa().address));
    const int major = GLAD_VERSION_MAJOR(version), minor = GLAD_VERSION_MINOR(version);
    if (major < wanted_major || (major == wanted_major && minor < wanted_minor)) {
        throw std::runtime_error(
            wanted("found OpenGL " + std::to_string(major) + "." + std::to_string(minor)));
    }
    loaded = true;
}

}  // namespace

struct GlContext::Native {
    OSMesaContext context = nullptr;
    std::array<std::uint8_t, 4> pixel{};  // the default framebuffer, which nothing draws into

    ~Native()
    {
        if (context) mesa().destroy(context);
    }
};

GlContext::GlContext() : native_(std::make_unique<Native>())
{
    const std::array attributes{OSMESA_FORMAT,
                                OSMESA_RGBA,
                                OSMESA_DEPTH_BITS,
                                0,
                                OSMESA_PROFILE,
                                OSMESA_CORE_PROFILE,
                                OSMESA_CONTEXT_MAJOR_VERSION,
                                wanted_major,
                                OSMESA_CONTEXT_MINOR_VERSION,
                                wanted_minor,
                                0};
    native_->context = mesa().create(attributes.data(), nullptr);
    if (!native_->context) throw std::runtime_error(wanted("it would not give a context"));
    const Current current(*this);
    load_functions();
}

GlContext::~GlContext() = default;

GlContext::Current::Current(GlContext& context) : context_(context)
{
    if (context_.in_use_.exchange(true)) {
        throw std::logic_error("an OpenGL context is wanted by two threads at once");
    }
    if (!mesa().make_current(context_.native_->context, context_.native_->pixel.data(),
                             GL_UNSIGNED_BYTE, 1, 1)) {
        context_.in_use_ = false;
        throw std::runtime_error(wanted("it would not make its context current"));
    }
}

GlContext::Current::~Current()
{
    mesa().make_current(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
    context_.in_use_ = false;
}

std::string gl_version()
{
    GlContext context;
    const GlContext::Current current(context);
    const auto text = [](GLenum what) {
        const auto* found = reinterpret_cast<const char*>(glGetString(what));
        return std::string(found ? found : "unknown");
    };
    return text(GL_VERSION) + ", " + text(GL_RENDERER);
}

}  // namespace render
