#include "runtime/commands/kept_sources.hpp"

#include "graph/document/frame_path.hpp"
#include "graph/tools/difference.hpp"
#include "runtime/cook/below_folder.hpp"

#include <fmt/format.h>

#include <map>
#include <set>
#include <stdexcept>

namespace runtime {

namespace {

namespace fs = std::filesystem;

// One path for a file under all that lead to its folder. A folder is looked at once, however many
// frames are in it.
class Places {
public:
    fs::path of(const fs::path& file)
    {
        const auto [known, is_new] = folders_.try_emplace(file.parent_path());
        if (is_new) {
            known->second = resolved(known->first.empty() ? fs::path(".") : known->first);
        }
        return known->second / file.filename();
    }

private:
    std::map<fs::path, fs::path> folders_;
};

// The nodes and all that they depend on.
std::vector<std::uint32_t> reached_from(const graph::Graph& graph,
                                        const std::vector<std::uint32_t>& nodes)
{
    std::vector<char> wanted(graph.nodes.size(), 0);
    for (const std::uint32_t n : nodes) wanted[n] = 1;
    std::vector<std::uint32_t> reached;
    for (std::size_t n = graph.nodes.size(); n-- > 0;) {  // inputs stand before who takes them
        if (!wanted[n]) continue;
        reached.push_back(static_cast<std::uint32_t>(n));
        for (const auto& port : graph.nodes[n].inputs) {
            for (const graph::Link& link : port) wanted[link.node] = 1;
        }
    }
    return reached;
}

// The paths of the files that a node writes, with # for the frame.
std::vector<fs::path> written_by(const graph::Node& node)
{
    std::vector<fs::path> paths;
    for (std::size_t i = 0; node.type->sink && i < node.params.size(); ++i) {
        const auto* const text = std::get_if<std::string>(&node.params[i].is);
        const bool writes = node.type->params[i].kind == graph::ParamKind::path_out;
        if (writes && text && !text->empty()) paths.emplace_back(*text);
    }
    return paths;
}

}  // namespace

void require_sources_stay(const graph::Graph& graph, const fs::path& folder,
                          const std::vector<std::uint32_t>& nodes, const std::vector<int>& frames)
{
    const std::vector<std::uint32_t> reached = reached_from(graph, nodes);
    Places places;
    std::map<fs::path, std::string> sources;  // and what each is
    for (const fs::path& path : graph.documents) {
        sources.emplace(places.of(path), "is a document of this graph");
    }
    for (const std::uint32_t n : reached) {
        const graph::Node& node = graph.nodes[n];
        const std::string read = fmt::format("'{}' reads", node.name);
        for (const auto& [param, path] : graph::files_of(node)) {
            sources.emplace(places.of(path), read);
            sources.emplace(resolved(path), read);  // where a symbolic link leads
        }
        for (const int frame : frames) {
            for (const fs::path& path : graph::files_at(node, frame)) {
                sources.emplace(places.of(path), read);
            }
        }
    }
    for (const std::uint32_t n : reached) {
        for (const fs::path& pattern : written_by(graph.nodes[n])) {
            for (const int frame : frames) {
                const fs::path path = folder / graph::frame_path(pattern, frame);
                const auto source = sources.find(places.of(path));
                if (source == sources.end()) continue;
                throw std::invalid_argument(
                    fmt::format("'{}' would write over {}, which {}: give it another path, or use "
                                "--out DIR",
                                graph.nodes[n].name, path.string(), source->second));
            }
        }
    }
}

}  // namespace runtime
