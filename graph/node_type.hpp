#pragma once

// What a kind of node is: its ports, parameters, version, and the pure function behind it. The one
// description that the loader, validation, the schema, the reference and the tests read.

#include "graph/context.hpp"
#include "graph/param.hpp"
#include "graph/value.hpp"

#include <map>
#include <span>
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

// Work that depends on a few inputs and parameters only, done once for as long as they stay equal.
struct Preparation {
    std::string name;
    std::vector<std::size_t> inputs, params;  // indices of all it may see
    std::function<std::shared_ptr<const void>(const Call&)> build;
    std::size_t (*bytes)(const void*) = nullptr;
};

struct Json;

// How a document's node of version `from` becomes one of version `from` + 1.
struct Upgrade {
    int from = 1;
    std::string note;                   // what changed, for people
    std::function<void(Json&)> change;  // of the node's object: its "inputs" and "params"
    std::vector<std::pair<std::string, std::string>> outputs;  // renamed: old name, new name
};

struct NodeType {
    std::string name, summary;
    int version = 1;
    std::vector<InputPort> inputs;
    std::vector<OutputPort> outputs;
    std::vector<Param> params;
    std::vector<Previous> previous;
    std::vector<Preparation> preparations;
    std::vector<Upgrade> upgrades;  // from older versions
    unsigned reads = 0;             // context variables, see Variable
    bool sink = false;              // writes files: cooked by default, once a frame
    // For a node that gathers: which frames of its gathered inputs it wants. Such a node runs once
    // for a cook, not once a frame.
    std::function<std::vector<int>(const ParamValues&, const FrameRange&)> gather_frames;
    std::function<std::vector<Value>(const Call&)> run;  // one value an output port
};

enum class Need { required, optional };

// How a node type's declarations fill its struct of inputs and read its struct of outputs. The
// structs' types are forgotten, so that all kinds of node share this code.
struct NodePlan {
    struct Prepared {
        std::function<std::shared_ptr<const void>(const void* in)> build;
        std::function<void(void* in, const std::shared_ptr<const void>&)> set;
        std::vector<std::string> sees;
    };
    std::vector<std::function<void(void* in, const std::vector<Value>&)>> inputs;
    std::vector<std::function<void(void* in, const Value&)>> previous;
    std::vector<std::function<Value(void* out)>> outputs;
    std::vector<Prepared> preparations;
    ParamBinding params;

    void fill(const Call& call, void* in) const;
    // Only what the preparation may see.
    void fill_for(const Preparation& preparation, const Call& call, void* in) const;
    std::vector<Value> take(void* out) const;

    // Declarations, of `type` and of this.
    static void add_input(NodeType& type, std::string& name, const char* wire, std::string& doc);
    static void add_output(NodeType& type, std::string& name, const WireType& wire,
                           std::string& doc);
    static void add_previous(NodeType& type, const std::string& output);
    // Makes out which inputs and parameters the preparations see.
    void finish(NodeType& type) const;
};

