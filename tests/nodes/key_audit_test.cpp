// A key names everything that a result depends on, of every node there is: change any parameter,
// link, declared variable or byte of a file, and the key is another; change what a node cannot see,
// and it is the same. A new node is covered the day its file is added: nothing here names one.

#include "graph/document/document.hpp"
#include "nodes/registry.hpp"
#include "runtime/cook/keys.hpp"
#include "tests/geometry/files.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using graph::NodeType;
using graph::Param;
using graph::ParamKind;
using graph::ParamValue;
using graph::ParamValues;
using runtime::Key;

// Stands for whatever feeds an input: two outputs of the port's type, and a number that says which
// of its kind it is. Keys never run anything.
NodeType source_of(const std::string& wire)
{
    NodeType type;
    type.name = "SourceOf" + wire;
    type.outputs = {{"first", wire, "", nullptr}, {"second", wire, "", nullptr}};
    Param which;
    which.name = "which";
    type.params = {which};
    return type;
}

// One node of the type, every input linked to a source of its own; lists to two.
struct Audited {
    std::vector<std::unique_ptr<NodeType>> sources;
    graph::Graph graph;

    explicit Audited(const NodeType& type)
    {
        graph.range = {1, 9, 24};
        graph::Node node;
        node.name = "audited", node.type = &type;
        for (const Param& p : type.params) node.params.push_back(p.fallback);
        for (const graph::InputPort& port : type.inputs) {
            sources.push_back(std::make_unique<NodeType>(source_of(port.type)));
            auto& links = node.inputs.emplace_back();
            for (int i = 0; i < (port.many ? 2 : 1); ++i) links.push_back({add_source(), 0});
        }
        graph.nodes.push_back(std::move(node));
    }
    std::uint32_t add_source()
    {
        graph::Node source;
        source.name = "source" + std::to_string(graph.nodes.size());
        source.type = sources.back().get();
        source.params = {{double(graph.nodes.size())}};
        graph.nodes.push_back(std::move(source));
        return static_cast<std::uint32_t>(graph.nodes.size() - 1);
    }
    graph::Node& node() { return graph.nodes.back(); }
    const NodeType& type() const { return *graph.nodes.back().type; }

    runtime::KeyOptions options{{7, 7}, "/tmp/out"};
    std::vector<int> frames{1, 2, 3, 4, 5, 6, 7, 8, 9};

    Key key(int frame = 5) const
    {
        runtime::FileDigests files;
        runtime::SideFiles side_files;
        runtime::Keys keys(graph, files, side_files, options);
        const auto n = static_cast<std::uint32_t>(graph.nodes.size() - 1);
        keys.aim({n}, frames);
        return keys.at(n, frame);
    }
    Key preparation(std::size_t which) const
    {
        runtime::FileDigests files;
        runtime::SideFiles side_files;
        runtime::Keys keys(graph, files, side_files, options);
        const auto n = static_cast<std::uint32_t>(graph.nodes.size() - 1);
        keys.aim({n}, frames);
        return keys.preparation(n, which, 5);
    }
};

template <class F> void each_type(const F& see)
{
    for (const auto& [name, type] : nodes::registry().types()) {
        SCOPED_TRACE(name);
        see(type);
    }
}

// Another value of the same kind, whether or not the node would take it.
ParamValue another(const Param& p, const ParamValue& value)
{
    switch (p.kind) {
    case ParamKind::boolean:
        return {!std::get<bool>(value.is)};
    case ParamKind::integer:
        return {std::get<std::int64_t>(value.is) ^ 1};
    case ParamKind::number:
        return {std::nextafter(std::get<double>(value.is), 1e300)};
    case ParamKind::choice: {
        for (const std::string& c : p.choices) {
            if (c != std::get<std::string>(value.is)) return {c};
        }
        return {std::string("none")};
    }
    default:
        return {std::get<std::string>(value.is) + "x"};
    }
}

