#include "runtime/commands/farm_job.hpp"

#include "runtime/cache/quantities.hpp"
#include "runtime/commands/manifest.hpp"
#include "runtime/commands/text_file.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cerrno>
#include <map>
#include <optional>
#include <ostream>
#include <set>
#include <unistd.h>

namespace runtime {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

using Words = std::vector<std::string>;

void add_each(Words& words, const char* option, const std::vector<std::string>& values)
{
    for (const std::string& value : values) {
        words.emplace_back(option);
        words.push_back(value);
    }
}

// The files of one shot, by path: their digests. Of a path that stands there twice, frames share
// the file, and what a part of the frames made of it is not what it is at the end.
std::map<std::string, std::string> files_of(const Manifest& manifest)
{
    std::map<std::string, std::string> files;
    std::set<std::string> shared;
    for (const Manifest::Output& o : manifest.outputs) {
        if (o.file.path.empty()) continue;
        if (!files.emplace(o.file.path, o.file.digest).second) shared.insert(o.file.path);
    }
    for (const std::string& path : shared) files.erase(path);
    return files;
}

std::string kind_of(const Cut& cut, const FarmTask& task)
{
    return cut.shots[task.shot].name + '.' + name_of(task.stage);
}

constexpr double least_measured = 0.5;  // s

// What the tasks of the job in this folder took, and those before it.
std::map<std::string, UsedResources> measured_in(const fs::path& folder)
{
    std::map<std::string, UsedResources> all;
    const auto add = [&](const std::string& kind, const UsedResources& m) {
        all[kind].memory = std::max(all[kind].memory, m.memory);
        all[kind].cores = std::max(all[kind].cores, m.cores);
    };
    try {
        if (fs::exists(folder / "measured.json")) {
            const Json known = Json::parse(read_text(folder / "measured.json"));
            for (const auto& [kind, m] : known.items()) {
                add(kind, {m.at("memory").get<std::uint64_t>(), m.at("cores").get<double>()});
            }
        }
        if (!fs::exists(folder / "plan.json")) return all;
        const Cut cut = cut_from(read_text(folder / "plan.json"));
        for (const FarmTask& task : cut.tasks) {
            const fs::path part = folder / "parts" / (task.name + ".json");
            if (!fs::exists(part)) continue;
            const auto ran = read_manifest(part).ran;
            if (!ran || ran->seconds <= 0) continue;
            // What ended at once spent its time on its start: that tells nothing of its work.
            const UsedResources m{ran->memory, ran->seconds < least_measured ? 0 : ran->cores};
            add(kind_of(cut, task), m);
            if (task.stage == Stage::sweep) continue;
            // The whole cook holds at most what its parts held.
            add(cut.shots[task.shot].name + '.' + name_of(Stage::last), {m.memory, 0});
        }
    } catch (const std::exception&) {
        return all;  // of a damaged file nothing is known
    }
    return all;
}

std::string to_text(const std::map<std::string, UsedResources>& measured)
{
    Json json = Json::object();
    for (const auto& [kind, m] : measured) {
        json[kind] = {{"memory", m.memory}, {"cores", m.cores}};
    }
    return json.dump(1) + "\n";
}

// Where the folders of all settings are.
fs::path sweep_folder(const FarmJob& job, const FarmTask& task)
{
    return job.cut.shots[task.shot].folder.parent_path();
}

// Whether the table of all settings is made of what this last task cooks.
bool is_swept(const Cut& cut, const FarmTask& last)
{
    return std::any_of(cut.tasks.begin(), cut.tasks.end(), [&](const FarmTask& t) {
        return t.stage == Stage::sweep && last.shot >= t.shot &&
               last.shot < t.shot + t.after.size();
    });
}

struct Verifying {
    const FarmJob& job;
    Console& console;
    std::size_t files = 0, wrong = 0, missed = 0;

