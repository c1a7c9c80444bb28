// Which nodes have keys of their own a frame, and the rows of them. What goes into a single key
// stands in make_keys.cpp.

#include "runtime/cook/keys.hpp"

#include "graph/document/evaluate.hpp"
#include "runtime/cook/below_folder.hpp"
#include "runtime/cook/key_parts.hpp"

#include <algorithm>

namespace runtime {

using graph::ParamValues;

namespace {

bool moves(const graph::Node& node)
{
    return !node.animated.empty() || declares(node, graph::Variable::frame);
}

constexpr std::size_t row_budget = std::size_t{16} << 20;  // bytes

}  // namespace

Keys::Keys(const graph::Graph& graph, FileDigests& files, SideFiles& side_files, KeyOptions options)
    : graph_(graph), files_(files), side_files_(side_files), options_(std::move(options))
{
    options_.output_folder = resolved(options_.output_folder);
    read_links();
}

// Calls see(Input) for each link of the node, by port.
template <class See> void Keys::each_link(const graph::Node& node, const See& see)
{
    for (std::uint32_t port = 0; port < node.inputs.size(); ++port) {
        for (const graph::Link& link : node.inputs[port]) see({link.node, port, link.output});
    }
}

void Keys::read_links()
{
    nodes_.assign(graph_.nodes.size(), {});
    links_.clear();
    links_.reserve(2 * nodes_.size());
    types_.clear();
    struct Type {
        std::uint32_t index;
        bool opens;
    };
    std::unordered_map<const graph::NodeType*, Type> known;
    const graph::NodeType* last = nullptr;
    Type type{};
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
        const graph::Node& node = graph_.nodes[n];
        if (std::exchange(last, node.type) != node.type) {
            const auto next = static_cast<std::uint32_t>(types_.size());
            const auto [found, is_new] =
                known.try_emplace(node.type, Type{next, has_path_in(node.type->params)});
            if (is_new) {
                builder_.clear();
                builder_.add(options_.salt).add(node.type->name).add(node.type->version);
                types_.push_back(builder_.add(node.type->reads).key());
            }
            type = found->second;
        }
        nodes_[n].type = type.index;
        nodes_[n].opens = type.opens;
        nodes_[n].first_link = static_cast<std::uint32_t>(links_.size());
        each_link(node, [&](const Input& input) { links_.push_back(input); });
        nodes_[n].links = static_cast<std::uint32_t>(links_.size()) - nodes_[n].first_link;
        nodes_[n].moves = moves(node);
        nodes_[n].sequence =
            std::any_of(node.animated.begin(), node.animated.end(),
                        [](const graph::Animated& a) { return static_cast<bool>(a.file); });
        nodes_[n].placed = node.type->sink || declares(node, graph::Variable::fps) ||
                           declares(node, graph::Variable::range);
        nodes_[n].gathers = static_cast<bool>(node.type->gather_frames);
    }
    targets_.clear();
    frames_.clear();
}

void Keys::edited(std::uint32_t n)
{
    const graph::Node& node = graph_.nodes[n];
    std::size_t at = nodes_[n].first_link;
    const std::size_t end = at + nodes_[n].links;
    bool same = true;
    each_link(node, [&](const Input& input) { same = same && at < end && links_[at++] == input; });
    const bool stops = nodes_[n].rolls && nodes_[n].moves && !moves(node);
    const bool starts = !nodes_[n].varies && !node.animated.empty();
    if (!same || at != end || starts || stops) return read_links();
    nodes_[n].moves = moves(node);
    nodes_[n].stale = true;
    first_stale_ = std::min(first_stale_, n);
}

