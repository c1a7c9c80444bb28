#pragma once

// What a kind of node is: its ports, parameters, version, and the pure function behind it. The one
// description that the loader, validation, the schema, the reference and the tests read.

#include "graph/context.hpp"
#include "graph/param.hpp"
#include "graph/value.hpp"

#include <cstdio>
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
        auto plan = std::make_shared<Plan>(std::move(plan_));
        plan->params = std::move(this->binding_);
        type_.params = plan->params.params;
        for (std::size_t i = 0; i < plan->preparations.size(); ++i) {
            Preparation& p = type_.preparations[i];
            for (const std::string& name : plan->preparations[i].sees) find(name, p);
            p.build = [plan, i, p_inputs = p.inputs, p_params = p.params](const Call& call) {
                In in;
                for (const auto k : p_inputs) plan->inputs[k](in, call.inputs[k]);
                for (const auto k : p_params) plan->params.set[k](in, call.params[k]);
                return plan->preparations[i].build(in);
            };
        }
        if (gather_) {
            type_.gather_frames = [plan, frames = gather_](const ParamValues& params,
                                                           const FrameRange& range) {
                return frames(plan->params.decode(params), range);
            };
        }
        type_.run = [plan, run = run_](const Call& call) {
            In in = plan->params.decode(call.params);
            for (std::size_t i = 0; i < plan->inputs.size(); ++i) {
                plan->inputs[i](in, call.inputs[i]);
            }
            for (std::size_t i = 0; i < plan->previous.size(); ++i) {
                plan->previous[i](in, call.previous[i]);
            }
            for (std::size_t i = 0; i < plan->preparations.size(); ++i) {
                plan->preparations[i].set(in, call.prepared[i]);
            }
            Out out = run(in, call.context);
            std::vector<Value> values;
            values.reserve(plan->outputs.size());
            for (const auto& take : plan->outputs) values.push_back(take(out));
            return values;
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
        plan_.inputs.push_back([=](In& in, const std::vector<Value>& values) {
            in.*member = values.empty() ? nullptr : values[0].template as<T>();
        });
        type_.inputs.push_back(
            {std::move(name), wire_name<T>, std::move(doc), need == Need::optional, false, false});
        return *this;
    }

    // Any number of links, none included.
    template <Wireable T>
    NodeBuilder& inputs(std::string name, std::vector<Wire<T>> In::*member, std::string doc)
    {
        plan_.inputs.push_back(all_of(member));
        type_.inputs.push_back({std::move(name), wire_name<T>, std::move(doc), true, true, false});
        return *this;
    }

    // One link, its value at each of the frames that `frames` asks for.
    template <Wireable T>
    NodeBuilder& gather(std::string name, std::vector<Wire<T>> In::*member,
                        std::vector<int> (*frames)(const In&, const FrameRange&), std::string doc)
    {
        plan_.inputs.push_back(all_of(member));
        type_.inputs.push_back({std::move(name), wire_name<T>, std::move(doc), false, false, true});
        gather_ = frames;
        return *this;
    }

    // Feeds this node's own `output`, as it was one frame ago, to `member`: null on the first
    // frame. Declare the output first.
    template <Wireable T> NodeBuilder& previous(const std::string& output, Wire<T> In::*member)
    {
        plan_.previous.push_back(
            [=](In& in, const Value& value) { in.*member = value.template as<T>(); });
        for (std::size_t i = 0; i < type_.outputs.size(); ++i) {
            if (type_.outputs[i].name == output) return type_.previous.push_back({i}), *this;
        }
        throw std::logic_error(type_.name + ": previous() names no output: " + output);
    }

    // Fills `member` with build(in), kept for as long as the inputs and parameters named in `sees`
    // stay equal. `build` gets an In with only those filled, the rest default.
    template <class P>
    NodeBuilder& prepare(std::string name, std::shared_ptr<const P> In::*member,
                         P (*build)(const In&), std::vector<std::string> sees)
    {
        plan_.preparations.push_back({[build](const In& in) -> std::shared_ptr<const void> {
                                          return std::make_shared<const P>(build(in));
                                      },
                                      [member](In& in, const std::shared_ptr<const void>& p) {
                                          in.*member = std::static_pointer_cast<const P>(p);
                                      },
                                      std::move(sees)});
        type_.preparations.push_back({std::move(name), {}, {}, {}, [](const void* p) {
                                          return bytes_of(*static_cast<const P*>(p));
                                      }});
        return *this;
    }

    template <Wireable T> NodeBuilder& output(std::string name, T Out::*member, std::string doc)
    {
        plan_.outputs.push_back([=](Out& out) { return Value::of(std::move(out.*member)); });
        type_.outputs.push_back({std::move(name), wire_name<T>, std::move(doc), &wire_type<T>()});
        return *this;
    }
    // An output that hands on something already shared.
    template <Wireable T>
    NodeBuilder& output(std::string name, Wire<T> Out::*member, std::string doc)
    {
        plan_.outputs.push_back([=](Out& out) { return Value::of(std::move(out.*member)); });
        type_.outputs.push_back({std::move(name), wire_name<T>, std::move(doc), &wire_type<T>()});
        return *this;
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
    struct Prepared {
        std::function<std::shared_ptr<const void>(const In&)> build;
        std::function<void(In&, const std::shared_ptr<const void>&)> set;
        std::vector<std::string> sees;
    };
    struct Plan {
        std::vector<std::function<void(In&, const std::vector<Value>&)>> inputs;
        std::vector<std::function<void(In&, const Value&)>> previous;
        std::vector<std::function<Value(Out&)>> outputs;
        std::vector<Prepared> preparations;
        ParamBinding<In> params;
    };

    template <Wireable T> static auto all_of(std::vector<Wire<T>> In::*member)
    {
        return [member](In& in, const std::vector<Value>& values) {
            (in.*member).clear();
            for (const Value& value : values) (in.*member).push_back(value.template as<T>());
        };
    }

    void find(const std::string& name, Preparation& p) const
    {
        for (std::size_t i = 0; i < type_.inputs.size(); ++i) {
            if (type_.inputs[i].name == name) return p.inputs.push_back(i);
        }
        for (std::size_t i = 0; i < type_.params.size(); ++i) {
            if (type_.params[i].name == name) return p.params.push_back(i);
        }
        std::fprintf(stderr, "%s: prepare() sees no input or parameter called %s\n",
                     type_.name.c_str(), name.c_str());
        std::terminate();  // a slip in a description: no program starts with one
    }

    NodeType& type_;
    Run run_;
    Plan plan_;
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