    void tell(const std::string& text)
    {
        ++wrong;
        console.err << "error: " << text << "\n";
    }
};

std::string machine_of(const Manifest& manifest)
{
    return manifest.ran ? manifest.ran->machine : "an unknown machine";
}

// "task shot.frames-2 (frames 5-8) on n0", by path: of files that a task other than the last one
// made.
std::map<std::string, std::string> makers_of(const Verifying& verifying, std::uint32_t s)
{
    std::map<std::string, std::string> makers;
    for (const FarmTask& task : verifying.job.cut.tasks) {
        if (task.shot != s || task.stage >= Stage::last) continue;
        Manifest part;
        try {
            part = read_manifest(verifying.job.part(task));
        } catch (const std::exception&) {
            continue;  // its files are told without who made them
        }
        for (const auto& [path, digest] : files_of(part)) {
            makers[path] = fmt::format("task {} (frames {}) on {}", task.name,
                                       frames_text(task.frames), machine_of(part));
        }
    }
    return makers;
}

void verify_shot(Verifying& verifying, std::uint32_t s)
{
    const Shot& shot = verifying.job.cut.shots[s];
    const Manifest whole = read_manifest(shot.folder / manifest_name);
    if (!whole.complete) verifying.tell(shot.name + ": the last cook is not complete");
    constexpr std::size_t most_told = 4;  // of a shot: one expectation may be missed at each frame
    const std::size_t told = std::min(most_told, whole.missed.size());
    for (std::size_t i = 0; i < told; ++i) {
        verifying.console.err << fmt::format("missed: {}, {}\n", shot.name, whole.missed[i]);
    }
    if (whole.missed.size() > told) {
        verifying.console.err << fmt::format("  and {} more, which {} lists\n",
                                             whole.missed.size() - told,
                                             (shot.folder / manifest_name).string());
    }
    verifying.missed += whole.missed.size();
    FileDigests digests;
    std::optional<std::map<std::string, std::string>> makers;  // where something is wrong
    for (const Manifest::Output& o : whole.outputs) {
        if (o.file.path.empty()) continue;
        ++verifying.files;
        const Key now = digests.of(shot.folder / o.file.path);
        if (to_hex(now) == o.file.digest || (now && o.file.digest.empty())) continue;
        if (!makers) makers = makers_of(verifying, s);
        const auto found = makers->find(o.file.path);
        const std::string maker =
            found != makers->end() ? found->second : "the last task on " + machine_of(whole);
        verifying.tell(fmt::format("{}, '{}', frame {}: {} is {} cooked by {}", shot.name, o.node,
                                   o.frame, (shot.folder / o.file.path).string(),
                                   now ? "not what was" : "missing that was", maker));
    }
    const auto files = files_of(whole);
    for (const FarmTask& task : verifying.job.cut.tasks) {
        if (task.shot != s || task.stage >= Stage::last) continue;
        const Manifest part = read_manifest(verifying.job.part(task));
        const std::string machine = machine_of(part);
        if (part.program != whole.program) {
            verifying.tell(
                fmt::format("task {} ran another build of the program on {}", task.name, machine));
        }
        for (const auto& [path, digest] : files_of(part)) {
            const auto found = files.find(path);
            if (found == files.end() || found->second == digest) continue;
            verifying.tell(fmt::format("task {} made another {} on {} than the last cook found",
                                       task.name, path, machine));
        }
    }
}

// The table and the sheet of all settings.
void verify_sweep(Verifying& verifying, const FarmTask& task)
{
    const Manifest part = read_manifest(verifying.job.part(task));
    FileDigests digests;
    for (const Manifest::Output& o : part.outputs) {
        ++verifying.files;
        const Key now = digests.of(sweep_folder(verifying.job, task) / o.file.path);
        if (to_hex(now) == o.file.digest) continue;
        verifying.tell(fmt::format("task {}: {} {}", task.name, o.file.path,
                                   now ? "is not what was written" : "is missing"));
    }
}

// Without a cache, each task would cook for itself what those before it have cooked.
void require_shared(const fs::path& cache)
{
    std::error_code error;
    fs::create_directories(cache, error);
    if (!error && ::access(cache.c_str(), W_OK) != 0) error = {errno, std::generic_category()};
    if (!error) return;
    throw std::invalid_argument(fmt::format(
        "farm: the cache folder {} can't be written ({}), and tasks hand on their results through "
        "it; use --cache DIR",
        cache.string(), error.message()));
}

}  // namespace

fs::path farm_folder(const CookRequest& request)
{
    fs::path folder = request.output_folder.empty() ? "out" : request.output_folder;
    if (request.files.size() == 1 && request.output_folder.empty()) {
        folder /= fs::path(request.files[0]).stem();
    }
    return fs::absolute(folder / "farm").lexically_normal();
}

UsedResources FarmJob::measured_of(const FarmTask& task) const
{
    const auto found = measured.find(kind_of(cut, task));
    return found == measured.end() ? UsedResources{} : found->second;
}

FarmJob read_job(const CookRequest& request)
{
    FarmJob job;
    job.folder = farm_folder(request);
    job.request = request;
    if (!fs::exists(job.folder / "plan.json")) {
        throw std::invalid_argument(job.folder.string() +
                                    " holds no job; send one with aspic farm FILE --engine NAME");
    }
    try {
        job.cut = cut_from(read_text(job.folder / "plan.json"));
    } catch (const Json::exception&) {
        throw std::invalid_argument(
            (job.folder / "plan.json").string() +
            ": expected a plan that aspic farm wrote; the farm command that "
            "sent the job writes it again");
    }
    return job;
}

