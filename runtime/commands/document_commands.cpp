#include "runtime/commands/document_commands.hpp"

#include "graph/document/other_names.hpp"
#include "graph/tools/difference.hpp"
#include "graph/tools/format.hpp"
#include "graph/tools/reference.hpp"
#include "graph/tools/schema.hpp"
#include "runtime/commands/text_file.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <ostream>

namespace runtime {
namespace {

int show_nodes(const std::string& name, bool markdown, const graph::Registry& registry,
               Console& console)
{
    if (!name.empty()) {
        // As documents write it, with its version, too.
        const graph::NodeType* type = registry.find(name.substr(0, name.find('@')));
        if (!type) {
            // What other programs call so, and what there is here; then all that speaks of it.
            const std::string_view advice = graph::advice_on_type(name, registry);
            const std::string found =
                (advice.empty() ? "" : fmt::format("{}: {}\n", name, advice)) +
                graph::reference_list(registry, name);
            if (!found.empty()) return console.out << found, exit_ok;
            std::vector<std::string_view> names;
            for (const auto& [known, unused] : registry.types()) names.push_back(known);
            const std::string near = graph::suggest(name, names);
            throw std::invalid_argument(
                fmt::format("no node type is called '{}' or speaks of it; {}", name,
                            near.empty() ? "`aspic nodes` lists all" : near));
        }
        console.out << graph::reference_text(*type);
    } else {
        console.out << (markdown ? graph::reference_page(registry)
                                 : graph::reference_list(registry));
    }
    return exit_ok;
}

// `check`: says which files are not in canonical form, and changes none.
int format_files(const std::vector<std::string>& files, bool check, Console& console)
{
    int exit = exit_ok;
    for (const std::string& file : files) {
        const std::string text = read_text(file);
        graph::Problems problems;
        const auto formatted = graph::format_document(text, file, problems);
        for (const graph::Problem& p : problems.take()) console.err << graph::describe(p) << "\n";
        if (!formatted) {
            exit = exit_usage;
        } else if (*formatted != text) {
            if (check) {
                exit = exit_failed;
            } else {
                // A link stays one, and what it leads to is formatted.
                replace_text(std::filesystem::canonical(file), *formatted);
            }
            console.out << file << "\n";
        }
    }
    return exit;
}

int show_difference(const CookRequest& request, const graph::Registry& registry, Console& console)
{
    const auto a = load(request.files.at(0), request, registry, console);
    const auto b = load(request.files.at(1), request, registry, console);
    if (!a || !b) return exit_usage;
    const std::vector<std::string> lines = graph::difference(*a, *b);
    for (const std::string& line : lines) console.out << line << "\n";
    return lines.empty() ? exit_ok : exit_failed;
}

int start_document(const std::string& file, Console& console)
{
    if (file.empty()) {
        console.out << console.starter;
        return exit_ok;
    }
    const std::filesystem::path path =
        std::filesystem::path(file).has_extension() ? file : file + ".json";
    if (std::filesystem::exists(path)) {
        throw std::invalid_argument(
            fmt::format("{} exists already; choose another name", path.string()));
    }
    std::error_code error;
    if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
    if (error) {
        throw std::invalid_argument(
            fmt::format("the folder {} can't be created ({}); choose another",
                        path.parent_path().string(), error.message()));
    }
    std::string text = console.starter;
    // Its comments show commands on itself, by the name that it now has.
    const std::string own_name = "starter.json", name = path.filename().string();
    for (std::size_t at = 0; (at = text.find(own_name, at)) != std::string::npos;) {
        text.replace(at, own_name.size(), name);
        at += name.size();
    }
    replace_text(path, text);
    console.out << fmt::format("{} written; next: aspic cook {}\n", path.string(), path.string());
    return exit_ok;
}

int validate(const CookRequest& request, const graph::Registry& registry, Console& console)
{
    bool all = true;
    for (const std::string& file : request.files) {
        const auto graph = load(file, request, registry, console);
        all = all && graph.has_value();
        if (graph && !request.quiet) {
            console.out << fmt::format("{}: valid: {} nodes, frames {} to {}\n", file,
                                       graph->nodes.size(), graph->range.first, graph->range.last);
        }
    }
    return all ? exit_ok : exit_usage;
}

}  // namespace

void add_document_commands(const CommandSet& set)
{
    CLI::App* validate_app =
        set.app.add_subcommand("validate", "Reports all mistakes in graph documents");
    add_files(*validate_app, set.request);
    add_loading_options(*validate_app, set.request);
    validate_app->callback([&set] {
        set.request.writes = true;
        set.exit = validate(set.request, set.registry, set.console);
    });

    CLI::App* nodes =
        set.app.add_subcommand("nodes", "Lists the node types, describes one, or searches them");
    auto name = std::make_shared<std::string>();
    auto markdown = std::make_shared<bool>(false);
    nodes->add_option("type", *name, "Node type, or a word to search their descriptions for")
        ->type_name("TYPE");
    nodes->add_flag("--markdown", *markdown, "Writes the whole reference as a Markdown page");
    nodes->callback([&set, name, markdown] {
        set.exit = show_nodes(*name, *markdown, set.registry, set.console);
    });

    set.app.add_subcommand("schema", "Writes a JSON Schema of graph documents, for editors")
        ->callback([&set] {
            set.console.out << graph::schema_text(set.registry);
            set.exit = exit_ok;
        });

    CLI::App* fmt_app = set.app.add_subcommand("fmt", "Rewrites documents in canonical form");
    auto check = std::make_shared<bool>(false);
    add_files(*fmt_app, set.request);
    fmt_app->add_flag("--check", *check,
                      "Only lists files that are not in canonical form; exit code 1 if any");
    fmt_app->callback(
        [&set, check] { set.exit = format_files(set.request.files, *check, set.console); });

    CLI::App* diff = set.app.add_subcommand(
        "diff", "Shows how two graphs differ in meaning; exit code 1 if they do");
    diff->add_option("files", set.request.files, "Two graph documents")
        ->required()
        ->expected(2)
        ->type_name("FILE");
    diff->callback([&set] { set.exit = show_difference(set.request, set.registry, set.console); });

    CLI::App* start = set.app.add_subcommand("new", "Writes a commented graph to start from");
    auto target = std::make_shared<std::string>();
    start->add_option("file", *target, "File to write (default: print it)")->type_name("FILE");
    start->callback([&set, target] { set.exit = start_document(*target, set.console); });

    CLI::App* draw =
        set.app.add_subcommand("graph", "Writes a graph in the format of Graphviz: | dot -Tsvg");
    add_file(*draw, set.request);
    draw->callback([&set] {
        const auto graph = load(set.request.files.at(0), set.request, set.registry, set.console);
        if (graph) set.console.out << graph::dot_text(*graph);
        set.exit = graph ? exit_ok : exit_usage;
    });
}

}  // namespace runtime
