// The template for Open Job Description against the rules that its specification states, which are
// written down here section by section, for the parts of it that we use. No program that checks
// templates is to be had as a package of Debian.
//
// https://github.com/OpenJobDescription/openjd-specifications/wiki/2023-09-Template-Schemas

#include "tests/runtime/said.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <functional>
#include <map>
#include <regex>
#include <set>

using namespace runtime;
using toys::has;
using toys::Said;

namespace {

using Json = nlohmann::json;

class Rules {
public:
    explicit Rules(const Json& job) { check_job(job); }
    std::vector<std::string> broken;

private:
    void require(bool holds, const std::string& place, const std::string& rule)
    {
        if (!holds) broken.push_back(place + ": " + rule);
    }
    // True if it is an object with all of the first keys, perhaps some of the second, no others.
    bool object(const Json& json, const std::string& place, const std::set<std::string>& needed,
                const std::set<std::string>& optional = {})
    {
        require(json.is_object(), place, "is an object");
        if (!json.is_object()) return false;
        bool all = true;
        for (const std::string& key : needed) {
            require(json.contains(key), place, "has " + key);
            all = all && json.contains(key);
        }
        for (const auto& [key, value] : json.items()) {
            require(needed.contains(key) || optional.contains(key), place, "knows no " + key);
        }
        return all;
    }
    bool list(const Json& json, const std::string& place, std::size_t most)
    {
        require(json.is_array() && !json.empty() && json.size() <= most, place,
                fmt::format("is a list of 1 to {}", most));
        return json.is_array();
    }
    // In characters, not bytes. `control`: of category Cc are allowed.
    void text(const Json& json, const std::string& place, std::size_t least, std::size_t most,
              bool control = false)
    {
        require(json.is_string(), place, "is a string");
        if (!json.is_string()) return;
        std::size_t length = 0;
        bool plain = true;
        for (const char c : json.get<std::string>()) {
            const auto byte = static_cast<unsigned char>(c);
            length += (byte & 0xc0) != 0x80;
            plain = plain && byte >= ' ' && byte != 0x7f;
        }
        require(length >= least && length <= most, place,
                fmt::format("has {} to {} characters", least, most));
        require(control || plain, place, "has no control characters");
    }
    // 7.3: names of values in double braces, and these are known where they stand.
    void format_string(const Json& json, const std::string& place,
                       const std::set<std::string>& known)
    {
        if (!json.is_string()) return;
        const auto s = json.get<std::string>();
        for (std::size_t at = 0; (at = s.find("{{", at)) != std::string::npos;) {
            const std::size_t end = s.find("}}", at);
            require(end != std::string::npos, place, "closes its braces");
            if (end == std::string::npos) return;
            const std::string name = s.substr(at + 2, end - at - 2);
            require(known.contains(name), place, "knows no value " + name);
            at = end;
        }
    }