void Keys::reach(const std::vector<std::uint32_t>& targets)
{
    std::vector<char> wanted(nodes_.size(), 0);
    for (const std::uint32_t t : targets) wanted[t] = 1;
    reached_.clear(), openers_.clear(), file_nodes_.clear();
    reached_.reserve(nodes_.size());
    for (std::size_t n = nodes_.size(); n-- > 0;) {
        if (!wanted[n]) continue;
        reached_.push_back(static_cast<std::uint32_t>(n));
        for (std::uint32_t i = 0; i < nodes_[n].links; ++i) {
            wanted[links_[nodes_[n].first_link + i].node] = 1;
        }
    }
    std::reverse(reached_.begin(), reached_.end());

    varying_.clear(), rolling_.clear(), under_rolling_.clear();
    for (const std::uint32_t n : reached_) {
        Node& node = nodes_[n];
        node.stale = true;
        const graph::NodeType& type = *graph_.nodes[n].type;
        const bool remembers = !type.previous.empty();
        node.varies = node.moves || (remembers && type.memory == graph::Memory::of_all_frames);
        for (std::uint32_t i = 0; i < node.links; ++i) {
            node.varies = node.varies || nodes_[links_[node.first_link + i].node].varies;
        }
        node.rolls = remembers && node.varies;
        if (node.gathers) node.varies = false;  // it runs once a cook
        if (node.opens) openers_.push_back(n), file_nodes_.push_back(n);
        if (!node.varies) continue;
        node.slot = static_cast<std::uint32_t>(varying_.size());
        varying_.push_back(n);
        if (node.rolls) rolling_.push_back(n);
    }

    targets_ = targets;
    first_stale_ = 0;
    if (rolling_.empty()) return;
    std::vector<char> under(nodes_.size(), 0);
    for (const std::uint32_t n : rolling_) under[n] = 1;
    for (std::size_t i = varying_.size(); i-- > 0;) {
        const Node& node = nodes_[varying_[i]];
        if (!under[varying_[i]]) continue;
        for (std::uint32_t k = 0; k < node.links; ++k) under[links_[node.first_link + k].node] = 1;
    }
    for (const std::uint32_t n : varying_) {
        if (under[n]) under_rolling_.push_back(n);
    }
}

void Keys::aim(const std::vector<std::uint32_t>& targets, const std::vector<int>& frames)
{
    if (targets != targets_) reach(targets);
    if (frames != frames_) {
        frames_ = frames;
        for (const std::uint32_t n : reached_) {
            if (nodes_[n].gathers) edited(n);
        }
    }
    for (const std::uint32_t n : file_nodes_) {
        if (!nodes_[n].stale && fixed_part(n) != nodes_[n].fixed) edited(n);
    }
    for (auto at = sequences_.begin(); at != sequences_.end();) {
        const auto [n, frame] = at->first;
        if (files_of_frame(n, frame) == at->second) {
            ++at;
        } else {
            edited(n);
            at = sequences_.erase(at);
        }
    }
    const auto from = std::lower_bound(reached_.begin(), reached_.end(), first_stale_);
    if (from == reached_.end()) return;

    bool any = false;
    const std::vector<Key> no_row;
    for (auto at = from; at != reached_.end(); ++at) {
        Node& node = nodes_[*at];
        bool touched = node.stale;
        for (std::uint32_t i = 0; i < node.links && !touched; ++i) {
            touched = nodes_[links_[node.first_link + i].node].changed;
        }
        if (!touched) continue;
        const Key before = node.varies ? node.fixed : node.key;
        if (node.stale && !node.one_hash()) node.fixed = fixed_part(*at);
        if (!node.varies) {
            node.key =
                node.gathers ? gather_key(*at, true) : key(*at, graph_.range.first, no_row, true);
        }
        node.changed = node.varies || node.key != before;
        node.stale = false;
        any = any || node.changed;
    }
    for (auto at = from; at != reached_.end(); ++at) nodes_[*at].changed = false;
    first_stale_ = static_cast<std::uint32_t>(nodes_.size());
    if (any) forget_rows();
}

void Keys::forget_rows()
{
    rows_.clear();
    history_.assign(rolling_.size(), {});
    rolled_ = 0;
}

void Keys::fill(const std::vector<std::uint32_t>& nodes, int frame, std::vector<Key>& row)
{
    for (const std::uint32_t n : nodes) row[nodes_[n].slot] = key(n, frame, row, true);
}

