#pragma once

// What a kind of node is: its ports, parameters, version, and the pure function behind it. The one
// description that the loader, validation, the schema, the reference and the tests read. Nodes make
// theirs with node_builder.hpp and keep them in a registry.hpp.

#include "graph/types/context.hpp"
#include "graph/types/param.hpp"
#include "graph/types/value.hpp"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace graph {

struct InputPort {
    std::string name, type, doc;
    bool optional = false;
    bool many = false;    // takes any number of links, a list in the document
    bool gather = false;  // receives this output at several frames, see NodeType::gather_frames
};

struct OutputPort {
    std::string name, type, doc;
    const WireType* wire = nullptr;  // null in a type made by hand: its values are not stored
};

// Everything a node sees when it runs. Spans are by port index.
struct Call {
    std::span<const std::vector<Value>> inputs;  // per input port: one value, or none, or many
    const ParamValues& params;                   // per parameter
    std::span<const Value> previous;             // per NodeType::previous; empty values at first
    std::span<const std::shared_ptr<const void>> prepared;  // per NodeType::preparations
    const Context& context;
};

// An output that comes back as an input one frame later: a node's only memory.
struct Previous {
    std::size_t output;  // index into outputs
};

// What a node remembers that reads its own result of the frame before. of_motion: how far it went
// since then, so nothing while no parameter and no input of it varies; it is the same at all frames
// then, and any of them can be cooked by itself.
enum class Memory : std::uint8_t { of_all_frames, of_motion };

// Work that depends on a few inputs and parameters only, done once for as long as they stay equal.
struct Preparation {
    std::string name;
    std::vector<std::size_t> inputs, params;  // indices of all it may see
    std::function<std::shared_ptr<const void>(const Call&)> build;
    std::size_t (*bytes)(const void*) = nullptr;
};

struct NodeType;

// A node that an input is linked to.
struct LinkedNode {
    std::string_view input, node;
    const NodeType* type = nullptr;
    const ParamValues* params = nullptr;        // those that move with the frame hold anything
    std::vector<std::string_view> linked = {};  // its own inputs that are linked

    // Its parameter `name`; null where it has none.
    const ParamValue* param(std::string_view name) const;
    // The text or choice of it; empty where it has none.
    std::string_view text(std::string_view name) const;
    bool links(std::string_view name) const
    {
        return std::find(linked.begin(), linked.end(), name) != linked.end();
    }
};

// What is known of a node before anything is cooked, beside its parameters.
struct Setting {
    std::vector<std::string_view> linked;  // inputs, once for each link
    std::vector<LinkedNode> sources;       // what they are linked to
    int frames = 1;                        // of which a cook writes files
    // All nodes that it depends on; null: not known.
    std::function<std::vector<LinkedNode>()> upstream = {};
    // Puts a text that follows from what is linked into a parameter, "block.name", that the
    // document leaves empty; null: nobody asks.
    std::function<void(std::string_view param, const std::string& text)> complete = {};

    bool links(std::string_view input) const
    {
        return std::find(linked.begin(), linked.end(), input) != linked.end();
    }
    std::size_t links_of(std::string_view input) const
    {
        return static_cast<std::size_t>(std::count(linked.begin(), linked.end(), input));
    }
};

// What makes every run of a node fail: at a parameter ("image.path") or an input, and why. A hint
// is a warning: the cook goes on, to a result that is hardly meant.
struct Fault {
    std::string at, why;
    bool hint = false;
};
using Faults = std::vector<Fault>;

struct Json;

// How a document's node of version `from` becomes one of version `from` + 1.
struct Upgrade {
    int from = 1;
    std::string note;                   // what changed, for people
    std::function<void(Json&)> change;  // of the node's object: its "inputs" and "params"
    std::vector<std::pair<std::string, std::string>> outputs;  // renamed: old name, new name
};

// What documents may say in place of values of parameters.
struct ShortForms {
    std::function<void(Json&)> write_out;  // in a node's object of this version; null: none
    std::vector<std::pair<std::string, std::string>> schemas;  // parameter, JSON schema as text
};

// A parameter, "block.name", that says how fast time passes in the scene where the video has a
// second: by the seconds of the scene that a frame takes, or by how many times slower the video is.
// 0: not said; a node with `seconds_a_frame` then keeps the video's time.
struct Pace {
    enum class By { seconds_a_frame, slow_motion } by = By::seconds_a_frame;
    std::string param;  // empty: the node says nothing
};

// An input of bodies, and whether the one of a link may bend in the node: in a simulation that
// keeps it rigid it may not. Without an input the node says nothing of bodies.
struct Bends {
    std::string input;
    std::function<bool(const ParamValues&, std::size_t link)> link;
};

struct NodeType {
    std::string name, summary;
    std::vector<std::string> synonyms;  // in lower case: what other programs call it, or its use
    int version = 1;
    std::vector<InputPort> inputs;
    std::vector<OutputPort> outputs;
    std::vector<Param> params;
    std::vector<Previous> previous;
    Memory memory = Memory::of_all_frames;
    std::vector<Preparation> preparations;
    std::vector<Upgrade> upgrades;  // from older versions
    ShortForms short_forms;
    Pace pace;
    Bends bends;
    unsigned reads = 0;  // context variables, see Variable
    bool sink = false;   // writes files: cooked by default, once a frame
    // For a node that gathers: which frames of its gathered inputs it wants. Such a node runs once
    // for a cook, not once a frame.
    std::function<std::vector<int>(const ParamValues&, const FrameRange&)> gather_frames;
    // Null, or what every run would fail at. Parameters that move with the frame hold anything.
    std::function<Faults(const ParamValues&, const Setting&)> check;
    std::function<std::vector<Value>(const Call&)> run;  // one value an output port
};

inline const ParamValue* LinkedNode::param(std::string_view name) const
{
    for (std::size_t k = 0; k < type->params.size() && k < params->size(); ++k) {
        if (type->params[k].name == name) return &(*params)[k];
    }
    return nullptr;
}

inline std::string_view LinkedNode::text(std::string_view name) const
{
    const ParamValue* const value = param(name);
    const auto* const text = value ? std::get_if<std::string>(&value->is) : nullptr;
    return text ? std::string_view(*text) : std::string_view();
}

}  // namespace graph
