#include "geometry/import_scene.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

namespace geometry {
namespace {

namespace fs = std::filesystem;

// One list of members serves both directions.
template <class Archive> void pass(Archive& a, ImportedMesh& m)
{
    a(m.name), a(m.material), a(m.positions), a(m.normals), a(m.colours), a(m.uvs), a(m.triangles),
        a(m.points), a(m.lines);
}
template <class Archive> void pass(Archive& a, ImportedMaterial& m)
{
    a(m.name), a(m.colour), a(m.opacity), a(m.roughness), a(m.metallic);
}
template <class Archive> void pass(Archive& a, ImportedNode& n)
{
    a(n.name), a(n.mesh), a(n.to_world);
}
template <class Archive> void pass(Archive& a, ImportedFile& f)
{
    a(f.path), a(f.found);
}
template <class Archive> void pass(Archive& a, ImportedScene& s)
{
    std::uint64_t format = 0x3130'6369'7073'6120;  // another build's importer is not understood
    a(format);
    if (format != 0x3130'6369'7073'6120) throw std::runtime_error("not a scene of this version");
    a(s.meshes), a(s.materials), a(s.nodes), a(s.linear_colours), a(s.unit), a(s.has_axes),
        a(s.to_y_up), a(s.files), a(s.error);
}

// What is sent as its bytes.
template <class T> constexpr bool is_flat = std::is_arithmetic_v<T>;
template <class T, int R> constexpr bool is_flat<Eigen::Matrix<T, R, 1>> = true;
template <class T, std::size_t N> constexpr bool is_flat<std::array<T, N>> = true;

struct Packing {
    std::string bytes;

    template <class T> void operator()(T& value)
    {
        if constexpr (is_flat<T>) {
            bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
        } else if constexpr (requires { typename T::value_type; }) {
            std::uint64_t count = value.size();
            (*this)(count);
            if constexpr (is_flat<typename T::value_type>) {
                bytes.append(reinterpret_cast<const char*>(value.data()),
                             count * sizeof(typename T::value_type));
            } else {
                for (auto& element : value) pass(*this, element);
            }
        }
    }
};

struct Unpacking {
    const char* at;
    const char* end;

    void take(void* to, std::size_t size)
    {
        if (size > static_cast<std::size_t>(end - at)) throw std::runtime_error("it is cut short");
        if (size > 0) std::memcpy(to, at, size);
        at += size;
    }
    template <class T> void operator()(T& value)
    {
        if constexpr (std::is_same_v<T, bool>) {
            char byte = 0;
            take(&byte, 1);
            value = byte != 0;
        } else if constexpr (is_flat<T>) {
            take(&value, sizeof(T));
        } else {
            using Element = typename T::value_type;
            std::uint64_t count = 0;
            (*this)(count);
            // Every element takes a byte at least: a wrong count must not allocate the world.
            constexpr std::size_t least = is_flat<Element> ? sizeof(Element) : 1;
            if (count > static_cast<std::size_t>(end - at) / least) {
                throw std::runtime_error("it is cut short");
            }
            if constexpr (is_flat<Element>) {
                value.resize(count);
                take(value.data(), count * sizeof(Element));
            } else {
                for (std::uint64_t i = 0; i < count; ++i) pass(*this, value.emplace_back());
            }
        }
    }
};

// A file descriptor that closes itself.
struct Descriptor {
    int fd = -1;

    explicit Descriptor(int d) : fd(d) {}
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor() { close(); }
    void close()
    {
        if (fd >= 0) ::close(fd);
        fd = -1;
    }
};

[[noreturn]] void fail(const std::string& what, int code)
{
    throw std::runtime_error(what + ": " + std::strerror(code));
}

fs::path importer_program()
{
    if (const char* named = std::getenv("ASPIC_IMPORT"); named && *named) return named;
    std::error_code none;
    const fs::path here = fs::read_symlink("/proc/self/exe", none).parent_path();
    for (const fs::path& folder : {here, here.parent_path(), here / "../libexec/aspic"}) {
        const fs::path program = folder / "aspic-import";
        if (::access(program.c_str(), X_OK) == 0) return program;
    }
    throw std::runtime_error("aspic-import, the program that reads mesh files, is not in " +
                             here.string() +
                             "; build it there, or set ASPIC_IMPORT to where it is");
}

// Our own environment, with large pages for what the importer allocates: assimp clears 16 MB for
// any OBJ, and a file of one face then takes 6 ms, against 15 in pages of 4 KiB.
std::vector<std::string> importer_environment()
{
    const std::string tunables = "GLIBC_TUNABLES=", large_pages = "glibc.malloc.hugetlb=1";
    std::vector<std::string> all;
    std::string ours = tunables + large_pages;
    for (char** at = ::environ; *at; ++at) {
        const std::string variable = *at;
        if (variable.starts_with(tunables)) {
            ours = variable + ":" + large_pages;
        } else {
            all.push_back(variable);
        }
    }
    all.push_back(ours);
    return all;
}

// As C wants a list of words.
std::vector<char*> pointers(std::vector<std::string>& words)
{
    std::vector<char*> out;
    for (std::string& word : words) out.push_back(word.data());
    out.push_back(nullptr);
    return out;
}

// The importer while it runs. Never left behind: whatever happens here, it ends.
class Child {
public:
    Child(const fs::path& program, std::vector<std::string> arguments, int scene, int messages)
    {
        posix_spawn_file_actions_t files;
        posix_spawn_file_actions_init(&files);
        posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_adddup2(&files, messages, 1);
        posix_spawn_file_actions_adddup2(&files, messages, 2);
        posix_spawn_file_actions_adddup2(&files, scene, 3);
        posix_spawn_file_actions_addclosefrom_np(&files, 4);

        // A group of its own: Ctrl-C is for the cook, which then decides.
        posix_spawnattr_t attributes;
        posix_spawnattr_init(&attributes);
        posix_spawnattr_setpgroup(&attributes, 0);
        posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);

        std::vector<std::string> environment = importer_environment();
        const int code = posix_spawn(&pid_, program.c_str(), &files, &attributes,
                                     pointers(arguments).data(), pointers(environment).data());
        posix_spawn_file_actions_destroy(&files);
        posix_spawnattr_destroy(&attributes);
        if (code != 0) fail("could not start " + program.string(), code);
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    ~Child()
    {
        if (pid_ <= 0) return;
        ::kill(pid_, SIGKILL);
        wait();
    }
    // How it ended, as waitpid says.
    int wait()
    {
        int status = 0;
        while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
        }
        pid_ = -1;
        return status;
    }

private:
    pid_t pid_ = -1;
};

// All that comes from `fd` until its other end is closed (the last 1,000 characters of it). False
// when that takes more than `seconds`.
bool listen(int fd, double seconds, const std::function<void()>& check, std::string& text)
{
    using Clock = std::chrono::steady_clock;
    const auto deadline = Clock::now() + std::chrono::duration<double>(seconds);
    for (;;) {
        pollfd ready{fd, POLLIN, 0};
        const int n = ::poll(&ready, 1, 50);
        if (n < 0 && errno != EINTR) fail("waiting for the importer", errno);
        if (n > 0) {
            char piece[1024];
            const ssize_t got = ::read(fd, piece, sizeof piece);
            if (got == 0) return true;
            if (got > 0) text.append(piece, static_cast<std::size_t>(got));
            if (text.size() > 1000) text.erase(0, text.size() - 1000);
        }
        if (Clock::now() > deadline) return false;
        check();
    }
}

std::string last_line(std::string text)
{
    while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
    const auto start = text.rfind('\n');
    return start == std::string::npos ? text : text.substr(start + 1);
}

std::string shorter(double number)
{
    char text[32];
    std::snprintf(text, sizeof text, "%g", number);
    return text;
}

// Exit status 3 says that memory ran out, see import/main.cpp.
constexpr int out_of_memory = 3;

// Why a child that ended with `status` gave nothing; empty when it did give something.
std::string failure(int status, const std::string& said, const ImportLimits& limits)
{
    const std::string export_again =
        "; if it should be fine, open it in a modelling program and export it again, or as OBJ";
    if (WIFEXITED(status)) {
        if (WEXITSTATUS(status) == 0) return "";
        if (WEXITSTATUS(status) == out_of_memory) {
            return "reading it takes more than " + shorter(limits.gigabytes) +
                   " GiB of memory: the file is damaged, or the limit has to be raised";
        }
        return "the importer gave up: " + last_line(said) + export_again;
    }
    if (WTERMSIG(status) == SIGXCPU) {
        return "reading it takes more than " + shorter(limits.seconds) +
               " s: the file is damaged, or the limit has to be raised";
    }
    const std::string why = last_line(said);
    return "the importer crashed on it (" + std::string(::strsignal(WTERMSIG(status))) +
           (why.empty() ? "" : ": " + why) +
           "), so the file is damaged or of a kind that assimp "
           "does not read rightly" +
           export_again;
}

// The scene that lies in the memory file `fd`.
ImportedScene scene_in(int fd)
{
    struct stat about;
    if (::fstat(fd, &about) != 0) fail("looking at the imported scene", errno);
    const auto size = static_cast<std::size_t>(about.st_size);
    if (size == 0) throw std::runtime_error("it is empty");
    void* bytes = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE | MAP_POPULATE, fd, 0);
    if (bytes == MAP_FAILED) fail("mapping the imported scene", errno);
    struct Unmap {
        void* bytes;
        std::size_t size;
        ~Unmap() { ::munmap(bytes, size); }
    } unmap{bytes, size};
    return unpack(static_cast<const char*>(bytes), size);
}

}  // namespace

