#include "geometry/io/library_process.hpp"

#include "geometry/base/beside_program.hpp"
#include "geometry/base/descriptor.hpp"
#include "geometry/base/run_program.hpp"

#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace geometry {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail_at(const std::string& what, int code)
{
    throw std::runtime_error(what + ": " + std::strerror(code));
}

std::string missing(const LibraryProgram& program, const std::string& where)
{
    return std::string(program.name) + ", " + program.does + ", is not " + where + ": " +
           program.missing;
}

// Our own environment, with large pages for what they allocate: assimp clears 16 MB for
// any OBJ, and a file of one face then takes 6 ms, against 15 in pages of 4 KiB.
std::vector<std::string> its_environment()
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

std::string last_line(std::string text)
{
    while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
    const auto start = text.rfind('\n');
    return start == std::string::npos ? text : text.substr(start + 1);
}

// Exit status 3 says that memory ran out, see library_main.hpp.
constexpr int out_of_memory = 3;

LibraryRun how_it_ended(int status, const std::string& said)
{
    using End = LibraryRun::End;
    const std::string why = last_line(said);
    if (WIFEXITED(status)) {
        if (WEXITSTATUS(status) == 0) return {End::fine, why};
        return {WEXITSTATUS(status) == out_of_memory ? End::out_of_memory : End::gave_up, why};
    }
    if (WTERMSIG(status) == SIGXCPU) return {End::out_of_time, why};
    return {End::crashed,
            std::string(::strsignal(WTERMSIG(status))) + (why.empty() ? "" : ": " + why)};
}

// Hands on what lies in the memory file `fd`.
void read_memory(int fd, const std::string& maker,
                 const std::function<void(const char*, std::size_t)>& use)
{
    struct stat about;
    if (::fstat(fd, &about) != 0) fail_at("could not look at the result of " + maker, errno);
    const auto size = static_cast<std::size_t>(about.st_size);
    if (size == 0) throw std::runtime_error("it is empty");
    void* bytes = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE | MAP_POPULATE, fd, 0);
    if (bytes == MAP_FAILED) fail_at("could not map the result of " + maker, errno);
    struct Unmap {
        void* bytes;
        std::size_t size;
        ~Unmap() { ::munmap(bytes, size); }
    } unmap{bytes, size};
    use(static_cast<const char*>(bytes), size);
}

// A file in memory that holds `bytes`, to be read from its start.
int memory_file(std::string_view bytes, const std::string& reader)
{
    const int fd = ::memfd_create(reader.c_str(), MFD_CLOEXEC);
    if (fd < 0) fail_at("could not make a file in memory for " + reader, errno);
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t n = ::pwrite(fd, bytes.data() + done, bytes.size() - done, off_t(done));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) {
            const int code = errno;
            ::close(fd);
            fail_at("could not hand anything to " + reader, code);
        }
        done += static_cast<std::size_t>(n);
    }
    return fd;
}

}  // namespace

fs::path path_of(const LibraryProgram& program)
{
    if (const char* named = std::getenv(program.variable); named && *named) return named;
    return beside_program(program.name);
}

std::string shorter(double number)
{
    char text[32];
    std::snprintf(text, sizeof text, "%g", number);
    return text;
}

std::string why_missing(const LibraryProgram& program)
{
    const fs::path place = path_of(program);
    std::error_code none;
    if (place.empty()) {
        const fs::path here = fs::read_symlink("/proc/self/exe", none).parent_path();
        return missing(program, "in " + here.string());
    }
    const bool is_on_path = !place.has_parent_path();  // run_program() looks there
    if (is_on_path || fs::exists(place, none)) return {};
    return missing(program, "at " + place.string());
}

LibraryRun run_library(const LibraryProgram& program, std::vector<std::string> words,
                       std::string_view input, const ProcessLimits& limits,
                       const std::function<void()>& check,
                       const std::function<void(const char* bytes, std::size_t size)>& use)
{
    if (const std::string why = why_missing(program); !why.empty()) throw std::runtime_error(why);
    const fs::path place = path_of(program);
    const Descriptor given(memory_file(input, program.name)), made(memory_file({}, program.name));
    words.insert(words.begin(), place.string());
    words.push_back(std::to_string(limits.gigabytes));
    words.push_back(std::to_string(limits.seconds));
    const ProgramRun run = run_program(
        {std::move(words), its_environment(), given.fd, made.fd, limits.seconds}, check);
    if (!run.found) fail_at("could not start " + place.string(), ENOENT);
    if (!run.in_time) return {LibraryRun::End::out_of_time, last_line(run.said)};
    LibraryRun ended = how_it_ended(run.status, run.said);
    if (ended.end != LibraryRun::End::fine) return ended;
    try {
        read_memory(made.fd, program.name, use);
    } catch (const std::runtime_error& error) {
        return {LibraryRun::End::not_understood, "the result of " + place.string() +
                                                     " was not understood (" + error.what() +
                                                     "): is it of the same build as this program?"};
    }
    return ended;
}

}  // namespace geometry
