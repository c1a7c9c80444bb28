#pragma once

// Declares a node type: a pure function, and one call per input, output and parameter that says
// which member of the function's structs it is. See nodes/sample.cpp for a whole one.
//
//   registry.add("Sample", 1, run)
//       .input("mesh", &Inputs::mesh, "Surface to sample.")
//       .param("count", &Inputs::count, "Number of points.", {.min = 1})
//       .output("points", &Outputs::points, "The samples.");

#include "graph/types/bytes.hpp"
#include "graph/types/node_plan.hpp"
#include "graph/types/param_builder.hpp"
#include "graph/types/registry.hpp"

namespace graph {

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
        const auto of_params = [&plan](auto function) {
            return [plan, function](const ParamValues& params, const auto& more) {
                In in;
                return plan->params.decode(params, &in), function(in, more);
            };
        };
        if (gather_) type_.gather_frames = of_params(gather_);
        if (check_) type_.check = of_params(check_);
        if (bends_) type_.bends.link = of_params(bends_);
        type_.run = [plan, run = run_](const Call& call) {
            In in;
            plan->fill(call, &in);
            Out out = run(in, call.context);
            return plan->take(&out);
        };
    }

    NodeBuilder& summary(std::string text, std::vector<std::string> synonyms = {})
    {
        type_.summary = std::move(text);
        return type_.synonyms = std::move(synonyms), *this;
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

    // Any number of links: none included, unless it is required.
    template <Wireable T>
    NodeBuilder& inputs(std::string name, std::vector<Wire<T>> In::*member, std::string doc,
                        Need need = Need::optional)
    {
        plan_.inputs.push_back(all_of(member));
        plan_.add_input(type_, name, wire_name<T>, doc);
        type_.inputs.back().many = true, type_.inputs.back().optional = need == Need::optional;
        return *this;
    }

    // One link, its values at the frames that `frames` asks for: the same of all that gather.
    template <Wireable T>
    NodeBuilder& gather(std::string name, std::vector<Wire<T>> In::*member,
                        std::vector<int> (*frames)(const In&, const FrameRange&), std::string doc,
                        Need need = Need::required)
    {
        plan_.inputs.push_back(all_of(member));
        plan_.add_input(type_, name, wire_name<T>, doc);
        type_.inputs.back().gather = true, type_.inputs.back().optional = need == Need::optional;
        return gather_ = frames, *this;
    }

    // Feeds this node's own `output`, as it was one frame ago, to `member`: null on the first
    // frame, and with Memory::of_motion while nothing moves. Declare the output first.
    template <Wireable T>
    NodeBuilder& previous(const std::string& output, Wire<T> In::*member,
                          Memory memory = Memory::of_all_frames)
    {
        plan_.previous.push_back(
            [member](void* in, const Value& value) { in_of(in).*member = value.template as<T>(); });
        return plan_.add_previous(type_, output, memory), *this;
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

    NodeBuilder& short_forms(ShortForms f) { return type_.short_forms = std::move(f), *this; }

    // Which context variables run() reads: Variable::frame | Variable::fps ...
    NodeBuilder& reads(unsigned variables) { return type_.reads = variables, *this; }
    NodeBuilder& reads(Variable variable) { return reads(static_cast<unsigned>(variable)); }

    // Finds before a cook what every run would fail at; `in` has its parameters alone.
    NodeBuilder& check(Faults (*check)(const In&, const Setting&)) { return check_ = check, *this; }

    // It writes files, so a cook wants it even though nothing depends on it.
    NodeBuilder& sink() { return type_.sink = true, *this; }

    // How time passes in the scene.
    NodeBuilder& pace(Pace pace) { return type_.pace = std::move(pace), *this; }
    // Whether the body of a link of `input` may bend; `in` has its parameters alone.
    NodeBuilder& bends(std::string input, bool (*bends)(const In&, const std::size_t& link))
    {
        return type_.bends.input = std::move(input), bends_ = bends, *this;
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
    Faults (*check_)(const In&, const Setting&) = nullptr;
    bool (*bends_)(const In&, const std::size_t&) = nullptr;
};

}  // namespace graph