// Changes each plain value below `value` in turn, calls see() with it changed, and puts it back.
void each_change(const Param& p, ParamValue& value, const std::function<void()>& see)
{
    const ParamValue was = value;
    if (p.kind == ParamKind::vector || p.kind == ParamKind::colour) {
        for (std::size_t i = 0; i < 3; ++i) {
            double& x = std::get<std::array<double, 3>>(value.is)[i];
            x = std::nextafter(x, 1e300);
            see();
            value = was;
        }
    } else if (p.kind == ParamKind::block) {
        auto& members = std::get<ParamValues>(value.is);
        for (std::size_t i = 0; i < members.size(); ++i) {
            SCOPED_TRACE(p.children[i].name);
            each_change(p.children[i], members[i], see);
        }
    } else if (p.kind == ParamKind::list) {
        ParamValues element;
        for (const Param& child : p.children) element.push_back(child.fallback);
        std::get<ParamValues>(value.is).push_back({element});
        see();
        auto& members = std::get<ParamValues>(std::get<ParamValues>(value.is).back().is);
        for (std::size_t i = 0; i < members.size(); ++i) {
            SCOPED_TRACE(p.children[i].name);
            each_change(p.children[i], members[i], see);
        }
        std::get<ParamValues>(value.is).push_back({element});
        see();
        value = was;
    } else {
        value = another(p, value);
        see();
        value = was;
    }
}

TEST(KeyAudit, EveryValueOfEveryParameterChangesTheKey)
{
    std::size_t changes = 0;
    each_type([&](const NodeType& type) {
        Audited a(type);
        std::set<Key> seen{a.key()};
        for (std::size_t i = 0; i < type.params.size(); ++i) {
            SCOPED_TRACE(type.params[i].name);
            each_change(type.params[i], a.node().params[i], [&] {
                EXPECT_TRUE(seen.insert(a.key()).second) << "met before";
                ++changes;
            });
        }
        EXPECT_TRUE(seen.contains(a.key())) << "put back, it is the same";
    });
    EXPECT_GT(changes, 200u);
}

TEST(KeyAudit, AnAnimatedParameterChangesTheKeyByItsValueAtTheFrame)
{
    each_type([&](const NodeType& type) {
        for (std::size_t i = 0; i < type.params.size(); ++i) {
            if (type.params[i].kind != ParamKind::number) continue;
            if (type.gather_frames) continue;  // evaluated at the first frame, once
            SCOPED_TRACE(type.params[i].name);
            Audited a(type);
            graph::Animated moving;
            moving.where = {static_cast<std::uint32_t>(i)};
            const double rest = std::get<double>(type.params[i].fallback.is);
            const auto from = [&](int first) {
                moving.value = [=](int frame, double) { return rest + (frame >= first) * 1e-9; };
                a.node().animated = {moving};
            };
            from(4);
            const Key early = a.key(3), late = a.key(5);
            EXPECT_NE(early, late);
            from(9);
            EXPECT_EQ(a.key(3), early) << "a later keyframe changes nothing before it";
            EXPECT_NE(a.key(5), late);
        }
    });
}

TEST(KeyAudit, EveryLinkChangesTheKey)
{
    each_type([&](const NodeType& type) {
        Audited a(type);
        const Key key = a.key();
        for (std::size_t port = 0; port < type.inputs.size(); ++port) {
            SCOPED_TRACE(type.inputs[port].name);
            auto& links = a.node().inputs[port];
            const auto was = links;
            std::set<Key> seen{key};
            const auto expect_other = [&](const char* why) {
                EXPECT_TRUE(seen.insert(a.key()).second) << why;
                links = was;
            };
            links[0].output = 1;
            expect_other("another output of the same node");
            links.pop_back();
            expect_other("one link less");
            links.push_back(was[0]);
            expect_other("one link more");
            if (type.inputs[port].many) {
                std::swap(links[0], links[1]);
                expect_other("in another order");
            }
            graph::Node& source = a.graph.nodes[was[0].node];
            source.params[0] = {-1.0};
            expect_other("what it gets is another");
            source.params[0] = {double(was[0].node)};
        }
        EXPECT_EQ(a.key(), key);
    });
}

