#include "runtime/commands/usage.hpp"

#include "graph/document/problem.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace runtime {

namespace {

std::string nearest_of(const std::string& word, const std::vector<std::string>& names)
{
    const std::vector<std::string_view> views(names.begin(), names.end());
    return graph::nearest(word, views);
}

std::vector<std::string> commands_of(const CLI::App& app)
{
    std::vector<std::string> names;
    for (const CLI::App* sub : app.get_subcommands({})) names.push_back(sub->get_name());
    return names;
}

// Whether words beside commands can be its files.
bool takes_words(const CLI::App& command)
{
    const auto options = command.get_options();
    return std::any_of(options.begin(), options.end(),
                       [](const CLI::Option* option) { return option->get_positional(); });
}

// "cook: expected FILE (Graph documents)": the first thing that a command can't do without.
std::string missing_option(const CLI::App& command)
{
    for (const CLI::Option* option : command.get_options()) {
        const auto found = static_cast<int>(option->count());
        const int least = std::max(option->get_items_expected_min(), 1);
        if (!option->get_required() || found >= least) continue;
        const std::string name = option->get_positional() ? "" : option->get_name() + " ";
        return fmt::format("{}: expected {}{}{} ({})", command.get_name(),
                           least > 1 ? fmt::format("{} x ", least) : "", name,
                           option->get_type_name(), option->get_description());
    }
    return {};
}

}  // namespace

std::string command_list(const CLI::App& app)
{
    std::string text;
    for (const CLI::App* sub : app.get_subcommands({})) {
        text += fmt::format("\n  {:<9} {}", sub->get_name(), sub->get_description());
    }
    return text;
}

std::string usage_mistake(const CLI::App& app, const std::vector<std::string>& args,
                          const std::string& otherwise)
{
    const auto said = [](const char* what, const std::string& word, const std::string& near) {
        return fmt::format("there is no {} '{}'{}", what, word,
                           near.empty() ? "" : fmt::format("; did you mean '{}'?", near));
    };
    const CLI::App* command = &app;  // the innermost that was named
    for (const std::string& arg : args) {
        const std::vector<std::string> names = commands_of(*command);
        if (names.empty() || arg.starts_with("-")) break;
        if (std::find(names.begin(), names.end(), arg) == names.end()) {
            const std::string near = nearest_of(arg, names);
            if (near.empty() && takes_words(*command)) break;
            return said("command", arg, near) + (near.empty() ? command_list(*command) : "");
        }
        command = command->get_subcommand(arg);
    }
    if (!commands_of(*command).empty() && command != &app && !takes_words(*command)) {
        return fmt::format("{}: expected a subcommand:{}", command->get_name(),
                           command_list(*command));
    }
    std::vector<std::string> flags;
    for (const CLI::Option* option : command->get_options()) {
        for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
    }
    for (const std::string& arg : args) {
        const std::string word = arg.substr(0, arg.find('='));
        if (!word.starts_with("--") || word == "--") continue;
        if (std::find(flags.begin(), flags.end(), word) != flags.end()) continue;
        return said("option", word, nearest_of(word, flags));
    }
    const std::string missing = missing_option(*command);
    return missing.empty() ? otherwise : missing;
}

}  // namespace runtime
