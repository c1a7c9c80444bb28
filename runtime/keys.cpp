#include "runtime/keys.hpp"

#include "graph/evaluate.hpp"

namespace runtime {

using graph::Param;
using graph::ParamKind;
using graph::ParamValue;
using graph::ParamValues;

namespace {

ParamValue& child(ParamValues& values, const std::vector<std::uint32_t>& where)
{
    ParamValue* value = &values.at(where.at(0));
    for (std::size_t i = 1; i < where.size(); ++i) {
        value = &std::get<ParamValues>(value->is).at(where[i]);
    }
    return *value;
}

// Animated numbers hold anything in the document's constants: the same anything for all.
ParamValues without_animated(const graph::Node& node)
{
    ParamValues params = node.params;
    for (const graph::Animated& a : node.animated) {
        ParamValue& value = child(params, a.where);
        if (a.component < 0) {
            value = {};
        } else {
            std::get<std::array<double, 3>>(value.is)[static_cast<std::size_t>(a.component)] = 0;
        }
    }
    return params;
}

bool has_path_in(const std::vector<Param>& params)
{
    return std::any_of(params.begin(), params.end(), [](const Param& p) {
        return p.kind == ParamKind::path_in || has_path_in(p.children);
    });
}

// A file counts by its bytes, and by its extension because that says how they are read.
void add_file(KeyBuilder& builder, const std::string& text, FileDigests& files)
{
    const std::filesystem::path path(text);
    const Key digest = text.empty() ? Key{} : files.of(path);
    builder.add(path.extension().generic_string()).add(digest);
    // What is not there may be a pattern ("mesh.####.obj"): its name has to do.
    if (!digest) builder.add(path.filename().generic_string());
}

void add_param(KeyBuilder& builder, const Param& param, const ParamValue& value, FileDigests& files)
{
    const auto* nested = std::get_if<ParamValues>(&value.is);
    if (param.kind == ParamKind::path_in && std::holds_alternative<std::string>(value.is)) {
        add_file(builder, std::get<std::string>(value.is), files);
    } else if (param.kind == ParamKind::list && nested) {
        builder.add(nested->size());
        for (const ParamValue& element : *nested) {
            const auto& members = std::get<ParamValues>(element.is);
            for (std::size_t i = 0; i < members.size(); ++i) {
                add_param(builder, param.children.at(i), members[i], files);
            }
        }
    } else if (param.kind == ParamKind::block && nested) {
        for (std::size_t i = 0; i < nested->size(); ++i) {
            add_param(builder, param.children.at(i), (*nested)[i], files);
        }
    } else {
        builder.add(value);
    }
}

// The first file that the parameters name; its folder is where side files are looked for.
const std::string* first_path(const std::vector<Param>& params, const ParamValues& values)
{
    for (std::size_t i = 0; i < params.size(); ++i) {
        if (params[i].kind == ParamKind::path_in) {
            const auto* text = std::get_if<std::string>(&values.at(i).is);
            if (text && !text->empty()) return text;
        }
        const auto* nested = std::get_if<ParamValues>(&values.at(i).is);
        if (!nested) continue;
        if (params[i].kind == ParamKind::block) {
            if (const auto* found = first_path(params[i].children, *nested)) return found;
        } else if (params[i].kind == ParamKind::list) {
            for (const ParamValue& element : *nested) {
                const auto& members = std::get<ParamValues>(element.is);
                if (const auto* found = first_path(params[i].children, members)) return found;
            }
        }
    }
    return nullptr;
}

bool declares(const graph::Node& node, graph::Variable variable)
{
    return (node.type->reads & static_cast<unsigned>(variable)) != 0;
}

bool moves(const graph::Node& node)
{
    return !node.animated.empty() || declares(node, graph::Variable::frame);
}

// The cooked frame that stands for `frame`: itself, or the nearest before it, or the first.
int nearest_cooked(const std::vector<int>& cooked, int frame)
{
    const auto after = std::upper_bound(cooked.begin(), cooked.end(), frame);
    return after == cooked.begin() ? cooked.front() : *std::prev(after);
}

constexpr std::size_t row_budget = std::size_t{16} << 20;  // bytes

}  // namespace

Keys::Keys(const graph::Graph& graph, FileDigests& files, SideFiles& side_files, KeyOptions options)
    : graph_(graph), files_(files), side_files_(side_files), options_(std::move(options))
{
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
        nodes_[n].rolls = !node.type->previous.empty();
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
    if (!same || at != end || (!node.animated.empty() && !nodes_[n].varies)) return read_links();
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
        node.varies = node.moves || node.rolls;
        for (std::uint32_t i = 0; i < node.links; ++i) {
            node.varies = node.varies || nodes_[links_[node.first_link + i].node].varies;
        }
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

void Keys::add_fixed_part(std::uint32_t n, KeyBuilder& b) const
{
    const graph::Node& node = graph_.nodes[n];
    const Node& known = nodes_[n];
    b.add(types_[known.type]);
    const auto add_params = [&](const ParamValues& params) {
        if (!known.opens) {
            for (const ParamValue& value : params) b.add(value);
            return;
        }
        for (std::size_t i = 0; i < params.size(); ++i) {
            add_param(b, node.type->params[i], params[i], files_);
        }
    };
    b.add(2 * std::uint64_t{known.links} + known.moves);
    if (known.moves) {
        b.add(node.animated.size());
        for (const graph::Animated& a : node.animated) {
            b.add(a.where.size()).add(a.component);
            for (const std::uint32_t i : a.where) b.add(i);
        }
        add_params(without_animated(node));
    } else {
        add_params(node.params);
    }
    for (std::uint32_t i = 0; i < known.links; ++i) {
        const Input& input = links_[known.first_link + i];
        b.add(std::uint64_t{input.port} << 32 | input.output);
    }
    if (!known.placed) return;
    if (declares(node, graph::Variable::fps)) b.add(graph_.range.fps);
    if (declares(node, graph::Variable::range)) {
        b.add(graph_.range.first).add(graph_.range.last);
    }
    if (node.type->sink) {
        b.add(std::filesystem::absolute(options_.output_folder).lexically_normal().native());
    }
}

// The values at a frame of what moves, files by their bytes.
void Keys::add_animated(std::uint32_t n, int frame, KeyBuilder& builder) const
{
    const graph::Node& node = graph_.nodes[n];
    ParamValues values = params(n, frame);
    for (const graph::Animated& a : node.animated) {
        const ParamValue& value = child(values, a.where);
        if (a.file) {
            add_file(builder, std::get<std::string>(value.is), files_);
        } else {
            builder.add(value);
        }
    }
}

// Zero where there are none.
Key Keys::files_of_frame(std::uint32_t n, int frame) const
{
    KeyBuilder builder;
    for (const graph::Animated& a : graph_.nodes[n].animated) {
        if (!a.file) continue;
        try {
            add_file(builder, a.file(frame).generic_string(), files_);
        } catch (const std::exception&) {
            builder.add("none");
        }
    }
    return builder.key();
}

bool Keys::files_changed(std::uint32_t n, int frame) const
{
    if (fixed_part(n) != nodes_[n].fixed) return true;
    if (!nodes_[n].sequence) return false;
    const auto before = sequences_.find({n, frame});
    return before != sequences_.end() && files_of_frame(n, frame) != before->second;
}

// What of the node itself is another at each frame.
void Keys::add_movement(std::uint32_t n, int frame)
{
    const graph::Node& source = graph_.nodes[n];
    if (nodes_[n].sequence) sequences_.try_emplace({n, frame}, files_of_frame(n, frame));
    if (!source.animated.empty()) {
        try {
            add_animated(n, frame, builder_);
        } catch (const std::exception& e) {
            // The run says what is wrong; here it only must not meet a stored result.
            builder_.add("no value").add(frame).add(std::string_view(e.what()));
        }
    }
    if (declares(source, graph::Variable::frame)) {
        builder_.add(frame).add(graph_.range.time(frame));
    }
}

Key Keys::key(std::uint32_t n, int frame, const std::vector<Key>& row, bool with_side_files)
{
    const Node& node = nodes_[n];
    builder_.clear();
    if (node.one_hash()) {
        add_fixed_part(n, builder_);
    } else {
        builder_.add(node.fixed);
    }
    if (node.moves) add_movement(n, frame);
    for (std::uint32_t i = 0; i < node.links; ++i) {
        builder_.add(input_key(links_[node.first_link + i].node, row));
    }
    // In place: the row still holds the node's key of the frame before.
    if (node.rolls) builder_.add(frame == graph_.range.first ? Key{} : row[node.slot]);
    const Key first = builder_.key();
    if (!node.opens || !with_side_files) return first;
    return side_files_.look(first, folder(n), files_).key;
}

// Inputs that gather give their key at each of the frames, all others as at the first frame.
Key Keys::gather_key(std::uint32_t n, bool with_side_files)
{
    const graph::Node& source = graph_.nodes[n];
    Gathered& gathered = gathered_[n];
    gathered = {};
    KeyBuilder b;
    b.add(nodes_[n].fixed);
    try {
        graph::FrameRange cooked = graph_.range;
        if (!frames_.empty()) cooked.first = frames_.front(), cooked.last = frames_.back();
        for (const int frame : source.type->gather_frames(params(n, graph_.range.first), cooked)) {
            gathered.frames.push_back(nearest_cooked(frames_, frame));
        }
        add_animated(n, graph_.range.first, b);
    } catch (const std::exception& e) {
        gathered.trouble = e.what();
        b.add("no value").add(std::string_view(e.what()));
    }
    if (declares(source, graph::Variable::frame)) b.add(graph_.range.first);
    b.add(gathered.frames.size());
    for (const int frame : gathered.frames) b.add(frame);

    std::vector<char> above(nodes_.size(), 0);
    above[n] = 1;
    std::vector<std::uint32_t> needed;  // varying nodes that this one depends on
    bool rolls = false;
    for (auto at = std::upper_bound(reached_.begin(), reached_.end(), n);
         at-- != reached_.begin();) {
        const Node& node = nodes_[*at];
        if (!above[*at]) continue;
        for (std::uint32_t i = 0; i < node.links; ++i) above[links_[node.first_link + i].node] = 1;
        if (node.varies) needed.push_back(*at), rolls = rolls || node.rolls;
        // A gathering node's key is made already: what stands behind it does not matter here.
    }
    std::reverse(needed.begin(), needed.end());

    std::map<int, std::vector<Key>> at_frame;  // of the gathered links, in their order
    for (const int frame : gathered.frames) at_frame[frame];
    std::vector<Key> row(varying_.size());
    const auto add_links = [&](bool gather, std::vector<Key>& keys) {
        std::size_t link = nodes_[n].first_link;
        for (std::size_t p = 0; p < source.inputs.size(); ++p) {
            for (std::size_t i = 0; i < source.inputs[p].size(); ++i, ++link) {
                if (source.type->inputs[p].gather == gather) {
                    keys.push_back(input_key(links_[link].node, row));
                }
            }
        }
    };
    fill(needed, graph_.range.first, row);
    std::vector<Key> others;
    add_links(false, others);
    for (const Key& k : others) b.add(k);
    int filled = graph_.range.first;
    for (auto& [frame, keys] : at_frame) {
        if (rolls) {
            while (filled < frame) fill(needed, ++filled, row);
        } else if (filled != frame) {
            fill(needed, filled = frame, row);
        }
        add_links(true, keys);
    }
    for (const int frame : gathered.frames) {
        for (const Key& k : at_frame[frame]) b.add(k);
    }
    const Key first = b.key();
    return nodes_[n].opens && with_side_files ? side_files_.look(first, folder(n), files_).key
                                              : first;
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

Key Keys::preparation(std::uint32_t n, std::size_t which, int frame)
{
    const graph::Node& node = graph_.nodes[n];
    const graph::Preparation& preparation = node.type->preparations[which];
    const ParamValues values = params(n, frame);
    KeyBuilder b;
    b.add(options_.salt).add("preparation").add(node.type->name).add(node.type->version);
    b.add(preparation.name);
    for (const std::size_t p : preparation.params) {
        add_param(b, node.type->params[p], values[p], files_);
    }
    for (const std::size_t p : preparation.inputs) {
        b.add(p);
        for (const graph::Link& link : node.inputs[p]) {
            for (const int f : input_frames(n, p, frame)) {
                b.add(link.output).add(at(link.node, f));
            }
        }
    }
    return b.key();
}

Key Keys::by_content(std::uint32_t n, int frame, std::span<const graph::ContentName> names) const
{
    const graph::Node& source = graph_.nodes[n];
    KeyBuilder b;
    b.add("by content");
    if (nodes_[n].one_hash()) {
        add_fixed_part(n, b);
    } else {
        b.add(nodes_[n].fixed);
    }
    if (nodes_[n].gathers) {
        frame = graph_.range.first;
        const std::vector<int>& frames = gathered_.at(n).frames;
        b.add(frames.size());
        for (const int f : frames) b.add(f);
    }
    if (!source.animated.empty()) {
        add_animated(n, frame, b);
    }
    if (declares(source, graph::Variable::frame)) b.add(frame).add(graph_.range.time(frame));
    for (const graph::ContentName& name : names) b.add(name[0]).add(name[1]);
    return b.key();
}

Key Keys::preparation_by_content(std::uint32_t n, std::size_t which, int frame,
                                 std::span<const graph::ContentName> names) const
{
    const graph::Node& node = graph_.nodes[n];
    const graph::Preparation& preparation = node.type->preparations[which];
    const ParamValues values = params(n, frame);
    KeyBuilder b;
    b.add("preparation by content").add(types_[nodes_[n].type]).add(preparation.name);
    for (const std::size_t p : preparation.params) {
        add_param(b, node.type->params[p], values[p], files_);
    }
    for (const std::size_t p : preparation.inputs) b.add(p).add(node.inputs[p].size());
    for (const graph::ContentName& name : names) b.add(name[0]).add(name[1]);
    return b.key();
}

std::span<const int> Keys::input_frames(std::uint32_t n, std::size_t port, const int& frame) const
{
    if (graph_.nodes[n].type->inputs[port].gather) return gathered_.at(n).frames;
    return {&frame, 1};
}

std::filesystem::path Keys::folder(std::uint32_t n) const
{
    const std::string* path = first_path(graph_.nodes[n].type->params, graph_.nodes[n].params);
    return path ? std::filesystem::path(*path).parent_path() : std::filesystem::path();
}

// K1 of a node that may open side files.
Key Keys::first_key(std::uint32_t n, int frame)
{
    if (nodes_[n].gathers) return gather_key(n, false);
    if (!nodes_[n].varies) return key(n, frame, {}, false);
    std::vector<Key> keys = row(frame);
    if (nodes_[n].rolls && frame > graph_.range.first) keys[nodes_[n].slot] = at(n, frame - 1);
    return key(n, frame, keys, false);
}

bool Keys::known(std::uint32_t n, int frame)
{
    return side_files_.look(first_key(n, frame), folder(n), files_).confirmed;
}

std::vector<std::filesystem::path> Keys::side_files(std::uint32_t n, int frame)
{
    if (!nodes_[n].opens) return {};
    return side_files_.names(first_key(n, frame), folder(n));
}

Key Keys::opened(std::uint32_t n, int frame, const std::set<std::filesystem::path>& paths)
{
    return side_files_.confirm(first_key(n, frame), folder(n), paths, files_);
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
