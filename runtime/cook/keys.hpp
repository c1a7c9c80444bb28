#pragma once

// The key of every result that a cook may want.
//   static part  S(n) = hash(type, version, constant parameters, named files' bytes, links' shape,
//                            declared fps and range)
//   key       K(n, f) = hash(S(n), animated parameters at f, declared frame f, K(inputs, f),
//                            K(n, f - 1) where the node sees its own output of the frame before)
// Most nodes of most graphs are the same at every frame: they have one key. The others have a row
// of keys a frame, made when asked for and dropped again; only K(n, f - 1) of simulations is kept
// for all frames up to the last one asked for, 16 bytes each.

#include "graph/document/graph.hpp"
#include "runtime/cook/side_files.hpp"

#include <list>
#include <map>

namespace runtime {

struct KeyOptions {
    Key salt;                             // what all results depend on: which program this is
    std::filesystem::path output_folder;  // where sinks write: part of the keys of sinks only
};

class Keys {
public:
    Keys(const graph::Graph& graph, FileDigests& files, SideFiles& side_files, KeyOptions options);

    // Makes the keys of everything that `targets` depend on, in a cook of `frames` (ascending).
    // Only what changed since the last time is hashed again.
    void aim(const std::vector<std::uint32_t>& targets, const std::vector<int>& frames);

    // A parameter or link of the graph's node `n` was changed.
    void edited(std::uint32_t n);

    // All three need a node that the last aim() reached.
    bool varies(std::uint32_t n) const { return nodes_[n].varies; }
    // Whether it needs its own result of the frame before.
    bool rolls(std::uint32_t n) const { return nodes_[n].rolls; }
    const Key& at(std::uint32_t n, int frame);

    // Key of a preparation of the node. Throws what evaluating a parameter throws.
    Key preparation(std::uint32_t n, std::size_t which, int frame);

    // The same result's second key, of what is in its inputs instead of where they came from:
    //   C(n, f) = hash(S(n), animated parameters at f, declared frame f, names of the inputs'
    //                  contents, by port, link and frame, then of its own frame before)
    // so a node whose inputs came out as they were need not run. Both throw what evaluating a
    // parameter throws. Safe to call while a cook runs.
    Key by_content(std::uint32_t n, int frame, std::span<const graph::ContentName> names) const;
    Key preparation_by_content(std::uint32_t n, std::size_t which, int frame,
                               std::span<const graph::ContentName> names) const;

    // Whether the node may open files beside those that its parameters name.
    bool opens(std::uint32_t n) const { return nodes_[n].opens; }
    // The nodes that do, of those that the last aim() reached, and whether it is known what they
    // open at `frame`.
    const std::vector<std::uint32_t>& openers() const { return openers_; }
    bool known(std::uint32_t n, int frame);
    // What it opened there beside the files that its parameters name, as far as that is known.
    std::vector<std::filesystem::path> side_files(std::uint32_t n, int frame);
    // The node ran and opened these. Returns its key, which may differ from that before.
    Key opened(std::uint32_t n, int frame, const std::set<std::filesystem::path>& paths);
    // Whether the files named by the node's parameters are not what its key says any more.
    bool files_changed(std::uint32_t n, int frame) const;

    // Frames at which the node's input port is wanted when the node runs at `frame`: that one, or
    // for a port that gathers, all it asks for. The span may be `frame` itself.
    std::span<const int> input_frames(std::uint32_t n, std::size_t port, const int& frame) const;

    // Which of the graph's types of nodes, 0, 1 ...
    std::uint32_t type(std::uint32_t n) const { return nodes_[n].type; }
    std::size_t type_count() const { return types_.size(); }

    // Why a gathering node can't say which frames it wants; empty when it can.
    const std::string& trouble(std::uint32_t n) const;

    // Parameters as the node sees them.
    graph::ParamValues params(std::uint32_t n, int frame) const;

