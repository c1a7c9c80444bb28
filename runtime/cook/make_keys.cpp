// Keys of single results: what goes into them, in which order. A change of anything here gives all
// results other keys, so that what older programs stored is not found any more.

#include "graph/document/evaluate.hpp"
#include "graph/document/scene_pace.hpp"
#include "runtime/cook/key_parts.hpp"
#include "runtime/cook/keys.hpp"

#include <algorithm>

namespace runtime {

using graph::ParamValue;
using graph::ParamValues;

namespace {

// The cooked frame that stands for `frame`: itself, or the nearest before it, or the first.
int nearest_cooked(const std::vector<int>& cooked, int frame)
{
    const auto after = std::upper_bound(cooked.begin(), cooked.end(), frame);
    return after == cooked.begin() ? cooked.front() : *std::prev(after);
}

}  // namespace

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
    const bool range = declares(node, graph::Variable::range);
    // The range that a node sees has the frame rate in it, and turns frames into seconds.
    if (range || declares(node, graph::Variable::fps)) b.add(graph_.range.fps);
    if (range) {
        b.add(graph_.range.first).add(graph_.range.last);
    }
    if (node.type->sink) b.add(options_.output_folder.native());
}

// The values at a frame of what moves, files by their bytes.
void Keys::add_animated(std::uint32_t n, int frame, KeyBuilder& builder) const
{
    const graph::Node& node = graph_.nodes[n];
    ParamValues values = params(n, frame);
    for (const graph::Animated& a : node.animated) {
        const ParamValue& value = animated_value(values, a.where);
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

void Keys::add_pace(std::uint32_t n, KeyBuilder& b) const
{
    if (declares(graph_.nodes[n], graph::Variable::pace)) b.add(graph::scene_pace(graph_, n));
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
    add_pace(n, builder_);
    for (std::uint32_t i = 0; i < node.links; ++i) {
        builder_.add(input_key(links_[node.first_link + i].node, row));
    }
    // In place: the row still holds the node's key of the frame before.
    if (node.rolls) builder_.add(frame == graph_.range.first ? Key{} : row[node.slot]);
    const Key first = builder_.key();
    if (!node.opens || !with_side_files) return first;
    return side_files_.look(first, place(n, frame), files_).key;
}

// Which frames the node asks for, and what of its parameters moves; into its key, too.
const Keys::Gathered& Keys::gather_frames(std::uint32_t n, KeyBuilder& b)
{
    const graph::Node& source = graph_.nodes[n];
    Gathered& gathered = gathered_[n];
    gathered = {};
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
    return gathered;
}

// The varying nodes that the node depends on, inputs first.
std::vector<std::uint32_t> Keys::varying_above(std::uint32_t n) const
{
    std::vector<char> above(nodes_.size(), 0);
    above[n] = 1;
    std::vector<std::uint32_t> needed;
    for (auto at = std::upper_bound(reached_.begin(), reached_.end(), n);
         at-- != reached_.begin();) {
        const Node& node = nodes_[*at];
        if (!above[*at]) continue;
        for (std::uint32_t i = 0; i < node.links; ++i) above[links_[node.first_link + i].node] = 1;
        if (node.varies) needed.push_back(*at);
        // A gathering node's key is made already: what stands behind it does not matter here.
    }
    std::reverse(needed.begin(), needed.end());
    return needed;
}

// Inputs that gather give their key at each of the frames, all others as at the first frame.
Key Keys::gather_key(std::uint32_t n, bool with_side_files)
{
    const graph::Node& source = graph_.nodes[n];
    KeyBuilder b;
    b.add(nodes_[n].fixed);
    const Gathered& gathered = gather_frames(n, b);
    if (declares(source, graph::Variable::frame)) b.add(graph_.range.first);
    add_pace(n, b);
    b.add(gathered.frames.size());
    for (const int frame : gathered.frames) b.add(frame);

    const std::vector<std::uint32_t> needed = varying_above(n);
    const bool rolls = std::any_of(needed.begin(), needed.end(),
                                   [&](std::uint32_t above) { return nodes_[above].rolls; });

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
    return nodes_[n].opens && with_side_files
               ? side_files_.look(first, place(n, graph_.range.first), files_).key
               : first;
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
    add_pace(n, b);
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

}  // namespace runtime