// Builds a NodeType from a pure function `Out run(const In&, const Context&)` and declarations that
// say which member of In or Out each port and parameter is.
template <class In, class Out> class NodeBuilder : public ParamBuilder<In, NodeBuilder<In, Out>> {
public:
    using Run = Out (*)(const In&, const Context&);

    NodeBuilder(NodeType& type, Run run) : type_(type), run_(run) {}
    NodeBuilder(NodeBuilder&&) = delete;

    // The description is complete when the declaring expression ends.
    ~NodeBuilder()
    {
        plan_.params = std::move(this->binding_);
        plan_.finish(type_);
        const auto plan = std::make_shared<const NodePlan>(std::move(plan_));
        for (std::size_t i = 0; i < plan->preparations.size(); ++i) {
            Preparation& p = type_.preparations[i];
            p.build = [plan, i, sees = Preparation{{}, p.inputs, p.params, {}}](const Call& call) {
                In in;
                plan->fill_for(sees, call, &in);
                return plan->preparations[i].build(&in);
            };
        }
        if (gather_) {
            type_.gather_frames = [plan, frames = gather_](const ParamValues& params,
                                                           const FrameRange& range) {
                In in;
                plan->params.decode(params, &in);
                return frames(in, range);
            };
        }
        type_.run = [plan, run = run_](const Call& call) {
            In in;
            plan->fill(call, &in);
            Out out = run(in, call.context);
            return plan->take(&out);
        };
    }

    NodeBuilder& summary(std::string text)
    {
        type_.summary = std::move(text);
        return *this;
    }

    // One link. `member` is null when an optional input is not linked.
    template <Wireable T>
    NodeBuilder& input(std::string name, Wire<T> In::*member, std::string doc,
                       Need need = Need::required)
    {
        plan_.inputs.push_back([member](void* in, const std::vector<Value>& values) {
            in_of(in).*member = values.empty() ? nullptr : values[0].template as<T>();
        });
        plan_.add_input(type_, name, wire_name<T>, doc);
        type_.inputs.back().optional = need == Need::optional;
        return *this;
    }

    // Any number of links, none included.
    template <Wireable T>
    NodeBuilder& inputs(std::string name, std::vector<Wire<T>> In::*member, std::string doc)
    {
        plan_.inputs.push_back(all_of(member));
        plan_.add_input(type_, name, wire_name<T>, doc);
        type_.inputs.back().optional = type_.inputs.back().many = true;
        return *this;
    }

    // One link, its value at each of the frames that `frames` asks for.
    template <Wireable T>
    NodeBuilder& gather(std::string name, std::vector<Wire<T>> In::*member,
                        std::vector<int> (*frames)(const In&, const FrameRange&), std::string doc)
    {
        plan_.inputs.push_back(all_of(member));
        plan_.add_input(type_, name, wire_name<T>, doc);
        type_.inputs.back().gather = true;
        gather_ = frames;
        return *this;
    }

    // Feeds this node's own `output`, as it was one frame ago, to `member`: null on the first
    // frame. Declare the output first.
    template <Wireable T> NodeBuilder& previous(const std::string& output, Wire<T> In::*member)
    {
        plan_.previous.push_back(
            [member](void* in, const Value& value) { in_of(in).*member = value.template as<T>(); });
        plan_.add_previous(type_, output);
        return *this;
    }

    // Fills `member` with build(in), kept for as long as the inputs and parameters named in `sees`
    // stay equal. `build` gets an In with only those filled, the rest default.
    template <class P>
    NodeBuilder& prepare(std::string name, std::shared_ptr<const P> In::*member,
                         P (*build)(const In&), std::vector<std::string> sees)
    {
        plan_.preparations.push_back({[build](const void* in) -> std::shared_ptr<const void> {
                                          return std::make_shared<const P>(
                                              build(*static_cast<const In*>(in)));
                                      },
                                      [member](void* in, const std::shared_ptr<const void>& p) {
                                          in_of(in).*member = std::static_pointer_cast<const P>(p);
                                      },
                                      std::move(sees)});
        type_.preparations.push_back({std::move(name), {}, {}, {}, [](const void* p) {
                                          return bytes_of(*static_cast<const P*>(p));
                                      }});
        return *this;
    }

    template <Wireable T> NodeBuilder& output(std::string name, T Out::*member, std::string doc)
    {
        return take(name, member, wire_type<T>(), doc);
    }
    // An output that hands on something already shared.
    template <Wireable T>
    NodeBuilder& output(std::string name, Wire<T> Out::*member, std::string doc)
    {
        return take(name, member, wire_type<T>(), doc);
    }

    // How a node of an older version is read; json.hpp has what `change` needs.
    NodeBuilder& upgrade(int from, std::string note, std::function<void(Json&)> change = {},
                         std::vector<std::pair<std::string, std::string>> outputs = {})
    {
        type_.upgrades.push_back({from, std::move(note), std::move(change), std::move(outputs)});
        return *this;
    }

    // Which context variables run() reads: Variable::frame | Variable::fps ...
    NodeBuilder& reads(unsigned variables)
    {
        type_.reads = variables;
        return *this;
    }
    NodeBuilder& reads(Variable variable) { return reads(static_cast<unsigned>(variable)); }

    // It writes files, so a cook wants it even though nothing depends on it.
    NodeBuilder& sink()
    {
        type_.sink = true;
        return *this;
    }

private:
    static In& in_of(void* in) { return *static_cast<In*>(in); }

    template <Wireable T> static auto all_of(std::vector<Wire<T>> In::*member)
    {
        return [member](void* in, const std::vector<Value>& values) {
            auto& all = in_of(in).*member;
            all.clear();
            for (const Value& value : values) all.push_back(value.template as<T>());
        };
    }
    template <class T>
    NodeBuilder& take(std::string& name, T Out::*member, const WireType& wire, std::string& doc)
    {
        plan_.outputs.push_back(
            [member](void* out) { return Value::of(std::move(static_cast<Out*>(out)->*member)); });
        plan_.add_output(type_, name, wire, doc);
        return *this;
    }

    NodeType& type_;
    Run run_;
    NodePlan plan_;
    std::vector<int> (*gather_)(const In&, const FrameRange&) = nullptr;
};

class Registry {
public:
    template <class In, class Out>
    NodeBuilder<In, Out> add(std::string name, int version, Out (*run)(const In&, const Context&))
    {
        NodeType& type = types_[name];
        type.name = std::move(name);
        type.version = version;
        return {type, run};
    }

    // Null when there is no such type.
    const NodeType* find(const std::string& name) const
    {
        const auto found = types_.find(name);
        return found == types_.end() ? nullptr : &found->second;
    }
    const std::map<std::string, NodeType>& types() const { return types_; }

private:
    std::map<std::string, NodeType> types_;
};

}  // namespace graph
