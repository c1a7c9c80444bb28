#include "runtime/commands/verify.hpp"

#include "runtime/cache/quantities.hpp"
#include "runtime/commands/manifest.hpp"
#include "runtime/commands/text_file.hpp"
#include "tests/runtime/said.hpp"

#include <gtest/gtest.h>

using namespace runtime;
using toys::has;
using toys::run;
using toys::Said;
using toys::three_frames;

namespace {

class Verified : public testing::Test {
protected:
    void SetUp() override
    {
        file_ = folder_.write("three.json", three_frames).string();
        cook({});
    }
    void cook(std::vector<std::string> more)
    {
        std::vector<std::string> args{"cook", file_, "--out", (folder_.path / "out").string()};
        args.insert(args.end(), more.begin(), more.end());
        const Said said = run(args);
        ASSERT_EQ(said.exit, exit_ok) << said.err;
    }
    Said verify(std::vector<std::string> more = {})
    {
        std::vector<std::string> args{"verify", path().string()};
        args.insert(args.end(), more.begin(), more.end());
        return run(args);
    }
    std::filesystem::path path() const { return folder_.path / "out" / manifest_name; }

    toys::Folder folder_;
    std::string file_;
};

}  // namespace

TEST_F(Verified, ACookComesOutTheSameAgain)
{
    toys::take_runs("WriteNumber");
    const Said said = verify();
    EXPECT_EQ(said.exit, exit_ok) << said.out << said.err;
    EXPECT_TRUE(has(said.out, "all 3 outputs are the same")) << said.out;
    EXPECT_EQ(toys::take_runs("WriteNumber"), 3) << "it did cook";
}

TEST_F(Verified, AManifestNamesDocumentsNodesAndOutputs)
{
    const Manifest m = read_manifest(path());
    EXPECT_EQ(m.version, "1.2.3");
    EXPECT_EQ(m.frames, "1-3");
    EXPECT_TRUE(m.complete);
    ASSERT_EQ(m.documents.size(), 1u);
    EXPECT_EQ(m.documents[0].path, file_);
    EXPECT_EQ(m.nodes.size(), 3u);
    EXPECT_EQ(m.nodes.at("sum").params.at("bias"), "10");
    EXPECT_EQ(m.nodes.at("sum").inputs.at("values"), "clock.value");
    ASSERT_EQ(m.outputs.size(), 3u);
    for (const Manifest::Output& o : m.outputs) {
        FileDigests digests;
        EXPECT_EQ(o.file.digest, to_hex(digests.of(path().parent_path() / o.file.path)));
    }
    EXPECT_EQ(to_text(read_manifest(path())), to_text(m)) << "and reads back as it was written";
}

TEST_F(Verified, TheSameCookLeavesTheSameManifestBesidesItsTimes)
{
    Manifest first = read_manifest(path());
    cook({});
    Manifest again = read_manifest(path());
    for (Manifest* m : {&first, &again}) {
        for (auto& [name, node] : m->nodes) node.seconds = 0;
        EXPECT_TRUE(m->ran);
        m->ran = {};
    }
    EXPECT_EQ(to_text(first), to_text(again));
}

TEST_F(Verified, AFileThatAllFramesShareIsTheOneThatTheCookLeft)
{
    // Not what it was after each frame; and every cook writes it again, as none can tell whether
    // its frame is still in it.
    file_ = folder_.write("row.json", R"({ "aspic": 1, "frames": { "first": 1, "last": 5 },
        "nodes": { "clock": { "type": "Clock@1" },
                   "row": { "type": "WriteRow@1", "inputs": { "value": "clock.value" } } } })");
    cook({});
    for (const Manifest::Output& o : read_manifest(path()).outputs) {
        FileDigests digests;
        EXPECT_EQ(o.file.digest, to_hex(digests.of(folder_.path / "out/number.txt")));
    }
    const Said said = verify();
    EXPECT_EQ(said.exit, exit_ok) << said.out << said.err;
    toys::take_runs("WriteRow");
    cook({});
    EXPECT_EQ(toys::take_runs("WriteRow"), 5);
}

