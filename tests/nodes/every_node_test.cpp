// What every node promises, asked of every node there is. A new node is covered the day its file is
// added: nothing here names one.

#include "graph/types/encoder.hpp"
#include "nodes/registry.hpp"
#include "nodes/wire_types.hpp"
#include "tests/geometry/files.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <map>
#include <regex>
#include <set>

namespace {

using graph::NodeType;
using graph::Param;
using graph::ParamKind;
using graph::ParamValue;
using graph::ParamValues;
using graph::Value;

// ---- what descriptions promise ------------------------------------------------------------------

bool is_sentence(const std::string& doc)
{
    return doc.size() > 4 && doc.back() == '.' && doc.find("  ") == std::string::npos;
}

bool is_snake_case(const std::string& name)
{
    static const std::regex form("[a-z][a-z0-9]*(_[a-z0-9]+)*");
    return std::regex_match(name, form);
}

// "VoxelGrid" of the file voxel_grid.cpp.
std::string stem_of(const std::string& type_name)
{
    std::string stem;
    for (const char c : type_name) {
        if (std::isupper(static_cast<unsigned char>(c)) && !stem.empty()) stem += '_';
        stem += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    return stem;
}

// Calls see(params, param) for each parameter, those inside blocks and lists too.
template <class See> void every_param(const std::vector<Param>& params, const See& see)
{
    for (const Param& p : params) {
        see(params, p);
        every_param(p.children, see);
    }
}

// Calls see(type, params, param) for every parameter of every node.
template <class See> void every_param_of_every_node(const See& see)
{
    for (const auto& entry : nodes::registry().types()) {
        const NodeType& type = entry.second;
        SCOPED_TRACE(entry.first);
        every_param(type.params, [&](const std::vector<Param>& siblings, const Param& p) {
            SCOPED_TRACE(p.name);
            see(type, siblings, p);
        });
    }
}

TEST(EveryNode, HasTheNameOfItsFileAVersionAndASummary)
{
    ASSERT_FALSE(nodes::registry().types().empty());
    for (const auto& [name, type] : nodes::registry().types()) {
        SCOPED_TRACE(name);
        EXPECT_EQ(type.name, name);
        EXPECT_GE(type.version, 1);
        EXPECT_TRUE(is_sentence(type.summary)) << type.summary;
        const auto file = files::fs::path(ASPIC_SOURCE_DIR) / "nodes" / (stem_of(name) + ".cpp");
        EXPECT_TRUE(files::fs::exists(file)) << file;
    }
}

TEST(EveryNode, DocumentsItsPortsAndParametersInSentences)
{
    for (const auto& [name, type] : nodes::registry().types()) {
        SCOPED_TRACE(name);
        for (const auto& port : type.inputs) EXPECT_TRUE(is_sentence(port.doc)) << port.doc;
        for (const auto& port : type.outputs) EXPECT_TRUE(is_sentence(port.doc)) << port.doc;
        EXPECT_FALSE(type.outputs.empty());
    }
    every_param_of_every_node([](const NodeType&, const std::vector<Param>&, const Param& p) {
        EXPECT_TRUE(is_sentence(p.doc)) << p.doc;
    });
}

TEST(EveryNode, NamesItsPortsAndParametersOnceAndInSnakeCase)
{
    for (const auto& [name, type] : nodes::registry().types()) {
        SCOPED_TRACE(name);
        std::set<std::string> taken;
        for (const auto& port : type.inputs) {
            EXPECT_TRUE(is_snake_case(port.name)) << port.name;
            EXPECT_TRUE(taken.insert(port.name).second) << port.name;
        }
        for (const Param& p : type.params) EXPECT_TRUE(taken.insert(p.name).second) << p.name;
        std::set<std::string> outputs;
        for (const auto& port : type.outputs) {
            EXPECT_TRUE(is_snake_case(port.name)) << port.name;
            EXPECT_TRUE(outputs.insert(port.name).second) << port.name;
        }
    }
    every_param_of_every_node(
        [](const NodeType&, const std::vector<Param>& siblings, const Param& p) {
            EXPECT_TRUE(is_snake_case(p.name));
            EXPECT_EQ(std::count_if(siblings.begin(), siblings.end(),
                                    [&](const Param& q) { return q.name == p.name; }),
                      1);
        });
}

TEST(EveryNode, UsesKnownUnitsAndAnglesInDegrees)
{
    // Products and quotients of unit symbols and whole powers: "m", "kg/m^3", "m/s^2", "N s/m".
    static const std::regex unit("([a-zA-Z%]+(\\^[0-9])?)([ /][a-zA-Z]+(\\^[0-9])?)*|1/[a-z]+");
    every_param_of_every_node([](const NodeType&, const std::vector<Param>&, const Param& p) {
        const std::string& given = p.limits.unit;
        EXPECT_TRUE(given.empty() || std::regex_match(given, unit)) << given;
        EXPECT_FALSE(given.starts_with("rad")) << given;  // stiffnesses are N m/rad
        const bool in_degrees = p.name.find("degrees") != std::string::npos;
        EXPECT_TRUE(!in_degrees || given.starts_with("deg")) << given;
    });
}

// Whether a default is of its parameter's kind and within its limits, and a number that a person
// would write.
void expect_sane_default(const Param& p)
{
    const auto within = [&](double x) {
        EXPECT_LE(fmt::format("{}", x).size(), 9u) << x;
        EXPECT_GE(x, p.limits.min);
        EXPECT_LE(x, p.limits.max);
    };
    const auto& is = p.fallback.is;
    EXPECT_LE(p.limits.min, p.limits.max);
    switch (p.kind) {
    case ParamKind::boolean:
        EXPECT_TRUE(std::holds_alternative<bool>(is));
        break;
    case ParamKind::integer:
        within(double(std::get<std::int64_t>(is)));
        break;
    case ParamKind::number:
        within(std::get<double>(is));
        break;
    case ParamKind::vector:
    case ParamKind::colour:
        for (const double x : std::get<std::array<double, 3>>(is)) within(x);
        break;
    case ParamKind::choice: {
        const auto& choice = std::get<std::string>(is);
        EXPECT_EQ(std::count(p.choices.begin(), p.choices.end(), choice), 1) << choice;
        for (const auto& c : p.choices) EXPECT_TRUE(is_snake_case(c)) << c;
        break;
    }
    case ParamKind::text:
    case ParamKind::path_in:
    case ParamKind::path_out:
        EXPECT_TRUE(std::holds_alternative<std::string>(is));
        break;
    case ParamKind::block:
        EXPECT_EQ(std::get<ParamValues>(is).size(), p.children.size());
        EXPECT_FALSE(p.children.empty());
        break;
    case ParamKind::list:
        EXPECT_TRUE(std::get<ParamValues>(is).empty());
        EXPECT_FALSE(p.children.empty());
        break;
    }
}

TEST(EveryNode, HasDefaultsWithinItsOwnLimits)
{
    every_param_of_every_node(
        [](const NodeType&, const std::vector<Param>&, const Param& p) { expect_sane_default(p); });
}

TEST(EveryNode, ShowsParametersByChoicesThatExist)
{
    every_param_of_every_node([](const NodeType&, const std::vector<Param>& siblings,
                                 const Param& p) {
        if (p.shown_when.param.empty()) return;
        const auto by = std::find_if(siblings.begin(), siblings.end(),
                                     [&](const Param& q) { return q.name == p.shown_when.param; });
        ASSERT_NE(by, siblings.end()) << p.shown_when.param;
        EXPECT_NE(&*by, &p);
        EXPECT_FALSE(p.shown_when.values.empty());
        for (const auto& value : p.shown_when.values) {
            const bool known = by->kind == ParamKind::boolean
                                   ? value == "true" || value == "false"
                                   : std::count(by->choices.begin(), by->choices.end(), value) == 1;
            EXPECT_TRUE(known) << by->name << " has no " << value;
        }
    });
}

TEST(EveryNode, RefersOnlyToItsOwnPortsAndParameters)
{
    for (const auto& [name, type] : nodes::registry().types()) {
        SCOPED_TRACE(name);
        for (const auto& p : type.previous) EXPECT_LT(p.output, type.outputs.size());
        std::set<std::string> names;
        for (const auto& p : type.preparations) {
            EXPECT_TRUE(names.insert(p.name).second) << p.name;
            EXPECT_TRUE(p.build && p.bytes);
            for (const auto i : p.inputs) EXPECT_LT(i, type.inputs.size());
            for (const auto i : p.params) EXPECT_LT(i, type.params.size());
        }
        bool gathers = false;
        for (const auto& port : type.inputs) gathers = gathers || port.gather;
        EXPECT_EQ(gathers, static_cast<bool>(type.gather_frames));
        EXPECT_LT(type.reads, 16u);
    }
}

TEST(EveryNode, CanGetItsRequiredInputsFromOtherNodes)
{
    std::set<std::string> wires, reached;
    for (std::size_t before = 1; before != reached.size();) {
        before = reached.size();
        for (const auto& [name, type] : nodes::registry().types()) {
            const bool fed =
                std::all_of(type.inputs.begin(), type.inputs.end(), [&](const auto& port) {
                    return port.optional || wires.count(port.type);
                });
            if (!fed) continue;
            reached.insert(name);
            for (const auto& port : type.outputs) wires.insert(port.type);
        }
    }
    for (const auto& [name, type] : nodes::registry().types()) {
        EXPECT_TRUE(reached.count(name)) << name << ": no node gives what it needs";
    }
}

TEST(EveryNode, ThatWritesFilesHasAPathAndAFileOutput)
{
    for (const auto& [name, type] : nodes::registry().types()) {
        if (!type.sink) continue;
        SCOPED_TRACE(name);
        int paths = 0, files = 0;
        every_param(type.params, [&](const std::vector<Param>&, const Param& p) {
            paths += p.kind == ParamKind::path_out;
        });
        for (const auto& port : type.outputs) {
            files += port.type == std::string(graph::wire_name<graph::WrittenFile>);
        }
        EXPECT_GE(paths, 1);
        EXPECT_GE(files, 1);
    }
}

// ---- what runs promise --------------------------------------------------------------------------

enum class Linked { needed, all };

// One value of each wire type that nodes give with their defaults, found by running them.
class Specimens {
public:
    // Cubes are made by hand: those of default parameters are too many for a test. Then sources, as
    // they never give something empty; then round after round until one brings nothing new: what
    // one node gives, another needs.
    Specimens()
    {
        const Value cubes = Value::of(fixtures::box(4, 2, 2, 0.25, {.young = 1e5}));
        value_.emplace(cubes.type_name(), cubes);
        for (const auto& [name, type] : nodes::registry().types()) {
            if (type.inputs.empty()) keep_outputs_of(type);
        }
        for (std::size_t before = 0; before != value_.size();) {
            before = value_.size();
            for (const auto& [name, type] : nodes::registry().types()) {
                if (can_run(type) && !knows_outputs_of(type)) keep_outputs_of(type);
            }
        }
    }

    bool can_run(const NodeType& type) const
    {
        return std::all_of(type.inputs.begin(), type.inputs.end(), [&](const auto& port) {
            return port.optional || value_.count(port.type);
        });
    }

    // The outputs with default parameters; none, with the reason in `why`, when it refuses.
    std::vector<Value> run(const NodeType& type, Linked linked, std::string& why) const
    {
        const graph::FrameRange range{1, 2, 24};
        ParamValues params;
        for (const auto& p : type.params) params.push_back(p.fallback);
        std::vector<int> frames;
        if (type.gather_frames) frames = type.gather_frames(params, range);

        std::vector<std::vector<Value>> inputs;
        for (const auto& port : type.inputs) {
            const auto found = value_.find(port.type);
            const bool none = (port.optional && linked == Linked::needed) || found == value_.end();
            const std::size_t count = port.gather ? frames.size() : none ? 0 : 1;
            inputs.emplace_back(none ? std::vector<Value>{}
                                     : std::vector<Value>(count, found->second));
        }
        const files::Folder folder;
        graph::Context context(1, range, type.reads);
        context.output_folder = folder.path;
        context.gathered = frames;
        try {
            std::vector<std::shared_ptr<const void>> prepared;
            for (const auto& p : type.preparations) {
                prepared.push_back(p.build({inputs, params, {}, {}, context}));
            }
            const std::vector<Value> previous(type.previous.size());
            return type.run({inputs, params, previous, prepared, context});
        } catch (const std::exception& error) {
            why = error.what();
            return {};
        }
    }

private:
    void keep_outputs_of(const NodeType& type)
    {
        std::string why;
        for (const Linked linked : {Linked::needed, Linked::all}) {
            for (const Value& v : run(type, linked, why)) {
                if (v) value_.try_emplace(v.type_name(), v);
            }
        }
    }
    bool knows_outputs_of(const NodeType& type) const
    {
        return std::all_of(type.outputs.begin(), type.outputs.end(),
                           [&](const auto& port) { return value_.count(port.type); });
    }

    std::map<std::string, Value> value_;
};

const Specimens& specimens()
{
    static const Specimens all;
    return all;
}

// A value's bytes, shared content and all.
std::string bytes_of(const Value& value)
{
    std::string shared;
    graph::Encoder encoder;
    encoder.share = [&](const std::shared_ptr<const void>& content, const std::string&,
                        void (*encode)(const void*, graph::Encoder&)) {
        graph::Encoder inner;
        inner.share = encoder.share;
        if (content) encode(content.get(), inner);
        shared += inner.bytes;
        return graph::ContentName{};
    };
    value.type()->encode(value.content(), encoder);
    return encoder.bytes + shared;
}

TEST(EveryNode, RunsWithItsDefaultsOrSaysWhyNot)
{
    for (const auto& [name, type] : nodes::registry().types()) {
        SCOPED_TRACE(name);
        if (!specimens().can_run(type)) continue;
        for (const Linked linked : {Linked::needed, Linked::all}) {
            std::string why;
            const std::vector<Value> outputs = specimens().run(type, linked, why);
            if (outputs.empty()) {
                EXPECT_GT(why.size(), 20u) << why;
                continue;
            }
            ASSERT_EQ(outputs.size(), type.outputs.size());
            for (std::size_t i = 0; i < outputs.size(); ++i) {
                EXPECT_EQ(outputs[i].type_name(), type.outputs[i].type);
                EXPECT_GT(outputs[i].bytes(), 0u);
            }
        }
    }
}

TEST(EveryNode, GivesTheSameBytesTwiceAndOnOneThread)
{
    for (const auto& [name, type] : nodes::registry().types()) {
        SCOPED_TRACE(name);
        if (type.sink || !specimens().can_run(type)) continue;  // files go to a folder of their own
        std::string why;
        const std::vector<Value> first = specimens().run(type, Linked::all, why);
        tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        const std::vector<Value> again = specimens().run(type, Linked::all, why);
        ASSERT_EQ(first.size(), again.size());
        for (std::size_t i = 0; i < first.size(); ++i) {
            if (!first[i].type()->encode) continue;
            EXPECT_TRUE(bytes_of(first[i]) == bytes_of(again[i])) << type.outputs[i].name;
        }
    }
}

}  // namespace
