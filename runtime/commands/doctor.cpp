#include "runtime/commands/doctor.hpp"

#include "runtime/cache/quantities.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <ostream>
#include <sstream>
#include <thread>
#include <unistd.h>

namespace runtime {

namespace {

namespace fs = std::filesystem;

struct Checkup {
    Console& console;
    bool good = true;

    void ok(const char* what, const std::string& text) { line("ok", what, text); }
    void warn(const char* what, const std::string& text) { line("warn", what, text); }
    void fail(const char* what, const std::string& text)
    {
        good = false;
        line("FAIL", what, text);
    }

private:
    void line(const char* state, const char* what, const std::string& text)
    {
        console.out << fmt::format("{:<5} {:<13} {}\n", state, what, text) << std::flush;
    }
};

// Where a program is found; empty when it is nowhere on the PATH.
fs::path program(const std::string& name)
{
    const char* const path = std::getenv("PATH");
    std::istringstream folders(path ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');) {
        const fs::path file = fs::path(folder) / name;
        if (::access(file.c_str(), X_OK) == 0) return file;
    }
    return {};
}

void check_cache(const CookRequest& request, Checkup& all)
{
    const fs::path folder =
        request.cache.empty() ? DiskCache::default_folder() : fs::path(request.cache);
    if (folder.empty()) {
        return all.warn("cache folder",
                        "none: HOME is not set, so results are not kept; use --cache DIR");
    }
    std::error_code error;
    fs::create_directories(folder, error);
    const fs::path trial = folder / fmt::format("doctor.{}~", ::getpid());
    std::ofstream(trial) << "x";
    const bool writable = fs::file_size(trial, error) == 1 && !error;
    fs::remove(trial, error);
    if (!writable) {
        return all.warn("cache folder",
                        folder.string() +
                            " can't be written, so results are not kept; use --cache DIR");
    }
    const DiskUse use = DiskCache(folder, request.cache_budget, nullptr).use();
    const fs::space_info space = fs::space(folder, error);
    const std::string text = fmt::format(
        "{}: {} of {} used, {} free on its disk", folder.string(),
        format_bytes(static_cast<double>(use.bytes)),
        format_bytes(static_cast<double>(request.cache_budget)),
        error ? "an unknown amount" : format_bytes(static_cast<double>(space.available)));
    constexpr std::uintmax_t little = std::uintmax_t{1} << 30;
    !error&& space.available < little ? all.warn("cache folder", text)
                                      : all.ok("cache folder", text);
    if (use.aside > 0) {
        all.warn(
            "cache folder",
            fmt::format("{} damaged files in aside/; if there are more each time, check the disk",
                        use.aside));
    }
}

// A program that Aspic runs to read files: where `variable` says, or installed with it. Empty where
// it is not.
fs::path reader(const char* name, const char* variable)
{
    std::error_code error;
    if (const char* const named = std::getenv(variable); named && *named) {
        return ::access(named, X_OK) == 0 ? named : "";
    }
    const fs::path here = fs::read_symlink("/proc/self/exe", error).parent_path();
    for (const fs::path& file :
         {here / name, here / ".." / name, here / "../libexec/aspic" / name}) {
        if (::access(file.c_str(), X_OK) == 0) return file;
    }
    return {};
}

void check_readers(Checkup& all)
{
    const fs::path assimp = reader("aspic-assimp", "ASPIC_ASSIMP");
    assimp.empty() ? all.fail("aspic-assimp", "not found beside the program, so ReadMesh fails; "
                                              "build it, or set ASPIC_ASSIMP to its path")
                   : all.ok("aspic-assimp", assimp.string());
    const fs::path openvdb = reader("aspic-openvdb", "ASPIC_OPENVDB");
    openvdb.empty()
        ? all.warn("aspic-openvdb", "not found beside the program, so ReadVolume fails; install "
                                    "libopenvdb-dev and libboost-iostreams-dev and build again")
        : all.ok("aspic-openvdb", openvdb.string());
}

}  // namespace

int doctor(const CookRequest& request, Console& console)
{
    Checkup all{console};
    all.ok("aspic", console.version + ", program identity " + to_hex(console.salt));
    const unsigned threads = std::thread::hardware_concurrency();
    all.ok("threads", std::to_string(threads));
    const long pages = ::sysconf(_SC_PHYS_PAGES), page = ::sysconf(_SC_PAGESIZE);
    if (pages > 0 && page > 0) {
        all.ok("memory", format_bytes(static_cast<double>(pages) * static_cast<double>(page)));
    }
    if (console.opengl) {
        try {
            all.ok("OpenGL", console.opengl());
        } catch (const std::exception& e) {
            all.fail("OpenGL", e.what());
        }
    }
    check_readers(all);
    check_cache(request, all);
    const auto look_for = [&](const char* name, const char* package, const char* without) {
        const fs::path found = program(name);
        found.empty()
            ? all.warn(name, fmt::format("not found, so {}; install the Debian package {}", without,
                                         package))
            : all.ok(name, found.string());
    };
    look_for("ffmpeg", "ffmpeg", "WriteVideo makes no video");
    look_for("gnuplot", "gnuplot-nox", "`aspic study` draws no plot");
    look_for("dot", "graphviz", "`aspic graph` can't be drawn");
    return all.good ? exit_ok : exit_failed;
}

void add_doctor_command(const CommandSet& set)
{
    CLI::App* doctor_app = set.app.add_subcommand(
        "doctor", "Checks that this machine has everything that cooking needs");
    add_cache_options(*doctor_app, set.request);
    doctor_app->callback([&set] { set.exit = doctor(set.request, set.console); });
}

}  // namespace runtime
