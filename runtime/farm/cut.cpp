#include "runtime/farm/cut.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <unordered_map>
#include <utility>

namespace runtime {

namespace {

struct Joining {
    Cut cut;
    double task_seconds;
    std::unordered_map<Key, int, KeyHash> graphs;            // that have a still node, by its key
    std::unordered_map<Key, int, KeyHash> chains;            // that have a step, by what it made
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

// Of a chain that is shared: what is worth a task of its own.
double worth_a_span(const Joining& joining)
{
    return joining.task_seconds / 3;
}

// The tasks that a piece is made by, and the last frame that each of them makes.
using Spans = std::vector<std::pair<int, std::uint32_t>>;

// Where the chain's task that begins at a step ends: where another chain ends or goes its own way,
// if both sides are worth a task.
std::size_t end_of_span(const Joining& joining, const Piece& piece, std::size_t begin)
{
    const auto& steps = piece.steps;
    double left = 0, sum = 0;
    for (std::size_t i = begin; i < steps.size(); ++i) left += steps[i].seconds;
    for (std::size_t i = begin; i + 1 < steps.size(); ++i) {
        sum += steps[i].seconds;
        const bool parts = joining.chains.at(steps[i].made) > joining.chains.at(steps[i + 1].made);
        const double worth = worth_a_span(joining);
        if (parts && sum >= worth && left - sum >= worth) return i + 1;
    }
    return steps.size();
}

// As far as the tasks of other shots make this chain, or it is in the cache: how many steps. A task
// that goes on for long after them is not worth waiting for what is made quickly.
std::size_t made_by_others(const Joining& joining, const Piece& piece, Spans& spans)
{
    std::size_t at = 0, before = 0;  // `before`: where the last span began
    double shared = 0;               // s, of the last span
    for (; at < piece.steps.size(); ++at) {
        const auto found = joining.making.find(piece.steps[at].made);
        if (found == joining.making.end()) {
            if (piece.steps[at].missing) break;
            continue;
        }
        if (spans.empty() || spans.back().second != found->second) {
            spans.push_back({0, found->second});
            before = at, shared = 0;
        }
        spans.back().first = piece.frames[at];
        shared += piece.steps[at].seconds;
    }
    if (spans.empty()) return at;
    const bool ends_there =
        joining.cut.tasks[spans.back().second].frames.back() == spans.back().first;
    if (ends_there || shared >= worth_a_span(joining)) return at;
    spans.pop_back();
    return before;
}

// The tasks of a chain. `after`: what its first one waits for.
Spans add_chain_tasks(Joining& joining, std::uint32_t shot, const Piece& piece,
                      const std::vector<std::uint32_t>& after)
{
    Spans spans;
    std::size_t begin = made_by_others(joining, piece, spans);
    bool first = true;
    while (begin < piece.steps.size()) {
        const std::size_t end = end_of_span(joining, piece, begin);
        const auto at = [&](std::size_t i) {
            return piece.frames.begin() + static_cast<std::ptrdiff_t>(i);
        };
        FarmTask task;
        // The last one is what the others feed: a simulation, and not its colliders.
        task.name = fmt::format("{}.chain-{}", joining.cut.shots[shot].name, piece.nodes.back());
        if (!spans.empty()) task.name += fmt::format("-from-{}", piece.frames[begin]);
        task.stage = Stage::chain;
        task.shot = shot;
        task.nodes = piece.nodes;
        task.frames.assign(at(begin), at(end));
        for (std::size_t i = begin; i < end; ++i) task.seconds += piece.steps[i].seconds;
        if (!spans.empty()) task.after.push_back(spans.back().second);
        if (std::exchange(first, false)) {
            task.after.insert(task.after.end(), after.begin(), after.end());
        }
        std::sort(task.after.begin(), task.after.end());
        const int last = task.frames.back();
        spans.push_back({last, add_task(joining, std::move(task))});
        for (; begin < end; ++begin) {
            joining.making.emplace(piece.steps[begin].made, spans.back().second);
        }
    }
    return spans;
}

bool worth_sharing(const Joining& joining, const Piece& piece)
{
    double shared = 0;
    for (const ChainStep& step : piece.steps) {
        if (joining.chains.at(step.made) > 1) shared += step.seconds;
    }
    return shared > 0 && shared >= worth_a_span(joining);
}

// The one of the tasks that makes the frame; the last one, if none does.
std::uint32_t making(const Spans& spans, int frame)
{
    for (const auto& [last, task] : spans) {
        if (frame <= last) return task;
    }
    return spans.back().second;
}

// A task of the stage `frames`, or the one of another shot that makes the same.
std::uint32_t add_frames_task(Joining& joining, FarmTask task, const Key& same)
{
    if (!same) return add_task(joining, std::move(task));
    const auto [found, is_new] = joining.making.try_emplace(same, 0);
    if (is_new) found->second = add_task(joining, std::move(task));
    return found->second;
}

// A task for each piece, or several. Returns them all.
std::vector<std::uint32_t> add_pieces(Joining& joining, std::uint32_t shot,
                                      const std::vector<Piece>& all,
                                      const std::optional<std::uint32_t>& shared)
{
    std::vector<std::uint32_t> mine;
    std::vector<Spans> made_by;  // each piece
    std::size_t count = 0;
    for (const Piece& piece : all) {
        std::vector<std::uint32_t> after;
        for (const std::uint32_t p : piece.after) {
            after.push_back(making(made_by[p], piece.frames.back()));
        }
        if (after.empty() && shared) after.push_back(*shared);
        if (piece.stage == Stage::chain) {
            made_by.push_back(add_chain_tasks(joining, shot, piece, after));
        } else {
            FarmTask task;
            // Names of one shot have no gaps, as those of an array count up from its first.
            task.name = fmt::format("{}.frames-{}", joining.cut.shots[shot].name, count + 1);
            task.stage = piece.stage;
            task.shot = shot;
            task.nodes = piece.nodes;
            task.frames = piece.frames;
            task.after = std::move(after);
            task.seconds = piece.seconds;
            const std::size_t before = joining.cut.tasks.size();
            made_by.push_back(
                {{piece.frames.back(), add_frames_task(joining, std::move(task), piece.same)}});
            count += joining.cut.tasks.size() - before;
        }
        for (const auto& span : made_by.back()) mine.push_back(span.second);
    }
    return mine;
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

    // Those that are tasks: a shot of little work cooks the others in its last one.
    std::vector<Piece> own;
    std::vector<std::optional<std::uint32_t>> place(all.size());  // in `own`
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (whole && !worth_sharing(joining, all[i])) continue;
        place[i] = static_cast<std::uint32_t>(own.size());
        own.push_back(all[i]);
        own.back().after.clear();
        for (const std::uint32_t before : all[i].after) {
            if (place[before]) own.back().after.push_back(*place[before]);
        }
    }
    double last_seconds = whole ? work + (shared ? 0 : still) : pieces.cut.last_seconds;
    if (whole) {
        for (const Piece& piece : own) last_seconds -= piece.seconds;
    }
    std::vector<std::uint32_t> mine = add_pieces(joining, shot, own, shared);
    if (shared) mine.push_back(*shared);
    add_last(joining, shot, pieces, mine, last_seconds);
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
    case Stage::sweep:
        return "sweep";
    case Stage::last:
        break;
    }
    return "last";
}

Cut join(const std::vector<ShotPieces>& shots, double task_seconds)
{
    Joining joining{{}, task_seconds, {}, {}, {}};
    for (const ShotPieces& pieces : shots) {
        for (const Still& still : pieces.cut.still) ++joining.graphs[still.key];
        for (const Piece& piece : pieces.cut.pieces) {
            for (const ChainStep& step : piece.steps) ++joining.chains[step.made];
        }
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