FarmJob new_job(Cut cut, const CookRequest& request, const Console& console)
{
    const fs::path cache =
        request.cache.empty() ? DiskCache::default_folder() : fs::path(request.cache);
    if (cache.empty()) {
        throw std::invalid_argument("farm: no cache folder: HOME is not set; use --cache DIR");
    }
    require_shared(cache);
    return {std::move(cut),
            farm_folder(request),
            fs::absolute(cache).lexically_normal(),
            console.program,
            request,
            {},
            {},
            {}};
}

void begin_job(FarmJob& job)
{
    make_output_folder(job.folder);
    job.measured = measured_in(job.folder);
    replace_text(job.folder / "measured.json", to_text(job.measured));
    for (const char* const name : {"jobs.txt", "slurm.log", "submit.sh", "job.template.json"})
        fs::remove(job.folder / name);
    for (const char* const name : {"parts", "logs", "jobs"}) {
        fs::remove_all(job.folder / name);
        make_output_folder(job.folder / name);
    }
    replace_text(job.folder / "plan.json", plan_json(job.cut));
}

Words words_of(const FarmJob& job, const FarmTask& task)
{
    const Shot& shot = job.cut.shots[task.shot];
    const bool last = task.stage == Stage::last, sweep = task.stage == Stage::sweep;
    Words words{job.program.string(), sweep ? "sweep" : "cook", shot.file};
    if (sweep) add_each(words, "--vary", job.vary);
    add_each(words, "--node", last ? job.request.nodes : task.nodes);
    if (!(last || sweep) || !job.request.frames.empty()) {
        words.insert(words.end(), {"--frames", frames_text(task.frames)});
    }
    add_each(words, "--set", sweep ? job.request.sets : shot.sets);
    add_each(words, "--var", sweep ? job.request.variables : shot.variables);
    if (!job.request.root.empty()) {
        words.insert(words.end(), {"--root", fs::absolute(job.request.root).string()});
    }
    if (job.request.allow_outside) words.emplace_back("--allow-outside");
    // A frame that fails stops none that can be cooked.
    if (!sweep) words.emplace_back("--keep-going");
    // A scheduler would drop the table where a setting failed: the table's task tells it instead.
    if (last && is_swept(job.cut, task)) words.emplace_back("--record-missed");
    const fs::path folder = sweep ? sweep_folder(job, task) : shot.folder;
    words.insert(words.end(), {"--out", folder.string(), "--cache", job.cache.string(),
                               "--cache-size", std::to_string(job.request.cache_budget)});
    if (job.request.threads > 0) {
        words.insert(words.end(), {"--threads", std::to_string(job.request.threads)});
    }
    if (!last) words.insert(words.end(), {"--part", job.part(task).string()});
    return words;
}

std::string shell_line(const Words& words)
{
    std::string line;
    for (const std::string& word : words) {
        if (!line.empty()) line += ' ';
        const bool plain =
            !word.empty() && word.find_first_not_of("abcdefghijklmnopqrstuvwxyz"
                                                    "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                                    "0123456789_./-=,:+@%") == std::string::npos;
        if (plain) {
            line += word;
            continue;
        }
        line += '\'';
        for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
        line += '\'';
    }
    return line;
}

Words said_into(const fs::path& file, Words words)
{
    words.insert(words.begin(), {"sh", "-c", "exec \"$@\" >\"$0\" 2>&1", file.string()});
    return words;
}

int verify_job(const FarmJob& job, Console& console)
{
    Verifying verifying{job, console};
    const auto attempt = [&](const auto& verify) {
        try {
            verify();
        } catch (const std::invalid_argument& e) {
            verifying.tell(e.what());
        }
    };
    for (std::uint32_t s = 0; s < job.cut.shots.size(); ++s) {
        attempt([&] { verify_shot(verifying, s); });
    }
    for (const FarmTask& task : job.cut.tasks) {
        if (task.stage == Stage::sweep) attempt([&] { verify_sweep(verifying, task); });
    }
    if (verifying.wrong > 0) {
        console.err << "not what was cooked: the same farm command cooks what is wrong again\n";
    }
    if (verifying.wrong == 0 && !job.request.quiet) {
        console.out << fmt::format("verified: {} files of {} cook{} are what their manifests say\n",
                                   verifying.files, job.cut.shots.size(),
                                   job.cut.shots.size() == 1 ? "" : "s");
    }
    return verifying.wrong > 0 ? exit_failed : verifying.missed > 0 ? exit_missed : exit_ok;
}

}  // namespace runtime