void want_mesh_file(const fs::path& path)
{
    std::error_code code;
    const fs::file_status status = fs::status(path, code);
    if (!fs::exists(status)) throw std::runtime_error("there is no file " + path.string());
    if (fs::is_directory(status)) {
        throw std::runtime_error(path.string() + " is a folder, a mesh file is needed");
    }
    if (!fs::is_regular_file(status)) {
        throw std::runtime_error(path.string() + " is not a regular file");
    }
    if (::access(path.c_str(), R_OK) != 0) {
        throw std::runtime_error(path.string() + " cannot be read: permission denied");
    }
    if (fs::file_size(path, code) == 0) throw std::runtime_error(path.string() + " is empty");
}

std::string pack(const ImportedScene& scene)
{
    Packing packing;
    pass(packing, const_cast<ImportedScene&>(scene));  // packing does not change it
    return std::move(packing.bytes);
}

ImportedScene unpack(const char* bytes, std::size_t size)
{
    ImportedScene scene;
    Unpacking unpacking{bytes, bytes + size};
    pass(unpacking, scene);
    if (unpacking.at != unpacking.end) throw std::runtime_error("something follows it");
    return scene;
}

ImportedScene import_scene(const fs::path& path, const ImportOptions& options)
{
    want_mesh_file(path);
    const fs::path program = importer_program();

    const Descriptor scene(::memfd_create("aspic-import", MFD_CLOEXEC));
    if (scene.fd < 0) fail("making room for the imported scene", errno);
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) fail("making a pipe", errno);
    const Descriptor messages(ends[0]);
    Descriptor theirs(ends[1]);

    const auto& limits = options.limits;
    Child child(program,
                {"aspic-import", fs::absolute(path).string(),
                 options.root.empty() ? "" : fs::absolute(options.root).string(),
                 std::to_string(limits.gigabytes), std::to_string(limits.seconds)},
                scene.fd, theirs.fd);
    theirs.close();

    std::string said;
    if (!listen(messages.fd, limits.seconds, options.check, said)) {
        throw std::runtime_error(path.string() + ": reading it takes more than " +
                                 shorter(limits.seconds) +
                                 " s: the file is damaged, or the limit has to be raised");
    }
    if (const std::string why = failure(child.wait(), said, limits); !why.empty()) {
        throw std::runtime_error(path.string() + ": " + why);
    }
    try {
        return scene_in(scene.fd);
    } catch (const std::runtime_error& error) {
        throw std::runtime_error(path.string() + ": what " + program.string() +
                                 " made of it is not understood (" + error.what() +
                                 "): is it of the same build?");
    }
}

}  // namespace geometry