TEST(KeyAudit, TwoInputsOfOneTypeAreNotInterchangeable)
{
    each_type([&](const NodeType& type) {
        Audited a(type);
        for (std::size_t p = 0; p < type.inputs.size(); ++p) {
            for (std::size_t q = 0; q < p; ++q) {
                const Key key = a.key();
                std::swap(a.node().inputs[p], a.node().inputs[q]);
                EXPECT_NE(a.key(), key) << type.inputs[p].name << ' ' << type.inputs[q].name;
                std::swap(a.node().inputs[p], a.node().inputs[q]);
            }
        }
    });
}

TEST(KeyAudit, DeclaredVariablesChangeTheKeyAndOthersDoNot)
{
    each_type([&](const NodeType& type) {
        const auto reads = [&](graph::Variable v) {
            return (type.reads & static_cast<unsigned>(v)) != 0;
        };
        Audited a(type);
        const Key key = a.key();
        const bool gathers = static_cast<bool>(type.gather_frames);
        // What remembers motion only is the same at all frames here, where nothing moves.
        const bool steps = !type.previous.empty() && type.memory == graph::Memory::of_all_frames;
        EXPECT_EQ(a.key(6) != key, !gathers && (reads(graph::Variable::frame) || steps)) << "frame";
        // Frames and their range are counted in seconds too.
        const bool time = reads(graph::Variable::frame) || reads(graph::Variable::range);
        a.graph.range.fps = 25;
        EXPECT_EQ(a.key() != key, reads(graph::Variable::fps) || time) << "fps";
        a.graph.range.fps = 24;
        if (!gathers) {
            a.graph.range.last = 10;
            EXPECT_EQ(a.key() != key, reads(graph::Variable::range)) << "range";
            a.graph.range.last = 9;
        } else {
            a.frames = {1, 2, 3};
            EXPECT_NE(a.key(), key) << "other frames to gather";
        }
    });
}

TEST(KeyAudit, TheTypeItsVersionAndTheProgramChangeTheKey)
{
    std::set<Key> seen;
    each_type([&](const NodeType& type) {
        EXPECT_TRUE(seen.insert(Audited(type).key()).second);
        NodeType other = type;
        ++other.version;
        EXPECT_TRUE(seen.insert(Audited(other).key()).second) << "version";
        other = type;
        other.name += "x";
        EXPECT_TRUE(seen.insert(Audited(other).key()).second) << "name";
        Audited a(type);
        a.options.salt = {8, 8};
        EXPECT_TRUE(seen.insert(a.key()).second) << "program";
    });
}

TEST(KeyAudit, NamesAndPlacesOfNodesDoNotChangeTheKey)
{
    each_type([&](const NodeType& type) {
        Audited a(type);
        const Key key = a.key();
        a.node().name = "renamed", a.node().place = {"other.json", 7, 3};
        a.graph.file = "other.json";
        EXPECT_EQ(a.key(), key);
        a.options.output_folder = "/tmp/elsewhere";
        EXPECT_EQ(a.key() != key, type.sink) << "where files go is for those who write them";
    });
}

// A file counts by its bytes and its extension, wherever it lies.
TEST(KeyAudit, EveryByteOfAFileChangesTheKey)
{
    const files::Folder folder;
    std::size_t paths = 0;
    const auto write = [&](const std::string& name, const std::string& text) {
        std::ofstream(folder.path / name, std::ios::binary) << text;
        return (folder.path / name).string();
    };
    each_type([&](const NodeType& type) {
        for (std::size_t i = 0; i < type.params.size(); ++i) {
            if (type.params[i].kind != ParamKind::path_in) continue;
            ++paths;
            Audited a(type);
            const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
            a.node().params[i] = {write("a.obj", text)};
            const Key key = a.key();
            for (std::size_t byte = 0; byte < text.size(); ++byte) {
                std::string other = text;
                other[byte] ^= 1;
                write("a.obj", other);
                EXPECT_NE(a.key(), key) << "byte " << byte;
            }
            write("a.obj", text + " ");
            EXPECT_NE(a.key(), key) << "longer";
            std::filesystem::remove(folder.path / "a.obj");
            EXPECT_NE(a.key(), key) << "gone";
            a.node().params[i] = {write("b.obj", text)};
            EXPECT_EQ(a.key(), key) << "by another name it is the same";
            a.node().params[i] = {write("a.ply", text)};
            EXPECT_NE(a.key(), key) << "read as something else";
        }
    });
    EXPECT_GE(paths, 1u);
}

