// Parts: which simulations hang together, what is left of one frame, what gathering nodes need, the
// pieces themselves.

#include "runtime/farm/graph_pieces.hpp"

#include "runtime/cook/storing.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>
#include <set>

namespace runtime {

namespace {

using Nodes = std::vector<std::uint32_t>;

// Results quicker than this are not looked for in the cache one by one.
constexpr double worth_a_look = 0.05;  // s

struct Work : Asked {
    explicit Work(const Asked& asked)
        : Asked(asked), late(graph.nodes.size(), 0), chain(graph.nodes.size()),
          wanted(graph.nodes.size(), 0), is_target(graph.nodes.size(), 0)
    {}

    std::vector<char> late;            // it depends on a node that gathers frames, or is one
    std::vector<std::uint32_t> chain;  // simulations of one chain name the same node
    std::vector<Nodes> above;          // by node: chains that it depends on, itself included
    std::vector<char> wanted;          // scratch of left_at()
    std::vector<char> is_target;       // of any piece
    std::set<std::pair<std::uint32_t, int>> made;  // targets that a piece makes on its way
};

template <class See> void each_input(const graph::Node& node, const See& see)
{
    for (std::size_t port = 0; port < node.inputs.size(); ++port) {
        for (const graph::Link& link : node.inputs[port]) see(link.node, port);
    }
}

bool rolls(const Work& work, std::uint32_t n)
{
    return work.keys.rolls(n);
}

std::uint32_t first_of(const Work& work, std::uint32_t n)
{
    while (work.chain[n] != n) n = work.chain[n];
    return n;
}

void add_once(Nodes& nodes, std::uint32_t n)
{
    if (std::find(nodes.begin(), nodes.end(), n) == nodes.end()) nodes.push_back(n);
}

// The chains that the node's inputs depend on.
Nodes chains_above(const Work& work, std::uint32_t n)
{
    Nodes chains;
    each_input(work.graph.nodes[n], [&](std::uint32_t from, std::size_t) {
        for (const std::uint32_t c : work.above[from]) add_once(chains, first_of(work, c));
    });
    return chains;
}

std::vector<std::string> names_of(const Work& work, const Nodes& nodes)
{
    std::vector<std::string> names;
    for (const std::uint32_t n : nodes) names.push_back(work.graph.nodes[n].name);
    return names;
}

void find_chains(Work& work)
{
    std::iota(work.chain.begin(), work.chain.end(), 0u);
    work.above.resize(work.graph.nodes.size());
    for (const std::uint32_t n : work.keys.reached()) {
        const graph::Node& node = work.graph.nodes[n];
        work.late[n] = static_cast<bool>(node.type->gather_frames);
        each_input(node, [&](std::uint32_t from, std::size_t) {
            if (work.late[from]) work.late[n] = 1;
        });
        work.above[n] = chains_above(work, n);
        if (!rolls(work, n)) continue;
        for (const std::uint32_t c : work.above[n]) work.chain[c] = n;
        work.above[n] = {n};
    }
}

// Whether the node's result is stored, and for one that writes files, whether they are there.
bool held(const Work& work, std::uint32_t n, int frame)
{
    const graph::NodeType& type = *work.graph.nodes[n].type;
    if (work.stored.keys.empty() || !storable(type)) return false;
    const Key& key = work.keys.at(n, frame);
    if (!work.stored.holds(key)) return false;
    if (!type.sink) return true;
    const auto record = work.stored.disk->record(key);
    return record && std::all_of(record->files.begin(), record->files.end(), [](const auto& file) {
               std::error_code ignored;
               return std::filesystem::exists(file.path, ignored);
           });
}

struct Left {
    bool missing = false;  // something of what is asked for
    double seconds = 0;
};

// What it takes to have `nodes` at a frame, when all simulations but those of `chain` are there.
Left left_at(Work& work, const Nodes& nodes, int frame, bool in_chain)
{
    Left left;
    std::uint32_t top = 0;
    for (const std::uint32_t n : nodes) work.wanted[n] = 1, top = std::max(top, n);
    const Nodes& reached = work.keys.reached();
    for (auto at = std::upper_bound(reached.begin(), reached.end(), top);
         at-- != reached.begin();) {
        const std::uint32_t n = *at;
        if (!std::exchange(work.wanted[n], 0)) continue;
        const bool asked = std::find(nodes.begin(), nodes.end(), n) != nodes.end();
        const bool rolling = rolls(work, n);
        if (!work.keys.varies(n) || (rolling && !in_chain)) continue;
        const bool look = asked || work.costs.seconds[n] > worth_a_look;
        if (look && held(work, n, frame)) continue;
        left.missing = left.missing || asked;
        left.seconds += work.costs.seconds[n];
        if (work.is_target[n]) work.made.insert({n, frame});
        each_input(work.graph.nodes[n],
                   [&](std::uint32_t from, std::size_t) { work.wanted[from] = 1; });
    }
    return left;
}

// How many tasks of about equal worth: `tasks` would be worth what was asked for. They are an even
// number, which two machines share evenly: of thirteen tasks, they would make seven rounds, 1.86
// times as fast as one machine.
std::size_t count_of_pieces(double tasks, std::size_t most)
{
    auto count = static_cast<std::size_t>(std::max(tasks, 1.0));
    if (tasks >= 1) count += count % 2;
    return std::min(count, most);
}

// Cuts the frames that are missing into tasks of about equal worth.
void add_frame_pieces(Work& work, const Nodes& nodes, const std::vector<int>& frames,
                      const Nodes& after, GraphPieces& out)
{
    std::vector<int> missing;
    std::vector<double> until;  // s, up to and with that frame
    double sum = 0;
    for (const int frame : frames) {
        const Left left = left_at(work, nodes, frame, false);
        if (!left.missing) continue;
        missing.push_back(frame);
        until.push_back(sum += work.costs.measured ? left.seconds : 1);
    }
    if (missing.empty()) return;
    if (sum <= 0) {  // nothing is known of what comes after the simulations: 1 s a frame
        for (double& u : until) u = sum += 1;
    }
    const double tasks = sum / work.task_seconds;
    const std::size_t count =
        work.costs.measured
            ? count_of_pieces(tasks, missing.size())
            : std::min(static_cast<std::size_t>(std::max(tasks, 1.0)), missing.size());
    std::size_t begin = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const double edge = sum * static_cast<double>(i + 1) / static_cast<double>(count);
        std::size_t end = begin;
        while (end < missing.size() && (i + 1 == count || until[end] <= edge * (1 + 1e-9))) ++end;
        if (end == begin) continue;
        Piece piece;
        piece.nodes = names_of(work, nodes);
        piece.frames.assign(missing.begin() + static_cast<std::ptrdiff_t>(begin),
                            missing.begin() + static_cast<std::ptrdiff_t>(end));
        piece.after = after;
        piece.seconds = until[end - 1] - (begin > 0 ? until[begin - 1] : 0);
        out.pieces.push_back(std::move(piece));
        begin = end;
    }
}

// The piece of a chain, if it is worth one. Its inputs that differ from frame to frame and do not
// depend on it are cut off where they are dear.
std::optional<std::uint32_t> add_chain(Work& work, const Nodes& members, const Nodes& before,
                                       GraphPieces& out)
{
    Piece piece;
    piece.stage = Stage::chain;
    piece.nodes = names_of(work, members);
    piece.frames = work.frames;
    piece.after = before;
    ChainStep step;
    bool missing = false;
    int f = work.graph.range.first;
    for (const int asked : work.frames) {
        KeyBuilder made;
        made.add(step.made).add(asked);
        for (const std::uint32_t n : members) made.add(work.keys.at(n, asked));
        step = {made.key(), 0, false};
        for (; f <= asked; ++f) {
            const Left left = left_at(work, members, f, true);
            step.missing = step.missing || left.missing;
            step.seconds += work.costs.measured ? left.seconds : left.missing ? 1 : 0;
        }
        missing = missing || step.missing;
        piece.seconds += step.seconds;
        piece.steps.push_back(step);
    }
    // Quicker than a task is sent: each of those who need it makes it for itself.
    if (!missing || (work.costs.measured && piece.seconds < work.task_seconds / 30)) return {};
    out.pieces.push_back(std::move(piece));
    return static_cast<std::uint32_t>(out.pieces.size() - 1);
}

// The nodes beside the chain that feed it, cut into pieces where that pays. Returns the pieces.
Nodes add_feeders(Work& work, const Nodes& members, GraphPieces& out)
{
    Nodes feeders;
    for (const std::uint32_t n : members) {
        each_input(work.graph.nodes[n], [&](std::uint32_t from, std::size_t) {
            const bool free =
                work.keys.varies(from) && !work.late[from] && work.above[from].empty();
            if (free) add_once(feeders, from);
        });
    }
    double sum = 0;
    std::vector<int> frames;
    for (int f = work.graph.range.first; f <= work.frames.back(); ++f) {
        sum += left_at(work, feeders, f, false).seconds;
        frames.push_back(f);
    }
    if (!work.costs.measured || sum < 2 * work.task_seconds) return {};
    const auto first = static_cast<std::uint32_t>(out.pieces.size());
    add_frame_pieces(work, feeders, frames, {}, out);
    for (std::size_t p = first; p < out.pieces.size(); ++p) {
        KeyBuilder same;
        for (const int f : out.pieces[p].frames) {
            for (const std::uint32_t n : feeders) same.add(work.keys.at(n, f));
        }
        out.pieces[p].same = same.key();
    }
    Nodes pieces(out.pieces.size() - first);
    std::iota(pieces.begin(), pieces.end(), first);
    return pieces;
}

// Nodes at frames: what is asked for frame by frame, and what nodes that gather frames need.
std::map<std::vector<int>, Nodes> frame_targets(Work& work)
{
    std::map<std::vector<int>, Nodes> by_frames;
    const auto add = [&](std::uint32_t n, const std::vector<int>& frames) {
        if (frames.empty() || work.late[n] || !work.keys.varies(n) || rolls(work, n)) return;
        add_once(by_frames[frames], n);
        work.is_target[n] = 1;
    };
    for (const std::uint32_t n : work.targets) add(n, work.frames);
    for (const std::uint32_t n : work.keys.reached()) {
        const graph::Node& node = work.graph.nodes[n];
        if (!node.type->gather_frames || !work.keys.trouble(n).empty()) continue;
        each_input(node, [&](std::uint32_t from, std::size_t port) {
            const auto at = work.keys.input_frames(n, port, work.graph.range.first);
            if (!node.type->inputs[port].gather) return;
            std::vector<int> frames(at.begin(), at.end());
            std::sort(frames.begin(), frames.end());
            frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
            add(from, frames);
        });
    }
    return by_frames;
}

void add_chains(Work& work, std::map<std::uint32_t, std::uint32_t>& piece_of, GraphPieces& out)
{
    std::map<std::uint32_t, Nodes> chains;
    for (const std::uint32_t n : work.keys.reached()) {
        if (rolls(work, n) && !work.late[n]) chains[first_of(work, n)].push_back(n);
    }
    for (const auto& [first, members] : chains) {
        const Nodes feeders = add_feeders(work, members, out);
        if (const auto piece = add_chain(work, members, feeders, out)) piece_of[first] = *piece;
    }
}

// Later nodes first: what they need on their way is not made a second time.
void add_frames(Work& work, const std::map<std::uint32_t, std::uint32_t>& piece_of,
                GraphPieces& out)
{
    const auto by_frames = frame_targets(work);
    std::vector<const std::pair<const std::vector<int>, Nodes>*> order;
    for (const auto& group : by_frames) order.push_back(&group);
    std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) {
        return *std::max_element(a->second.begin(), a->second.end()) >
               *std::max_element(b->second.begin(), b->second.end());
    });
    for (const auto* group : order) {
        Nodes after;
        for (const std::uint32_t n : group->second) {
            for (const std::uint32_t c : work.above[n]) {
                const auto found = piece_of.find(first_of(work, c));
                if (found != piece_of.end()) add_once(after, found->second);
            }
        }
        std::sort(after.begin(), after.end());
        std::vector<int> frames;
        for (const int f : group->first) {
            const bool all =
                std::all_of(group->second.begin(), group->second.end(), [&](std::uint32_t n) {
                    return work.made.contains({n, f});
                });
            if (!all) frames.push_back(f);
        }
        add_frame_pieces(work, group->second, frames, after, out);
    }
}