    const std::vector<std::uint32_t>& reached() const { return reached_; }

private:
    struct Node {
        Key fixed;                                // S, where one_hash() is not true
        Key key;                                  // K where it does not vary; else unused
        std::uint32_t slot = 0;                   // into a row, where it varies
        std::uint32_t type = 0;                   // into types_
        std::uint32_t first_link = 0, links = 0;  // into links_
        bool moves = false;                       // with the frame, by itself
        bool placed = false;  // depends on frames a second, the range or the output folder
        bool varies = false, rolls = false, opens = false, gathers = false;
        bool sequence = false;  // of files, one a frame
        bool stale = true, changed = false;

        // Where S would go into one key only, its parts go there directly.
        bool one_hash() const { return !varies && !opens && !gathers; }
    };
    struct Input {
        std::uint32_t node, port, output;
        bool operator==(const Input&) const = default;
    };
    struct Row {
        int frame = 0;
        std::vector<Key> keys;  // by Node::slot
    };
    struct Gathered {
        std::vector<int> frames;
        std::string trouble;
    };

    template <class See> static void each_link(const graph::Node& node, const See& see);
    void read_links();
    void forget_rows();
    void reach(const std::vector<std::uint32_t>& targets);
    void add_fixed_part(std::uint32_t n, KeyBuilder& builder) const;
    Key fixed_part(std::uint32_t n) const
    {
        KeyBuilder builder;
        add_fixed_part(n, builder);
        return builder.key();
    }
    void add_animated(std::uint32_t n, int frame, KeyBuilder& builder) const;
    Key files_of_frame(std::uint32_t n, int frame) const;
    void add_movement(std::uint32_t n, int frame);
    void add_pace(std::uint32_t n, KeyBuilder& b) const;
    Key key(std::uint32_t n, int frame, const std::vector<Key>& row, bool with_side_files);
    Key gather_key(std::uint32_t n, bool with_side_files);
    const Gathered& gather_frames(std::uint32_t n, KeyBuilder& builder);
    std::vector<std::uint32_t> varying_above(std::uint32_t n) const;
    Key first_key(std::uint32_t n, int frame);
    void fill(const std::vector<std::uint32_t>& nodes, int frame, std::vector<Key>& row);
    const std::vector<Key>& row(int frame);
    void roll(int frame);
    SideFiles::Place place(std::uint32_t n, int frame) const;
    const Key& input_key(std::uint32_t n, const std::vector<Key>& row) const
    {
        return nodes_[n].varies ? row[nodes_[n].slot] : nodes_[n].key;
    }

    const graph::Graph& graph_;
    FileDigests& files_;
    SideFiles& side_files_;
    KeyOptions options_;

    std::vector<Node> nodes_;
    std::vector<Key> types_;    // what all nodes of a type share
    std::vector<Input> links_;  // what each node takes, by port
    std::vector<int> frames_;   // of this cook
    std::vector<std::uint32_t> targets_;
    std::vector<std::uint32_t> reached_;        // ascending, so inputs stand first
    std::vector<std::uint32_t> varying_;        // of those
    std::vector<std::uint32_t> under_rolling_;  // of those: simulations and what they depend on
    std::vector<std::uint32_t> rolling_;        // of those: simulations
    std::vector<std::uint32_t> openers_, file_nodes_;
    std::uint32_t first_stale_ = 0;
    // Of nodes that read sequences of files: what was in those of a frame when its key was made.
    std::map<std::pair<std::uint32_t, int>, Key> sequences_;

    std::unordered_map<std::uint32_t, Gathered> gathered_;
    std::vector<std::vector<Key>> history_;  // one a rolling node, K at first, first + 1, ...
    int rolled_ = 0;                         // frames in each of them
    std::vector<Key> rolling_row_;           // row of the last rolled frame
    std::list<Row> rows_;                    // most recently used first
    KeyBuilder builder_;
};

}  // namespace runtime