    void check_job(const Json& job)  // 1.1
    {
        if (!object(job, "job", {"specificationVersion", "name", "steps"})) return;
        require(job["specificationVersion"] == "jobtemplate-2023-09", "job", "is of its version");
        text(job["name"], "job name", 1, 128);
        format_string(job["name"], "job name", {});
        if (!list(job["steps"], "steps", 1u << 20)) return;
        std::set<std::string> names;
        for (const Json& step : job["steps"]) {
            const std::string name = step.value("name", "");
            require(names.insert(name).second, name, "is the name of one step");
        }
        std::set<std::string> before;
        for (const Json& step : job["steps"]) {
            check_step(step, names);
            // 3.2, and no step waits for itself, over whatever ways: here each names earlier ones.
            for (const Json& d : step.value("dependencies", Json::array())) {
                require(before.contains(d.value("dependsOn", "")), step.value("name", ""),
                        "waits for a step before it");
            }
            before.insert(step.value("name", ""));
        }
    }
    void check_step(const Json& step, const std::set<std::string>& names)  // 3
    {
        const std::string place = step.value("name", "");
        if (!object(step, place, {"name", "script"},
                    {"dependencies", "hostRequirements", "parameterSpace"}))
            return;
        text(step["name"], place, 1, 64);
        if (step.contains("dependencies") && list(step["dependencies"], place, 1u << 20)) {
            std::set<std::string> once;
            for (const Json& d : step["dependencies"]) {
                if (!object(d, place + " dependency", {"dependsOn"})) continue;
                require(names.contains(d["dependsOn"]), place, "waits for a step of this job");
                require(once.insert(d["dependsOn"]).second, place, "waits for each once");
            }
        }
        if (step.contains("hostRequirements")) check_host(step["hostRequirements"], place);
        std::set<std::string> values;
        if (step.contains("parameterSpace")) {
            check_space(step["parameterSpace"], place + " parameters", values);
        }
        check_script(step["script"], place + " script", values);
    }
    void check_host(const Json& host, const std::string& place)  // 3.3
    {
        if (!object(host, place + " host", {"amounts"})) return;
        if (!list(host["amounts"], place + " amounts", 50)) return;
        static const std::regex name(R"(([A-Za-z_]\w*:)?amount(\.[A-Za-z_]\w*)+)");
        std::set<std::string> once;
        for (const Json& amount : host["amounts"]) {
            if (!object(amount, place + " amount", {"name", "min"})) continue;
            text(amount["name"], place + " amount", 1, 100);
            require(std::regex_match(amount["name"].get<std::string>(), name), place,
                    "asks for an amount by its name");
            require(once.insert(amount["name"]).second, place, "asks for each amount once");
            const double least = amount["name"] == "amount.worker.vcpu" ? 1 : 0;
            require(amount["min"].is_number() && amount["min"] >= least, place,
                    "asks for no less than there may be");
        }
    }
    void check_space(const Json& space, const std::string& place,
                     std::set<std::string>& values)  // 3.4
    {
        if (!object(space, place, {"taskParameterDefinitions"}, {"combination"})) return;
        if (!list(space["taskParameterDefinitions"], place, 16)) return;
        static const std::regex identifier(R"([A-Za-z_][A-Za-z0-9_]{0,63})");
        std::vector<std::string> names;
        std::set<std::size_t> sizes;
        for (const Json& p : space["taskParameterDefinitions"]) {
            if (!object(p, place, {"name", "type", "range"})) continue;
            require(std::regex_match(p["name"].get<std::string>(), identifier), place, "has names");
            require(p["type"] == "STRING", place, "is of strings");
            if (!list(p["range"], place, 1024)) continue;
            for (const Json& value : p["range"]) {
                text(value, place + " value", 1, 1024, true);
                format_string(value, place + " value", {});
            }
            names.push_back(p["name"]);
            sizes.insert(p["range"].size());
            values.insert("Task.Param." + names.back());
        }
        require(values.size() == names.size(), place, "has each name once");
        if (!space.contains("combination")) return;
        // 3.4.3: what is associated has the same number of values.
        require(space["combination"] == "(" + fmt::format("{}", fmt::join(names, ", ")) + ")",
                place, "names each parameter once");
        require(sizes.size() == 1, place, "has as many values of each");
    }
    void check_script(const Json& script, const std::string& place,
                      const std::set<std::string>& values)  // 3.5, 5
    {
        if (!object(script, place, {"actions"})) return;
        if (!object(script["actions"], place, {"onRun"})) return;
        const Json& action = script["actions"]["onRun"];
        if (!object(action, place, {"command"}, {"args"})) return;
        text(action["command"], place + " command", 1, 1u << 20);
        format_string(action["command"], place + " command", values);
        for (const Json& arg : action.value("args", Json::array())) {
            text(arg, place + " argument", 0, 1u << 20);
            format_string(arg, place + " argument", values);
        }
    }
};

// A simulation, and a file a frame of what is made from it.
std::string counting_to(int last)
{
    return R"({ "aspic": 1, "frames": { "first": 1, "last": )" + std::to_string(last) + R"( },
  "nodes": {
    "clock": { "type": "Clock@1" },
    "sim": { "type": "Accumulate@1", "inputs": { "value": "clock.value" },
             "params": { "seconds": 0.003 } },
    "write": { "type": "WriteNumber@1", "inputs": { "value": "sim.value" } } } })";
}