// A preparation depends on what it sees and on nothing else.
TEST(KeyAudit, APreparationDependsOnWhatItDeclaresOnly)
{
    std::size_t preparations = 0;
    each_type([&](const NodeType& type) {
        for (std::size_t which = 0; which < type.preparations.size(); ++which) {
            const graph::Preparation& p = type.preparations[which];
            SCOPED_TRACE(p.name);
            ++preparations;
            Audited a(type);
            const Key key = a.preparation(which);
            const auto sees = [](const std::vector<std::size_t>& all, std::size_t i) {
                return std::find(all.begin(), all.end(), i) != all.end();
            };
            for (std::size_t i = 0; i < type.params.size(); ++i) {
                SCOPED_TRACE(type.params[i].name);
                each_change(type.params[i], a.node().params[i],
                            [&] { EXPECT_EQ(a.preparation(which) != key, sees(p.params, i)); });
            }
            for (std::size_t i = 0; i < type.inputs.size(); ++i) {
                const auto was = a.node().inputs[i];
                a.node().inputs[i][0].output = 1;
                EXPECT_EQ(a.preparation(which) != key, sees(p.inputs, i)) << type.inputs[i].name;
                a.node().inputs[i] = was;
            }
        }
    });
    EXPECT_GE(preparations, 1u);
}

// What an editor keeps of its own, comments, order and notation are no part of any key.
TEST(KeyAudit, TheUiBlockAndTheNotationDoNotChangeTheKey)
{
    const auto keys_of = [](const std::string& text) {
        const graph::Loaded loaded = graph::load_text(text, "a.json", nodes::registry());
        EXPECT_TRUE(loaded.ok()) << text;
        runtime::FileDigests files;
        runtime::SideFiles side_files;
        runtime::Keys keys(loaded.graph, files, side_files, {});
        std::vector<std::uint32_t> all(loaded.graph.nodes.size());
        for (std::uint32_t n = 0; n < all.size(); ++n) all[n] = n;
        keys.aim(all, {1});
        std::map<std::string, Key> out;
        for (const std::uint32_t n : all) out[loaded.graph.nodes[n].name] = keys.at(n, 1);
        return out;
    };
    const std::string nodes = R"("b": { "type": "Primitive@1" },
        "t": { "type": "Transform@1", "inputs": { "mesh": "b.mesh" },
               "params": { "translate": [0, 1, 0] } })";
    const auto plain = keys_of(R"({ "aspic": 1, "nodes": { )" + nodes + " } }");
    EXPECT_EQ(keys_of(R"({ "nodes": { )" + nodes + R"( }, "aspic": 1,
        "ui": { "b": { "x": 10, "y": 20 }, "zoom": 2 } })"),
              plain);
    EXPECT_EQ(keys_of(R"({ "aspic": 1, "nodes": { // moves it up
        "t": { "params": { "translate": [0.0, 1e0, 0] }, "inputs": { "mesh": "b.mesh" },
               "type": "Transform@1" },
        "b": { "type": "Primitive@1", "params": {} } } })"),
              plain);
    EXPECT_NE(keys_of(R"({ "aspic": 1, "nodes": { "b": { "type": "Primitive@1" },
        "t": { "type": "Transform@1", "inputs": { "mesh": "b.mesh" },
               "params": { "translate": [0, 1, 0.001] } } } })"),
              plain);
}

}  // namespace
