#include "runtime/verify.hpp"

#include <fmt/format.h>

#include <ostream>
#include <unistd.h>

namespace runtime {

namespace {

namespace fs = std::filesystem;

struct TemporaryFolder {
    fs::path path;
    TemporaryFolder()
    {
        std::string pattern = (fs::temp_directory_path() / "aspic-verify-XXXXXX").string();
        if (!mkdtemp(pattern.data())) {
            throw std::runtime_error("no temporary folder can be made in " +
                                     fs::temp_directory_path().string());
        }
        path = pattern;
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    ~TemporaryFolder()
    {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
};

// At most a few lines of one kind.
class Lines {
public:
    Lines(Console& console, std::string rest) : console_(console), rest_(std::move(rest)) {}
    ~Lines()
    {
        if (count > most) console_.out << fmt::format("  and {} more {}\n", count - most, rest_);
    }
    void add(const std::string& line)
    {
        if (++count <= most) console_.out << "  " << line << "\n";
    }
    std::size_t count = 0;

private:
    static constexpr std::size_t most = 10;
    Console& console_;
    std::string rest_;
};

// What went in then and is not the same now.
void tell_changes(const Manifest& then, const Console& console, std::ostream& out)
{
    FileDigests digests;
    std::map<std::string, std::string> files;
    for (const Manifest::File& f : then.documents) files[f.path] = f.digest;
    for (const auto& [name, node] : then.nodes) {
        for (const auto& [param, f] : node.files) files[f.path] = f.digest;
        for (const Manifest::File& f : node.side_files) files[f.path] = f.digest;
    }
    for (const auto& [path, digest] : files) {
        const Key now = digests.of(path);
        if (to_hex(now) == digest) continue;
        out << fmt::format("changed since: {}{}\n", path, now ? "" : " (it is gone)");
    }
    if (then.program != to_hex(console.salt)) {
        out << fmt::format("it was cooked by another build or on another kind of machine (aspic "
                           "{}; this is {})\n",
                           then.version, console.version);
    }
}

// The files beside the manifest that are not what the cook left; returns how many.
std::size_t tell_touched(const Manifest& then, const fs::path& folder, Console& console)
{
    FileDigests digests;
    Lines lines(console, "files");
    for (const Manifest::Output& o : then.outputs) {
        if (o.file.path.empty()) continue;
        const fs::path file = folder / o.file.path;
        const Key now = digests.of(file);
        if (to_hex(now) == o.file.digest) continue;
        lines.add(fmt::format("{} {} the cook", file.string(),
                              now ? "was changed after" : "is gone since"));
    }
    return lines.count;
}

using Place = std::tuple<std::string, int, std::string, std::string>;
Place place_of(const Manifest::Output& o)
{
    return {o.node, o.frame, o.port, o.file.path};
}
std::string describe(const Manifest::Output& o)
{
    return o.port.empty() ? fmt::format("{}, frame {}: {}", o.node, o.frame, o.file.path)
                          : fmt::format("{}.{}, frame {}", o.node, o.port, o.frame);
}

}  // namespace

int verify(const fs::path& given, const CookRequest& request, const graph::Registry& registry,
           Console& console)
{
    const fs::path path = fs::is_directory(given) ? given / manifest_name : given;
    const Manifest then = read_manifest(path);
    tell_changes(then, console, console.out);
    const std::size_t touched = tell_touched(then, path.parent_path(), console);

    const TemporaryFolder folder;
    CookRequest again = request;
    again.files = {then.documents.front().path};
    again.frames = then.frames;
    again.nodes = then.only;
    again.sets = then.sets, again.variables = then.variables;
    // What a manifest says of permissions is worth nothing: it may come from a stranger.
    if ((then.allow_outside && !request.allow_outside) ||
        (!then.root.empty() && request.root.empty() && !request.allow_outside)) {
        throw std::invalid_argument(fmt::format(
            "{}: that cook was allowed to read {}: say {} to allow it again", path.string(),
            then.allow_outside ? "files anywhere" : "all below " + then.root,
            then.allow_outside ? "--allow-outside" : "--root " + then.root));
    }
    again.output_folder = folder.path.string();
    const auto graph = load(again.files[0], again, registry, console);
    if (!graph) return exit_usage;
    const std::unique_ptr<FrontEnd> front_end =
        make_front_end(console.terminal ? Style::terminal : Style::quiet, console);
    Caches caches;
    caches.memory = MemoryCache(request.memory);
    Manifest now;
    const int exit = cook_graph(*graph, again, caches, *front_end, console, now);
    if (exit == exit_cancelled || exit == exit_failed) return exit;

    std::map<Place, const Manifest::Output*> made;
    for (const Manifest::Output& o : now.outputs) made[place_of(o)] = &o;
    std::size_t differ = 0;
    {
        Lines lines(console, "outputs");
        for (const Manifest::Output& o : then.outputs) {
            const auto found = made.find(place_of(o));
            if (found == made.end()) {
                lines.add(describe(o) + " was not made again");
            } else if (found->second->file.digest != o.file.digest) {
                lines.add(describe(o) + " differs");
            }
        }
        differ = lines.count;
    }
    if (differ > 0) {
        console.out << fmt::format("{} of {} outputs differ\n", differ, then.outputs.size());
        return exit_failed;
    }
    console.out << fmt::format("cooked again: {} outputs, all the same{}\n", then.outputs.size(),
                               touched > 0 ? ", but not what lies there now" : "");
    return touched > 0 ? exit_failed : exit_ok;
}

}  // namespace runtime
