// Parts: the shots that are asked for and their pieces, the plan as text, the plan as JSON.

#include "runtime/commands/farm_plan.hpp"

#include "runtime/cache/quantities.hpp"
#include "runtime/commands/manifest.hpp"
#include "runtime/commands/sweep.hpp"
#include "runtime/cook/evaluator.hpp"
#include "runtime/farm/schedule.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>
#include <set>

namespace runtime {

namespace {

namespace fs = std::filesystem;

// Seconds of each node in an earlier cook of the same folder.
SecondsOf seconds_before(const fs::path& folder)
{
    SecondsOf seconds;
    if (!fs::exists(folder / manifest_name)) return seconds;
    try {
        for (const auto& [name, node] : read_manifest(folder / manifest_name).nodes) {
            if (node.seconds > 0) seconds[name] = node.seconds;
        }
    } catch (const std::invalid_argument&) {
        return {};  // whatever lies there, it tells no times
    }
    return seconds;
}

// A shot of whose times nothing was known when its turn came.
struct Dark {
    std::size_t place;  // of the shot
    graph::Graph graph;
    CookRequest request;
};

struct Planning {
    const CookRequest& request;
    const FarmRequest& farm;
    const graph::Registry& registry;
    Console& console;
    Caches& caches;
    const Stored stored;
    SecondsOf usual;
    std::vector<ShotPieces> shots;
    std::vector<Dark> dark;
    std::vector<char> to_sweep;  // by document: it makes numbers or pictures
};

ShotPieces pieces_of(Planning& planning, const graph::Graph& graph, const CookRequest& request,
                     Shot shot)
{
    Options options;
    options.threads = request.threads;
    options.output_folder = shot.folder;
    options.salt = planning.console.salt;
    Evaluator evaluator(graph, planning.caches, options);
    const std::vector<int> frames = chosen_frames(graph, request);
    const std::vector<std::uint32_t> targets = chosen_nodes(graph, request);
    std::vector<Want> wants;
    for (const int f : frames) {
        for (const std::uint32_t n : targets) wants.push_back({n, f});
    }
    evaluator.aim(wants);
    const NodeCosts costs = node_costs(graph, evaluator.keys(), targets, frames, planning.stored,
                                       seconds_before(shot.folder), planning.usual);
    shot.measured = costs.measured;
    ShotPieces pieces{std::move(shot), frames, {}};
    pieces.cut = cut_graph({graph, evaluator.keys(), targets, frames, planning.stored, costs,
                            planning.farm.task_seconds});
    pieces.shot.results = pieces.cut.results;
    pieces.shot.held = pieces.cut.held;
    return pieces;
}

// One document at every combination of settings. False when it has errors.
bool add_shots(Planning& planning, const std::string& file, const std::vector<Settings>& settings)
{
    planning.to_sweep.push_back(1);
    for (std::size_t i = 0; i < settings.size(); ++i) {
        CookRequest request = planning.request;
        for (const graph::Override& s : settings[i]) {
            auto& those = is_variable(s.target) ? request.variables : request.sets;
            those.push_back(s.target + '=' + s.value);
        }
        auto graph = load(file, request, planning.registry, planning.console);
        if (!graph) return false;
        if (!makes_numbers_or_pictures(*graph)) planning.to_sweep.back() = 0;
        Shot shot;
        shot.name = fs::path(file).stem().string();
        shot.file = fs::absolute(file).lexically_normal().string();
        shot.sets = request.sets, shot.variables = request.variables;
        fs::path folder = output_folder(*graph, planning.request);
        if (settings.size() > 1) {
            const std::string number = fmt::format("{:03}", i + 1);
            folder /= number;
            shot.name += '-' + number;
        }
        shot.folder = fs::absolute(folder).lexically_normal();
        planning.shots.push_back(pieces_of(planning, *graph, request, std::move(shot)));
        if (!planning.shots.back().shot.measured) {
            planning.dark.push_back({planning.shots.size() - 1, std::move(*graph), request});
        }
    }
    return true;
}

// Once more those that came before the first shot whose times are known: nodes of the same types
// take about as long.
void look_again(Planning& planning)
{
    if (planning.usual.empty()) return;
    for (const Dark& dark : planning.dark) {
        ShotPieces& pieces = planning.shots[dark.place];
        pieces = pieces_of(planning, dark.graph, dark.request, pieces.shot);
    }
}

void require_other_names(const std::vector<ShotPieces>& shots)
{
    std::set<std::string> names;
    for (const ShotPieces& s : shots) {
        if (names.insert(s.shot.name).second) continue;
        throw std::invalid_argument(fmt::format(
            "expected documents of different names, found '{}' twice: their output folders would "
            "be the same",
            s.shot.name));
    }
}

// After all settings of each document that is to be swept, what `aspic sweep` makes of them.
void add_sweeps(Cut& cut, std::size_t settings, const std::vector<char>& to_sweep)
{
    std::vector<std::uint32_t> lasts;  // the task of each shot
    for (std::uint32_t t = 0; t < cut.tasks.size(); ++t) {
        if (cut.tasks[t].stage == Stage::last) lasts.push_back(t);
    }
    for (std::size_t first = 0; first < lasts.size(); first += settings) {
        if (!to_sweep[first / settings]) continue;
        FarmTask sweep;
        sweep.name = fs::path(cut.shots[first].file).stem().string() + ".sweep";
        sweep.stage = Stage::sweep;
        sweep.shot = static_cast<std::uint32_t>(first);
        sweep.frames = {cut.tasks[lasts[first]].frames.back()};
        sweep.after.assign(lasts.begin() + static_cast<std::ptrdiff_t>(first),
                           lasts.begin() + static_cast<std::ptrdiff_t>(first + settings));
        cut.tasks.push_back(std::move(sweep));
    }
}

std::string nodes_text(const FarmTask& task)
{
    if (task.stage == Stage::sweep) return "table and sheet of all settings";
    if (task.nodes.empty()) return "the whole cook";
    return fmt::format("{}", fmt::join(task.nodes, ", "));
}

// Tasks of one shot, one stage and the same nodes are one line.
struct PlanLine {
    const FarmTask* first = nullptr;
    std::size_t tasks = 0;
    double seconds = 0, longest = 0;
    std::vector<int> frames;
};

std::vector<PlanLine> lines_of(const Cut& cut, std::uint32_t shot)
{
    std::vector<PlanLine> lines;
    for (const FarmTask& task : cut.tasks) {
        if (task.shot != shot) continue;
        if (lines.empty() || lines.back().first->stage != task.stage ||
            lines.back().first->nodes != task.nodes) {
            lines.push_back({&task, 0, 0, 0, {}});
        }
        PlanLine& line = lines.back();
        ++line.tasks;
        line.seconds += task.seconds;
        line.longest = std::max(line.longest, task.seconds);
        line.frames.insert(line.frames.end(), task.frames.begin(), task.frames.end());
    }
    for (PlanLine& line : lines) std::sort(line.frames.begin(), line.frames.end());
    return lines;
}

std::string shot_text(const Cut& cut, std::uint32_t s)
{
    const Shot& shot = cut.shots[s];
    std::string text = fmt::format(
        "{}: {} of {} results are in the cache{}\n", shot.name, shot.held, shot.results,
        shot.measured ? "" : "; no time was measured yet, a node is taken for 1 s a frame");
    for (const PlanLine& line : lines_of(cut, s)) {
        text += fmt::format("  {:<7} {:>6} {:>9} {:>9}  {:<14} {}\n", name_of(line.first->stage),
                            line.tasks, format_seconds(line.longest), format_seconds(line.seconds),
                            shortened(frames_text(line.frames), 14), nodes_text(*line.first));
    }
    return text;
}

constexpr std::size_t most_shots_shown = 20;

}  // namespace

std::string shortened(std::string text, std::size_t most)
{
    if (text.size() <= most) return text;
    std::size_t end = most - 3;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
    return text.replace(end, std::string::npos, "...");
}

std::optional<Cut> plan_farm(const CookRequest& request, const FarmRequest& farm,
                             const graph::Registry& registry, Console& console)
{
    Caches caches;
    caches.disk = open_cache(request, console);
    caches.side_files.remember_in(caches.disk.get());
    Planning planning{request, farm, registry, console, caches, Stored(caches.disk.get()),
                      {},      {},   {},       {}};
    std::vector<Vary> varied;
    for (const std::string& text : farm.vary) varied.push_back(parse_vary(text));
    const std::vector<Settings> settings = combinations(varied);
    bool good = true;
    for (const std::string& file : request.files) {
        good = add_shots(planning, file, settings) && good;
    }
    if (!good) return std::nullopt;
    require_other_names(planning.shots);
    look_again(planning);
    Cut cut = join(planning.shots, farm.task_seconds);
    if (settings.size() > 1 && request.nodes.empty()) {
        add_sweeps(cut, settings.size(), planning.to_sweep);
    }
    return cut;
}

std::string plan_text(const Cut& cut)
{
    std::string text = "  stage    tasks   longest       all  frames         nodes\n";
    for (std::uint32_t s = 0; s < std::min(cut.shots.size(), most_shots_shown); ++s) {
        text += shot_text(cut, s);
    }
    if (cut.shots.size() > most_shots_shown) {
        text += fmt::format("and {} more shots\n", cut.shots.size() - most_shots_shown);
    }
    double work = 0;
    for (const FarmTask& task : cut.tasks) work += task.seconds;
    text += fmt::format("{} task{}, {} of work\n", cut.tasks.size(),
                        cut.tasks.size() == 1 ? "" : "s", format_seconds(work));
    std::vector<std::string> path;
    for (const std::uint32_t t : critical_path(cut)) path.push_back(cut.tasks[t].name);
    text += fmt::format("longest path: {}: {}\n", format_seconds(makespan(cut, cut.tasks.size())),
                        fmt::join(path, ", "));
    std::string machines = "machines", times = "time    ";
    for (const int n : machine_counts) {
        const std::string time = format_seconds(makespan(cut, static_cast<std::size_t>(n)));
        const std::size_t width = std::max<std::size_t>(time.size(), 4);
        machines += fmt::format("  {:>{}}", n, width);
        times += fmt::format("  {:>{}}", time, width);
    }
    return text + machines + '\n' + times + '\n';
}

std::string plan_json(const Cut& cut)
{
    using Json = nlohmann::ordered_json;
    Json json;
    json["aspic_farm"] = 1;
    json["shots"] = Json::array();
    for (const Shot& s : cut.shots) {
        json["shots"].push_back({{"name", s.name},
                                 {"file", s.file},
                                 {"set", s.sets},
                                 {"var", s.variables},
                                 {"folder", s.folder.string()},
                                 {"results", s.results},
                                 {"held", s.held},
                                 {"measured", s.measured}});
    }
    json["tasks"] = Json::array();
    for (const FarmTask& t : cut.tasks) {
        Json after = Json::array();
        for (const std::uint32_t before : t.after) after.push_back(cut.tasks[before].name);
        json["tasks"].push_back({{"name", t.name},
                                 {"stage", name_of(t.stage)},
                                 {"shot", cut.shots[t.shot].name},
                                 {"node", t.nodes},
                                 {"frames", frames_text(t.frames)},
                                 {"after", std::move(after)},
                                 {"seconds", t.seconds}});
    }
    json["critical_path"] = Json::array();
    for (const std::uint32_t t : critical_path(cut)) {
        json["critical_path"].push_back(cut.tasks[t].name);
    }
    json["machines"] = Json::array();
    for (const int n : machine_counts) {
        json["machines"].push_back(
            {{"count", n}, {"seconds", makespan(cut, static_cast<std::size_t>(n))}});
    }
    return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Cut cut_from(const std::string& text)
{
    const auto json = nlohmann::json::parse(text);
    Cut cut;
    std::map<std::string, std::uint32_t> shots, tasks;
    for (const auto& s : json.at("shots")) {
        Shot shot;
        shot.name = s.at("name").get<std::string>();
        shot.file = s.at("file").get<std::string>();
        shot.sets = s.at("set").get<std::vector<std::string>>();
        shot.variables = s.value("var", std::vector<std::string>());
        shot.folder = s.at("folder").get<std::string>();
        shot.measured = s.at("measured").get<bool>();
        shots[shot.name] = static_cast<std::uint32_t>(cut.shots.size());
        cut.shots.push_back(std::move(shot));
    }
    for (const auto& t : json.at("tasks")) {
        FarmTask task;
        task.name = t.at("name").get<std::string>();
        const auto stage = t.at("stage").get<std::string>();
        for (const Stage s : all_stages) {
            if (stage == name_of(s)) task.stage = s;
        }
        task.shot = shots[t.at("shot").get<std::string>()];
        task.nodes = t.at("node").get<std::vector<std::string>>();
        task.frames = parse_frames(t.at("frames").get<std::string>());
        for (const auto& before : t.at("after")) {
            task.after.push_back(tasks[before.get<std::string>()]);
        }
        task.seconds = t.at("seconds").get<double>();
        tasks[task.name] = static_cast<std::uint32_t>(cut.tasks.size());
        cut.tasks.push_back(std::move(task));
    }
    return cut;
}

}  // namespace runtime