class FarmOpenjd : public testing::Test {
protected:
    Said farm(const std::string& name, const std::string& text, std::vector<std::string> more)
    {
        const std::string file = folder_.write(name, text).string();
        std::vector<std::string> args{"farm",   file,      "--engine",
                                      "openjd", "--cache", (folder_.path / "cache").string()};
        if (std::find(more.begin(), more.end(), "--out") == more.end()) {
            more.insert(more.end(), {"--out", (folder_.path / "out").string()});
        }
        args.insert(args.end(), more.begin(), more.end());
        std::ostringstream out, err;
        Console console{out, err, false, {}, {}, "1.2.3"};
        console.program = "/opt/aspic";
        const int exit = run_command_line(args, toys::registry(), console);
        return {exit, out.str(), err.str()};
    }
    Said farm(const std::string& name, int last, const std::vector<std::string>& more)
    {
        return farm(name, counting_to(last), more);
    }
    Json job_of(const std::string& name, const std::string& text,
                const std::vector<std::string>& more)
    {
        const Said said = farm(name, text, more);
        EXPECT_EQ(said.exit, exit_ok) << said.err;
        return Json::parse(toys::bytes_of(folder_.path / "out/farm/job.template.json"));
    }
    Json job(const std::string& name, int last, const std::vector<std::string>& more)
    {
        return job_of(name, counting_to(last), more);
    }

    toys::Folder folder_;
};

const std::vector<std::string> none_broken;

// The text with what a task gives for its parameters.
std::string filled(std::string text, const std::map<std::string, std::string>& parameters)
{
    for (const auto& [name, value] : parameters) {
        const std::string reference = "{{Task.Param." + name + "}}";
        for (std::size_t at = 0; (at = text.find(reference, at)) != std::string::npos;) {
            text.replace(at, reference.size(), value);
            at += value.size();
        }
    }
    return text;
}

// What a worker does of a template, but for the name of the program: each task of each step. Of the
// steps that may begin, the one that stands last goes first, and in it the last task: nothing but
// the dependencies keeps an order. Returns the commands.
std::vector<std::vector<std::string>> commands_of(const Json& job)
{
    std::vector<std::vector<std::string>> commands;
    std::set<std::string> done;
    const auto ready = [&](const Json& step) {
        for (const Json& d : step.value("dependencies", Json::array())) {
            if (!done.contains(d["dependsOn"])) return false;
        }
        return !done.contains(step["name"]);
    };
    for (auto next = job["steps"].rbegin(); next != job["steps"].rend();) {
        if (!ready(*next)) {
            ++next;
            continue;
        }
        const Json& step = *next;
        std::vector<std::map<std::string, std::string>> tasks(1);
        if (step.contains("parameterSpace")) {
            const Json& parameters = step["parameterSpace"]["taskParameterDefinitions"];
            tasks.resize(parameters[0]["range"].size());
            for (const Json& p : parameters) {
                for (std::size_t t = 0; t < tasks.size(); ++t) tasks[t][p["name"]] = p["range"][t];
            }
        }
        const Json& run = step["script"]["actions"]["onRun"];
        for (auto task = tasks.rbegin(); task != tasks.rend(); ++task) {
            commands.push_back({filled(run["command"], *task)});
            for (const Json& arg : run["args"]) commands.back().push_back(filled(arg, *task));
        }
        done.insert(step["name"]);
        next = job["steps"].rbegin();
    }
    EXPECT_EQ(done.size(), job["steps"].size());
    return commands;
}

}  // namespace

TEST_F(FarmOpenjd, ATemplateKeepsTheRulesOfTheSpecification)
{
    const Json one = job("one.json", 12, {"--task-seconds", "4", "--threads", "2"});
    EXPECT_EQ(Rules(one).broken, none_broken);
    EXPECT_EQ(one["steps"].size(), 3u);
    const Json sweep = job("sweep.json", 8, {"--task-seconds", "2", "--vary", "sim.start=1,2,3,4"});
    EXPECT_EQ(Rules(sweep).broken, none_broken);
    EXPECT_GT(sweep["steps"].size(), 8u);
    // More tasks than a parameter may have values.
    const Json many = job("many.json", 2500, {"--task-seconds", "1"});
    EXPECT_EQ(Rules(many).broken, none_broken);
    EXPECT_EQ(many["steps"].size(), 5u) << "the simulation, 1,000 + 1,000 + 500 frames, the last";
}