// Brings the history of simulations up to `frame`.
void Keys::roll(int frame)
{
    const int wanted = frame - graph_.range.first + 1;
    if (rolled_ == 0) rolling_row_.assign(varying_.size(), {});
    for (; rolled_ < wanted; ++rolled_) {
        fill(under_rolling_, graph_.range.first + rolled_, rolling_row_);
        for (std::size_t i = 0; i < rolling_.size(); ++i) {
            history_[i].push_back(rolling_row_[nodes_[rolling_[i]].slot]);
        }
    }
}

const std::vector<Key>& Keys::row(int frame)
{
    const auto found =
        std::find_if(rows_.begin(), rows_.end(), [&](const Row& r) { return r.frame == frame; });
    if (found != rows_.end()) {
        if (found != rows_.begin()) rows_.splice(rows_.begin(), rows_, found);
        return rows_.front().keys;
    }
    const std::size_t fits = row_budget / (sizeof(Key) * std::max<std::size_t>(varying_.size(), 1));
    if (rows_.size() >= std::clamp<std::size_t>(fits, 4, 64)) {
        rows_.splice(rows_.begin(), rows_, std::prev(rows_.end()));
    } else {
        rows_.emplace_front();
    }
    Row& row = rows_.front();
    row.frame = frame;
    row.keys.resize(varying_.size());
    const int before = frame - graph_.range.first;  // frames of history that this one needs
    if (!rolling_.empty() && before > 0) {
        roll(frame - 1);
        for (std::size_t i = 0; i < rolling_.size(); ++i) {
            row.keys[nodes_[rolling_[i]].slot] = history_[i][static_cast<std::size_t>(before - 1)];
        }
    }
    fill(varying_, frame, row.keys);
    return row.keys;
}

const Key& Keys::at(std::uint32_t n, int frame)
{
    const Node& node = nodes_[n];
    if (!node.varies) return node.key;
    if (node.rolls) {  // without the rest of the row: descending a simulation needs no more
        roll(frame);
        const auto which = std::lower_bound(rolling_.begin(), rolling_.end(), n);
        return history_[static_cast<std::size_t>(which - rolling_.begin())]
                       [static_cast<std::size_t>(frame - graph_.range.first)];
    }
    return row(frame)[node.slot];
}

std::span<const int> Keys::input_frames(std::uint32_t n, std::size_t port, const int& frame) const
{
    if (graph_.nodes[n].type->inputs[port].gather) return gathered_.at(n).frames;
    return {&frame, 1};
}

SideFiles::Place Keys::place(std::uint32_t n, int frame) const
{
    const graph::Node& node = graph_.nodes[n];
    std::filesystem::path path;
    const auto read = [&](const ParamValues& values) {
        if (const std::string* const first = first_path(node.type->params, values)) path = *first;
    };
    read(node.params);
    if (nodes_[n].sequence) {
        try {
            read(params(n, frame));
        } catch (const std::exception&) {
            // There is no file at that frame: the run says so.
        }
    }
    return {path.parent_path(), path.filename(), graph_.root};
}

bool Keys::known(std::uint32_t n, int frame)
{
    return side_files_.look(first_key(n, frame), place(n, frame), files_).confirmed;
}

std::vector<std::filesystem::path> Keys::side_files(std::uint32_t n, int frame)
{
    if (!nodes_[n].opens) return {};
    return side_files_.names(first_key(n, frame), place(n, frame));
}

Key Keys::opened(std::uint32_t n, int frame, const std::set<std::filesystem::path>& paths)
{
    return side_files_.confirm(first_key(n, frame), place(n, frame), paths, files_);
}

const std::string& Keys::trouble(std::uint32_t n) const
{
    return gathered_.at(n).trouble;
}

ParamValues Keys::params(std::uint32_t n, int frame) const
{
    return evaluate(graph_.nodes[n], frame, graph_.range.time(frame));
}

}  // namespace runtime