void list_still(const Work& work, GraphPieces& out)
{
    std::vector<std::uint32_t> place(work.graph.nodes.size(), 0);
    for (const std::uint32_t n : work.keys.reached()) {
        const graph::Node& node = work.graph.nodes[n];
        if (work.keys.varies(n)) {
            each_input(node, [&](std::uint32_t from, std::size_t) {
                if (!work.keys.varies(from) && !work.late[from]) out.still[place[from]].used = true;
            });
        }
        if (work.keys.varies(n) || work.late[n]) continue;
        Still still{node.name,
                    work.keys.at(n, work.frames.front()),
                    work.costs.seconds[n],
                    held(work, n, work.frames.front()),
                    false,
                    {}};
        each_input(node,
                   [&](std::uint32_t from, std::size_t) { still.inputs.push_back(place[from]); });
        place[n] = static_cast<std::uint32_t>(out.still.size());
        out.still.push_back(std::move(still));
    }
}

// What is asked for, how much of it is there, and what is left to the whole cook.
void count_results(const Work& work, GraphPieces& out)
{
    for (const std::uint32_t n : work.targets) {
        const std::size_t count = work.keys.varies(n) ? work.frames.size() : 1;
        for (std::size_t i = 0; i < count; ++i) {
            const bool there = held(work, n, work.frames[i]);
            ++out.results, out.held += there;
            if (!there && (work.late[n] || count == 1)) out.last_seconds += work.costs.seconds[n];
        }
    }
}

}  // namespace

GraphPieces cut_graph(const Asked& asked)
{
    Work work(asked);
    GraphPieces out;
    if (work.frames.empty() || work.targets.empty()) return out;
    find_chains(work);
    std::map<std::uint32_t, std::uint32_t> piece_of;  // of a chain
    add_chains(work, piece_of, out);
    add_frames(work, piece_of, out);
    list_still(work, out);
    count_results(work, out);
    return out;
}

}  // namespace runtime