TEST_F(FarmOpenjd, WhatATemplateRunsWritesTheBytesOfPlainCooks)
{
    for (const bool varied : {false, true}) {
        std::vector<std::string> asked{"--task-seconds", "4"};
        if (varied) asked.insert(asked.end(), {"--vary", "sim.start=1,2"});
        const Json json = job("one.json", 12, asked);
        const auto commands = commands_of(json);
        EXPECT_EQ(commands.size(), varied ? 11u : 5u);
        toys::take_runs("Accumulate");
        toys::take_runs("WriteNumber");
        for (const std::vector<std::string>& words : commands) {
            EXPECT_EQ(words[0], "/opt/aspic");
            const Said said = toys::run({words.begin() + 1, words.end()});
            EXPECT_EQ(said.exit, exit_ok) << said.err;
            EXPECT_TRUE(has(said.out, "openjd_progress: 100")) << said.out;
        }
        EXPECT_EQ(toys::take_runs("Accumulate"), varied ? 24 : 12) << "each result once";
        EXPECT_EQ(toys::take_runs("WriteNumber"), varied ? 24 : 12);
        const auto file = (folder_.path / "one.json").string();
        for (int i = 0; i < (varied ? 2 : 1); ++i) {
            const std::string number = std::to_string(i + 1);
            const auto out = folder_.path / (varied ? "out/00" + number : "out");
            const auto plain = folder_.path / ("plain" + number);
            std::vector<std::string> cook{"cook", file, "--out", plain.string()};
            if (varied) cook.insert(cook.end(), {"--set", "sim.start=" + number});
            ASSERT_EQ(toys::run(cook).exit, exit_ok);
            for (int f = 1; f <= 12; ++f) {
                const std::string name = std::to_string(f) + "number.txt";
                EXPECT_EQ(toys::bytes_of(out / name), toys::bytes_of(plain / name)) << out << name;
            }
        }
        const Said status =
            toys::run({"farm", "status", file, "--out", (folder_.path / "out").string()});
        EXPECT_EQ(status.exit, exit_ok) << status.out << status.err;
        EXPECT_TRUE(has(status.out,
                        varied ? "verified: 25 files of 2 cooks" : "verified: 12 files of 1 cook"))
            << status.out;
        std::filesystem::remove_all(folder_.path / "out");
        std::filesystem::remove_all(folder_.path / "cache");
    }
}

// A scheduler runs nothing that waits for what failed.
TEST_F(FarmOpenjd, ASettingThatMissesAnExpectationFailsTheTableThatNamesItAndNoOtherTask)
{
    std::string text = counting_to(3);
    text.insert(text.rfind('}'),
                R"(, "expect": [ { "value": "sim.value", "frame": 3, "max": 135 } ])");
    const auto commands = commands_of(
        job_of("one.json", text, {"--task-seconds", "100", "--vary", "sim.start=1,2,9"}));
    ASSERT_EQ(commands.size(), 4u);
    for (const std::vector<std::string>& words : commands) {
        const Said said = toys::run({words.begin() + 1, words.end()});
        const bool table = words[1] == "sweep";
        EXPECT_EQ(said.exit, table ? exit_missed : exit_ok) << said.out << said.err;
        EXPECT_EQ(has(said.out, "openjd_fail: expectations were missed by the setting 003 ("),
                  table)
            << said.out;
    }
    const std::string table = toys::bytes_of(folder_.path / "out/sweep.csv");
    EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 4) << table;
    const Said status = toys::run({"farm", "status", (folder_.path / "one.json").string(), "--out",
                                   (folder_.path / "out").string()});
    EXPECT_EQ(status.exit, exit_missed) << status.out << status.err;
    EXPECT_TRUE(has(status.out, "4 of 4 tasks are done")) << status.out;
    EXPECT_TRUE(has(status.err, "missed: one-003, ")) << status.err;
    EXPECT_FALSE(has(status.err, "missed: one-001, ")) << status.err;
}

