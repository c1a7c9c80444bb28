#include "runtime/farm/cut.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <unordered_map>

namespace runtime {

namespace {

struct Joining {
    Cut cut;
    double task_seconds;
    std::unordered_map<Key, int, KeyHash> graphs;            // that have a still node, by its key
    std::unordered_map<Key, std::uint32_t, KeyHash> making;  // what is made once: its task
};

std::uint32_t add_task(Joining& joining, FarmTask task)
{
    joining.cut.tasks.push_back(std::move(task));
    return static_cast<std::uint32_t>(joining.cut.tasks.size() - 1);
}

// Still nodes that several tasks need: those of them that others than shared ones take up. `many`:
// several tasks of this shot begin with them.
std::vector<std::uint32_t> shared_ends(const Joining& joining, const GraphPieces& cut, bool many)
{
    const auto shared = [&](const Still& s) { return many || joining.graphs.at(s.key) > 1; };
    std::vector<char> ends(cut.still.size(), 0);
    for (std::size_t i = 0; i < cut.still.size(); ++i) {
        ends[i] = cut.still[i].used;
        if (shared(cut.still[i])) continue;
        for (const std::uint32_t input : cut.still[i].inputs) ends[input] = 1;
    }
    std::vector<std::uint32_t> out;
    for (std::uint32_t i = 0; i < cut.still.size(); ++i) {
        if (ends[i] && shared(cut.still[i])) out.push_back(i);
    }
    return out;
}

// What is left to do for these still nodes and those before them.
double seconds_left(const std::vector<Still>& still, const std::vector<std::uint32_t>& of)
{
    std::vector<char> wanted(still.size(), 0);
    for (const std::uint32_t i : of) wanted[i] = 1;
    double sum = 0;
    for (std::size_t i = still.size(); i-- > 0;) {
        if (!wanted[i] || still[i].held) continue;
        sum += still[i].seconds;
        for (const std::uint32_t input : still[i].inputs) wanted[input] = 1;
    }
    return sum;
}

std::vector<std::uint32_t> all_used(const std::vector<Still>& still)
{
    std::vector<std::uint32_t> out;
    for (std::uint32_t i = 0; i < still.size(); ++i) {
        if (still[i].used) out.push_back(i);
    }
    return out;
}

// The task that makes what this shot shares; nothing when that is not worth one.
std::optional<std::uint32_t> add_shared(Joining& joining, std::uint32_t shot,
                                        const ShotPieces& pieces, bool many)
{
    const auto& still = pieces.cut.still;
    const auto ends = shared_ends(joining, pieces.cut, many);
    const bool measured = joining.cut.shots[shot].measured;
    const double seconds = measured ? seconds_left(still, ends) : 1;
    if (ends.empty() || (measured && seconds < joining.task_seconds / 30)) return {};
    std::vector<Key> keys;
    FarmTask task;
    task.name = joining.cut.shots[shot].name + ".shared";
    task.stage = Stage::shared;
    task.shot = shot;
    for (const std::uint32_t i : ends) {
        keys.push_back(still[i].key);
        task.nodes.push_back(still[i].node);
    }
    std::sort(keys.begin(), keys.end());
    KeyBuilder all;
    for (const Key& key : keys) all.add(key);
    task.frames = {pieces.frames.front()};
    task.seconds = seconds;
    const auto [found, is_new] = joining.making.try_emplace(all.key(), 0);
    if (is_new) found->second = add_task(joining, std::move(task));
    return found->second;
}

// The last task of a shot waits for those that no other one waits for.
void add_last(Joining& joining, std::uint32_t shot, const ShotPieces& pieces,
              const std::vector<std::uint32_t>& mine, double seconds)
{
    FarmTask last;
    last.name = joining.cut.shots[shot].name + ".last";
    last.shot = shot;
    last.frames = pieces.frames;
    last.seconds = seconds;
    std::vector<std::uint32_t> waited_for;
    for (const std::uint32_t t : mine) {
        const auto& after = joining.cut.tasks[t].after;
        waited_for.insert(waited_for.end(), after.begin(), after.end());
    }
    std::sort(waited_for.begin(), waited_for.end());
    for (const std::uint32_t t : mine) {
        if (!std::binary_search(waited_for.begin(), waited_for.end(), t)) last.after.push_back(t);
    }
    std::sort(last.after.begin(), last.after.end());
    last.after.erase(std::unique(last.after.begin(), last.after.end()), last.after.end());
    add_task(joining, std::move(last));
}

void add_shot(Joining& joining, const ShotPieces& pieces)
{
    const auto shot = static_cast<std::uint32_t>(joining.cut.shots.size());
    joining.cut.shots.push_back(pieces.shot);
    const auto& all = pieces.cut.pieces;
    double work = pieces.cut.last_seconds;
    for (const Piece& piece : all) work += piece.seconds;
    const double still = seconds_left(pieces.cut.still, all_used(pieces.cut.still));
    const bool whole = all.empty() || work + still < joining.task_seconds;
    const auto beginning =
        std::count_if(all.begin(), all.end(), [](const Piece& p) { return p.after.empty(); });
    const bool needed = !all.empty() || pieces.cut.held < pieces.cut.results;
    std::optional<std::uint32_t> shared;
    if (needed) shared = add_shared(joining, shot, pieces, !whole && beginning > 1);

    std::vector<std::uint32_t> mine;
    if (shared) mine.push_back(*shared);
    if (whole) return add_last(joining, shot, pieces, mine, work + (shared ? 0 : still));
    std::vector<std::uint32_t> place;  // tasks of the pieces
    std::size_t count = 0;
    for (const Piece& piece : all) {
        const bool chain = piece.stage == Stage::chain;
        if (chain) {
            if (const auto found = joining.making.find(piece.same); found != joining.making.end()) {
                place.push_back(found->second);
                mine.push_back(found->second);
                continue;
            }
        }
        FarmTask task;
        task.name = chain ? fmt::format("{}.chain-{}", pieces.shot.name, piece.nodes.front())
                          : fmt::format("{}.frames-{}", pieces.shot.name, ++count);
        task.stage = piece.stage;
        task.shot = shot;
        task.nodes = piece.nodes;
        task.frames = piece.frames;
        task.seconds = piece.seconds;
        for (const std::uint32_t p : piece.after) task.after.push_back(place[p]);
        if (task.after.empty() && shared) task.after.push_back(*shared);
        place.push_back(add_task(joining, std::move(task)));
        mine.push_back(place.back());
        if (chain) joining.making.emplace(piece.same, place.back());
    }
    add_last(joining, shot, pieces, mine, pieces.cut.last_seconds);
}

}  // namespace

const char* name_of(Stage stage)
{
    switch (stage) {
    case Stage::shared:
        return "shared";
    case Stage::chain:
        return "chain";
    case Stage::frames:
        return "frames";
    case Stage::last:
        break;
    }
    return "last";
}

Cut join(const std::vector<ShotPieces>& shots, double task_seconds)
{
    Joining joining{{}, task_seconds, {}, {}};
    for (const ShotPieces& pieces : shots) {
        for (const Still& still : pieces.cut.still) ++joining.graphs[still.key];
    }
    for (const ShotPieces& pieces : shots) add_shot(joining, pieces);
    return std::move(joining.cut);
}

std::vector<std::vector<std::uint32_t>> dependants_of(const Cut& cut)
{
    std::vector<std::vector<std::uint32_t>> out(cut.tasks.size());
    for (std::uint32_t t = 0; t < cut.tasks.size(); ++t) {
        for (const std::uint32_t before : cut.tasks[t].after) out[before].push_back(t);
    }
    return out;
}

}  // namespace runtime
