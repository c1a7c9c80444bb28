#pragma once

// What commands are made of: options that several of them take, and the limits that they run under.
// Each command's own options stand beside the command.

#include "runtime/commands/cook_request.hpp"

#include <functional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace runtime {

// What a command is added to, and what it works with. Lives until the command has run.
struct CommandSet {
    CLI::App& app;
    CookRequest& request;  // filled by the options of the command that was given
    const graph::Registry& registry;
    Console& console;
    int& exit;  // of the command
};

// Graph documents, or exactly one.
void add_files(CLI::App& command, CookRequest& request);
void add_file(CLI::App& command, CookRequest& request);

// An option that may be given several times, one text each time.
CLI::Option* add_repeatable(CLI::App& command, const std::string& name,
                            std::vector<std::string>& texts, const std::string& description,
                            const std::string& type_name);

// --root, --allow-outside
void add_permissions(CLI::App& command, CookRequest& request);
// --set, --var, --quiet and the permissions
void add_loading_options(CLI::App& command, CookRequest& request);
// --cache, --cache-size
void add_cache_options(CLI::App& command, CookRequest& request);
// --frames
void add_frames(CLI::App& command, CookRequest& request);
// --json
void add_json(CLI::App& command, CookRequest& request);
// --threads
void add_threads(CLI::App& command, CookRequest& request);
// --frames, --threads, the caches, limits, --json
void add_cooking_options(CLI::App& command, CookRequest& request);
// --out
void add_out(CLI::App& command, CookRequest& request);
// --node
void add_nodes(CLI::App& command, CookRequest& request);
// --node, --out, --keep-going, --recheck
void add_target_options(CLI::App& command, CookRequest& request);

// Why a text is no list of frames; empty when it is one.
std::string what_is_wrong_with_frames(const std::string& text);

// Does the work under --memory-limit and --time-limit, and keeps its exit code.
void run_limited(const CommandSet& set, const std::function<int()>& work);

}  // namespace runtime