TEST_F(FarmOpenjd, LongAndStrangeNamesKeepTheRulesToo)
{
    std::string umlauts;
    for (int i = 0; i < 100; ++i) umlauts += "\xc3\xa4";
    for (const std::string& name : {std::string(200, 'n'), umlauts, std::string("{}}")}) {
        const Json json = job(name + ".json", 3, {"--task-seconds", "100"});
        EXPECT_EQ(Rules(json).broken, none_broken) << name;
    }
}

TEST_F(FarmOpenjd, FramesThatLieScatteredAreArguments)
{
    // 2, 4, 7, 11 and so on, in each task 250 frames: a text longer than a value may be.
    std::string frames;
    for (int i = 1, f = 1; i <= 500; f += ++i) frames += (i > 1 ? "," : "") + std::to_string(f);
    const Json json = job("far.json", 126000, {"--task-seconds", "250", "--frames", frames});
    EXPECT_EQ(Rules(json).broken, none_broken);
    EXPECT_EQ(json["steps"].size(), 4u) << "the simulation, two of frames, the last";
}

TEST_F(FarmOpenjd, WhatATemplateCannotSayIsRefused)
{
    const Said braces =
        farm("a.json", 3, {"--out", (folder_.path / "take {{Param.Take}}").string()});
    EXPECT_EQ(braces.exit, exit_usage);
    EXPECT_TRUE(has(braces.err, "neither '{{' nor control characters, found '")) << braces.err;
    EXPECT_EQ(farm("two\nlines.json", 3, {}).exit, exit_usage);
}

// Each rule notices a template that breaks it.
TEST_F(FarmOpenjd, TheRulesNotice)
{
    const Json good = job("one.json", 12, {"--task-seconds", "4", "--threads", "2"});
    const std::vector<std::function<void(Json&)>> breaks{
        [](Json& j) { j["specificationVersion"] = "jobtemplate-2024-01"; },
        [](Json& j) { j["name"] = std::string(129, 'x'); },
        [](Json& j) { j["name"] = "{{Task.Param.Task}}"; },
        [](Json& j) { j["note"] = 1; },
        [](Json& j) { j["steps"] = Json::array(); },
        [](Json& j) { j["steps"][0]["name"] = j["steps"][1]["name"]; },
        [](Json& j) { j["steps"][0]["name"] = std::string(65, 'x'); },
        [](Json& j) { j["steps"][1]["dependencies"] = Json::array(); },
        [](Json& j) { j["steps"][1]["dependencies"][0]["dependsOn"] = "none"; },
        [](Json& j) {
            j["steps"][0]["dependencies"] = {{{"dependsOn", j["steps"][2]["name"]}}};
        },
        [](Json& j) { j["steps"][1]["hostRequirements"]["amounts"][0]["min"] = 0; },
        [](Json& j) { j["steps"][1]["hostRequirements"]["amounts"][0]["name"] = "cores"; },
        [](Json& j) { j["steps"][1]["parameterSpace"]["combination"] = "(Task)"; },
        [](Json& j) {
            Json& p = j["steps"][1]["parameterSpace"]["taskParameterDefinitions"];
            p[0]["range"].push_back("one more");
        },
        [](Json& j) {
            Json& p = j["steps"][1]["parameterSpace"]["taskParameterDefinitions"];
            p[0]["range"] = p[1]["range"] = Json(std::vector<std::string>(1025, "1"));
        },
        [](Json& j) {
            Json& p = j["steps"][1]["parameterSpace"]["taskParameterDefinitions"];
            p[1]["range"][0] = "";
        },
        [](Json& j) { j["steps"][0]["script"]["actions"]["onRun"]["args"][0] = "{{Param.X}}"; },
        [](Json& j) { j["steps"][0]["script"]["actions"]["onRun"]["args"][0] = 1; },
        [](Json& j) { j["steps"][0]["script"]["actions"]["onRun"]["command"] = ""; },
        [](Json& j) { j["steps"][0]["script"]["actions"].erase("onRun"); },
    };
    for (std::size_t i = 0; i < breaks.size(); ++i) {
        Json bad = good;
        breaks[i](bad);
        EXPECT_FALSE(Rules(bad).broken.empty()) << "break " << i;
    }
}
