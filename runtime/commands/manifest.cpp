#include "runtime/commands/manifest.hpp"

#include "graph/tools/difference.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <fstream>
#include <set>
#include <sys/resource.h>
#include <unistd.h>

namespace runtime {

namespace {

using Json = nlohmann::ordered_json;

Json to_json(const Manifest::File& file)
{
    return {{"path", file.path}, {"digest", file.digest}};
}
Manifest::File file_from(const Json& json)
{
    return {json.at("path").get<std::string>(), json.at("digest").get<std::string>()};
}

Json to_json(const std::vector<Manifest::File>& files)
{
    Json all = Json::array();
    for (const Manifest::File& file : files) all.push_back(to_json(file));
    return all;
}
std::vector<Manifest::File> files_from(const Json& json)
{
    std::vector<Manifest::File> files;
    for (const Json& file : json) files.push_back(file_from(file));
    return files;
}

Json to_json(const Manifest::Node& node)
{
    Json json{{"type", node.type}, {"key", node.key}};
    if (!node.inputs.empty()) json["inputs"] = node.inputs;
    if (!node.params.empty()) json["params"] = node.params;
    for (const auto& [param, file] : node.files) json["files"][param] = to_json(file);
    if (!node.side_files.empty()) json["side_files"] = to_json(node.side_files);
    if (node.seconds > 0) json["seconds"] = node.seconds;
    return json;
}
Manifest::Node node_from(const Json& json)
{
    Manifest::Node node;
    node.type = json.at("type").get<std::string>();
    node.key = json.at("key").get<std::string>();
    node.inputs = json.value("inputs", node.inputs);
    node.params = json.value("params", node.params);
    if (json.contains("files")) {
        for (const auto& [param, file] : json["files"].items()) node.files[param] = file_from(file);
    }
    if (json.contains("side_files")) node.side_files = files_from(json["side_files"]);
    node.seconds = json.value("seconds", 0.0);
    return node;
}

Json to_json(const Manifest::Output& output)
{
    Json json{{"node", output.node}, {"frame", output.frame}};
    json[output.port.empty() ? "path" : "port"] =
        output.port.empty() ? output.file.path : output.port;
    json["digest"] = output.file.digest;
    return json;
}
Manifest::Output output_from(const Json& json)
{
    return {json.at("node").get<std::string>(),
            json.value("port", ""),
            json.at("frame").get<int>(),
            {json.value("path", ""), json.at("digest").get<std::string>()}};
}

Manifest::File digested(const std::filesystem::path& path, FileDigests& digests)
{
    return {path.string(), to_hex(digests.of(path))};
}

}  // namespace

void describe_graph(const graph::Graph& graph, Keys& keys, const std::vector<int>& frames,
                    FileDigests& digests, Manifest& manifest)
{
    manifest.range = graph.range;
    for (const auto& path : graph.documents) {
        manifest.documents.push_back(digested(path, digests));
    }
    std::unordered_map<std::uint32_t, KeyBuilder> varying;
    for (const std::uint32_t n : keys.reached()) {
        if (keys.varies(n)) varying[n];
    }
    for (const int frame : frames) {
        for (auto& [n, builder] : varying) builder.add(keys.at(n, frame));
    }
    for (const std::uint32_t n : keys.reached()) {
        const graph::Node& source = graph.nodes[n];
        Manifest::Node& node = manifest.nodes[source.name];
        node.type = fmt::format("{}@{}", source.type->name, source.type->version);
        node.key = to_hex(keys.varies(n) ? varying.at(n).key() : keys.at(n, frames.front()));
        node.params = graph::values_of(source);
        node.inputs = graph::links_of(graph, source);
        for (const auto& [param, path] : graph::files_of(source)) {
            node.files[param] = digested(path, digests);
        }
        std::set<std::filesystem::path> more;
        for (const int frame : keys.varies(n) ? std::span(frames) : std::span(frames).first(1)) {
            for (auto& path : keys.side_files(n, frame)) more.insert(std::move(path));
            for (auto& path : graph::files_at(source, frame)) more.insert(std::move(path));
        }
        for (const auto& path : more) {
            if (SideFiles::refused(path, graph.root)) continue;  // it was not read
            node.side_files.push_back(digested(path, digests));
        }
    }
}

std::string to_text(const Manifest& m)
{
    Json json;
    json["aspic_manifest"] = 1;
    json["doc"] = "What went into a cook and what came out. `aspic verify` with this file cooks it "
                  "again and compares.";
    json["program"] = {{"version", m.version}, {"identity", m.program}};
    json["documents"] = to_json(m.documents);
    json["settings"] = {{"frames", m.frames}, {"set", m.sets},  {"var", m.variables},
                        {"node", m.only},     {"root", m.root}, {"allow_outside", m.allow_outside}};
    if (m.range) {
        json["range"] = {{"first", m.range->first}, {"last", m.range->last}, {"fps", m.range->fps}};
    }
    json["complete"] = m.complete;
    if (!m.missed.empty()) json["missed"] = m.missed;
    if (m.ran) {
        json["ran"] = {{"machine", m.ran->machine},
                       {"seconds", m.ran->seconds},
                       {"memory", m.ran->memory},
                       {"cores", m.ran->cores}};
    }
    for (const AccuracyCard& card : m.cards) json["accuracy"].push_back(card_json(card));
    json["nodes"] = Json::object();
    for (const auto& [name, node] : m.nodes) json["nodes"][name] = to_json(node);
    json["outputs"] = Json::array();
    for (const Manifest::Output& output : m.outputs) json["outputs"].push_back(to_json(output));
    return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

bool is_manifest(const std::filesystem::path& path)
{
    const std::string mark = "\"aspic_manifest\"";
    std::ifstream in(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    return text.find(mark) != text.npos;
}

Manifest read_manifest(const std::filesystem::path& path)
{
    std::ifstream in(path, std::ios::binary);
    if (!in) {
        throw std::invalid_argument(
            fmt::format("{}: can't be read; expected the {} that a cook leaves beside its files",
                        path.string(), manifest_name));
    }
    try {
        const Json json = Json::parse(in);
        if (!json.is_object() || json.value("aspic_manifest", 0) != 1) {
            throw std::runtime_error("it has no \"aspic_manifest\": 1");
        }
        Manifest m;
        m.version = json.at("program").at("version").get<std::string>();
        m.program = json.at("program").at("identity").get<std::string>();
        m.documents = files_from(json.at("documents"));
        const Json& settings = json.at("settings");
        m.frames = settings.at("frames").get<std::string>();
        m.sets = settings.at("set").get<std::vector<std::string>>();
        m.variables = settings.at("var").get<std::vector<std::string>>();
        m.only = settings.at("node").get<std::vector<std::string>>();
        m.root = settings.at("root").get<std::string>();
        m.allow_outside = settings.at("allow_outside").get<bool>();
        m.complete = json.at("complete").get<bool>();
        m.missed = json.value("missed", m.missed);
        if (json.contains("range")) {
            const Json& range = json["range"];
            m.range = {range.at("first").get<int>(), range.at("last").get<int>(),
                       range.at("fps").get<double>()};
        }
        if (json.contains("ran")) {
            const Json& ran = json["ran"];
            m.ran = {ran.at("machine").get<std::string>(), ran.at("seconds").get<double>(),
                     ran.at("memory").get<std::uint64_t>(), ran.at("cores").get<double>()};
        }
        for (const auto& [name, node] : json.at("nodes").items()) m.nodes[name] = node_from(node);
        for (const Json& output : json.at("outputs")) m.outputs.push_back(output_from(output));
        if (m.documents.empty()) throw std::runtime_error("it names no document");
        return m;
    } catch (const Json::exception&) {
        throw std::invalid_argument(
            fmt::format("{}: expected a {} that a cook wrote", path.string(), manifest_name));
    } catch (const std::exception& e) {
        throw std::invalid_argument(fmt::format("{}: expected a {} that a cook wrote: {}",
                                                path.string(), manifest_name, e.what()));
    }
}

std::string frames_text(const std::vector<int>& frames)
{
    std::string text;
    for (std::size_t i = 0; i < frames.size();) {
        std::size_t end = i + 1;
        while (end < frames.size() && frames[end] == frames[end - 1] + 1) ++end;
        if (!text.empty()) text += ',';
        text += std::to_string(frames[i]);
        if (end - i > 1) text += '-' + std::to_string(frames[end - 1]);
        i = end;
    }
    return text;
}

std::vector<std::string> changes(const Manifest::Node& was, const Manifest::Node& is)
{
    std::vector<std::string> lines;
    if (was.type != is.type) lines.push_back(fmt::format("type is {}, was {}", is.type, was.type));
    const auto compare = [&](const char* what, const graph::Texts& a, const graph::Texts& b) {
        std::set<std::string> names;
        for (const auto& entry : a) names.insert(entry.first);
        for (const auto& entry : b) names.insert(entry.first);
        for (const std::string& name : names) {
            const auto old = a.find(name), now = b.find(name);
            if (old != a.end() && now != b.end() && old->second == now->second) continue;
            lines.push_back(fmt::format("{} '{}' is {}, was {}", what, name,
                                        now == b.end() ? "unset" : now->second,
                                        old == a.end() ? "unset" : old->second));
        }
    };
    compare("parameter", was.params, is.params);
    compare("input", was.inputs, is.inputs);
    for (const auto& [param, file] : is.files) {
        const auto old = was.files.find(param);
        if (old == was.files.end() || old->second.path != file.path) continue;  // told already
        if (old->second.digest != file.digest) {
            lines.push_back(fmt::format("the contents of {} changed", file.path));
        }
    }
    for (const Manifest::File& file : is.side_files) {
        const auto old = std::find_if(was.side_files.begin(), was.side_files.end(),
                                      [&](const Manifest::File& f) { return f.path == file.path; });
        if (old != was.side_files.end() && old->digest != file.digest) {
            lines.push_back(fmt::format("the contents of {} changed", file.path));
        }
    }
    return lines;
}

Manifest::Ran ran_here(double took)
{
    std::array<char, 256> name{};
    ::gethostname(name.data(), name.size() - 1);
    rusage mine = {}, started = {};
    ::getrusage(RUSAGE_SELF, &mine);
    ::getrusage(RUSAGE_CHILDREN, &started);
    const auto kilobytes = static_cast<std::uint64_t>(mine.ru_maxrss + started.ru_maxrss);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    const double busy = seconds(mine.ru_utime) + seconds(mine.ru_stime) +
                        seconds(started.ru_utime) + seconds(started.ru_stime);
    return {name.data(), took, 1024 * kilobytes, busy / std::max(took, 1e-3)};
}

}  // namespace runtime