// The file also holds the frames of the cook before, which a cook of frame 3 does not make again.
TEST_F(Verified, AFileThatFramesShareIsNotComparedWhereOnlySomeWereCooked)
{
    file_ = folder_.write("row.json", R"({ "aspic": 1, "frames": { "first": 1, "last": 5 },
        "nodes": { "clock": { "type": "Clock@1" },
                   "write": { "type": "WriteNumber@1", "inputs": { "value": "clock.value" },
                              "params": { "path": ".txt" } },
                   "row": { "type": "WriteRow@1", "inputs": { "value": "clock.value" } } } })");
    cook({});
    cook({"--frames", "3-4"});
    const Manifest m = read_manifest(path());
    ASSERT_EQ(m.outputs.size(), 4u);
    for (const Manifest::Output& o : m.outputs) EXPECT_EQ(o.file.digest.empty(), o.node == "row");
    const Said said = verify();
    EXPECT_EQ(said.exit, exit_ok) << said.out << said.err;
    EXPECT_TRUE(has(said.out, "not compared: number.txt holds all frames, of which the cook wrote "
                              "3-4\n"))
        << said.out;
    EXPECT_TRUE(has(said.out, "all 2 outputs compared are the same")) << said.out;
    std::filesystem::remove(folder_.path / "out/number.txt");
    const Said gone = verify();
    EXPECT_EQ(gone.exit, exit_failed);
    EXPECT_TRUE(has(gone.out, "number.txt was removed after the cook")) << gone.out;
}

TEST_F(Verified, AChangedOutputFileIsReported)
{
    folder_.write("out/2number.txt", "someone else's");
    const Said said = verify();
    EXPECT_EQ(said.exit, exit_failed);
    EXPECT_TRUE(has(said.out, "2number.txt was changed after the cook")) << said.out;
    std::filesystem::remove(folder_.path / "out/2number.txt");
    EXPECT_TRUE(has(verify().out, "2number.txt was removed after the cook"));
}

TEST_F(Verified, NothingOutsideTheManifestsFolderIsRead)
{
    const auto outside = folder_.write("outside.txt", "11");
    std::filesystem::create_symlink("../outside.txt", folder_.path / "out/link.txt");
    Manifest m = read_manifest(path());
    FileDigests digests;
    for (const char* name : {"../outside.txt", "link.txt", outside.c_str()}) {
        Manifest changed = m;
        changed.outputs[0].file = {name, to_hex(digests.of(outside))};
        std::ofstream(path()) << to_text(changed);
        const Said said = verify();
        EXPECT_EQ(said.exit, exit_failed) << name;
        EXPECT_TRUE(has(said.out, "is outside the manifest's folder and was not read")) << said.out;
    }
}

TEST_F(Verified, ANodeThatWritesOutsideIsLeftOut)
{
    const auto outside = folder_.path / "row.txt";
    for (const std::string& name : {std::string("../row.txt"), outside.string()}) {
        file_ = folder_.write("row.json", R"({ "aspic": 1, "frames": { "first": 1, "last": 3 },
            "nodes": { "clock": { "type": "Clock@1" },
                       "write": { "type": "WriteNumber@1", "inputs": { "value": "clock.value" } },
                       "row": { "type": "WriteRow@1", "inputs": { "value": "clock.value" },
                                "params": { "path": ")" +
                                              name + R"(" } } } })");
        cook({"--allow-outside"});
        std::ofstream(outside) << "edited";
        const auto said_of = [&](const char* outputs) {
            const Said said = verify({"--allow-outside"});
            EXPECT_EQ(said.exit, exit_ok) << said.out << said.err;
            EXPECT_TRUE(has(said.out, "not compared: 'row' writes outside the output folder\n"))
                << said.out;
            EXPECT_TRUE(has(said.out, outputs)) << said.out;
            EXPECT_EQ(read_text(outside), "edited");
        };
        said_of("all 3 outputs compared are the same");
        cook({"--allow-outside", "--node", "row"});
        std::ofstream(outside) << "edited";
        said_of("all 0 outputs compared are the same");
    }
}

TEST_F(Verified, AnOutputThatComesOutDifferentlyIsNamed)
{
    folder_.write("three.json", [] {
        std::string text = three_frames;
        text.replace(text.find("\"bias\": 10"), 10, "\"bias\": 11");
        text.replace(text.find("\"min\": 11, \"max\": 11"), 20, "\"min\": 0, \"max\": 99");
        return text;
    }());
    const Said said = verify();
    EXPECT_EQ(said.exit, exit_failed);
    EXPECT_TRUE(has(said.out, "changed since the cook: " + file_)) << said.out;
    EXPECT_TRUE(has(said.out, "write, frame 3: 3number.txt differs")) << said.out;
    EXPECT_TRUE(has(said.out, "3 of 3 outputs differ")) << said.out;
}

TEST_F(Verified, AHiddenDependenceIsFound)
{
    toys::hidden() = 1;
    folder_.write("three.json", R"({ "aspic": 1, "nodes": { "h": { "type": "Hidden@1" } } })");
    cook({});
    EXPECT_EQ(verify().exit, exit_ok);
    toys::hidden() = 2;
    const Said said = verify();
    toys::hidden() = 1;
    EXPECT_EQ(said.exit, exit_failed);
    EXPECT_TRUE(has(said.out, "h.value, frame 1 differs")) << said.out;
}

TEST_F(Verified, TheSettingsOfTheCookAreThoseOfTheCheck)
{
    cook({"--set", "write.path=other.txt", "--frames", "1,3"});
    const Said said = verify();
    EXPECT_EQ(said.exit, exit_ok) << said.out << said.err;
    EXPECT_TRUE(has(said.out, "all 2 outputs are the same")) << said.out;
    EXPECT_TRUE(read_manifest(path()).outputs[1].file.path == "3other.txt");
}

// It may come from a stranger: what it was allowed has to be allowed again.
TEST_F(Verified, AManifestGrantsNoPermissions)
{
    Manifest m = read_manifest(path());
    m.allow_outside = true;
    folder_.write("out/manifest.json", to_text(m));
    EXPECT_EQ(verify().exit, exit_usage);
    EXPECT_TRUE(has(verify().err, "--allow-outside")) << verify().err;
    EXPECT_EQ(verify({"--allow-outside"}).exit, exit_ok);
    m.allow_outside = false, m.root = "/";
    folder_.write("out/manifest.json", to_text(m));
    EXPECT_EQ(verify().exit, exit_usage);
    EXPECT_EQ(verify({"--root", folder_.path.string()}).exit, exit_ok);
}

TEST_F(Verified, AFileThatIsNoManifestIsRefused)
{
    for (const char* text : {"", "[]", "{}", "{\"aspic_manifest\": 2}", "{\"aspic_manifest\": 1}",
                             "{\"aspic_manifest\": 1, \"program\": 3}", "nonsense"}) {
        folder_.write("out/manifest.json", text);
        EXPECT_EQ(verify().exit, exit_usage) << text;
        EXPECT_TRUE(has(verify().err, "expected a manifest")) << verify().err;
    }
    EXPECT_EQ(run({"verify", file_}).exit, exit_usage);
    EXPECT_EQ(run({"verify", (folder_.path / "none").string()}).exit, exit_usage);
    const std::string whole = [&] {
        std::filesystem::remove(path());
        cook({});
        std::ifstream in(path());
        return std::string(std::istreambuf_iterator<char>(in), {});
    }();
    for (std::size_t cut = 0; cut + 2 < whole.size(); cut += 37) {
        folder_.write("out/manifest.json", whole.substr(0, cut));
        EXPECT_EQ(verify().exit, exit_usage) << cut;
    }
}

TEST(Frames, AreWrittenAsTheyAreRead)
{
    for (const char* text : {"", "3", "1-4", "1-4,6,9-10", "-3--1"}) {
        const std::vector<int> frames = *text ? parse_frames(text) : std::vector<int>{};
        EXPECT_EQ(frames_text(frames), text);
    }
}

// The manifest names what the cook began with.
TEST_F(Verified, AFileThatChangesDuringACookIsReported)
{
    const std::string number = folder_.write("number.txt", "7").string();
    file_ = folder_
                .write("reads.json", R"({ "aspic": 1, "frames": { "first": 1, "last": 1 },
        "nodes": { "read": { "type": "ReadNumber@1", "params": { "path": "number.txt" } },
                   "edit": { "type": "Rewrites@1", "inputs": { "value": "read.value" },
                             "params": { "path": ")" +
                                         number + R"(" } },
                   "write": { "type": "WriteNumber@1", "inputs": { "value": "edit.value" } } } })")
                .string();
    cook({});
    const Said said = verify();
    EXPECT_EQ(said.exit, exit_failed);
    EXPECT_TRUE(has(said.out, "changed since the cook: " + number)) << said.out;
}
