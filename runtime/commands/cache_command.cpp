#include "runtime/commands/cache_command.hpp"

#include "runtime/cache/quantities.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <ostream>
#include <stdexcept>

namespace runtime {

namespace {

int tend_cache(const std::string& what, const CookRequest& request, Console& console)
{
    const std::unique_ptr<DiskCache> cache = open_cache(request, console);
    if (!cache) throw std::invalid_argument("no cache folder: HOME is not set; use --cache DIR");
    if (what == "verify") {
        const DiskCheck check = cache->verify();
        console.out << fmt::format("{} files good, {} damaged (moved to aside/)\n", check.good,
                                   check.bad);
        if (check.unread > 0) {
            console.out << fmt::format("{} files or folders could not be read\n", check.unread);
        }
        return check.bad + check.unread == 0 ? exit_ok : exit_failed;
    }
    if (what == "gc") {
        const auto gone = static_cast<double>(cache->shrink(request.cache_budget));
        console.out << format_bytes(gone) << " removed\n";
    } else if (what == "clear") {
        cache->clear();
    }
    const DiskUse use = cache->use();
    console.out << fmt::format("{}: {} results, {} values, {}\n", cache->folder().string(),
                               use.records, use.contents,
                               format_bytes(static_cast<double>(use.bytes)));
    if (use.aside > 0) {
        console.out << fmt::format("{} damaged files are kept in aside/\n", use.aside);
    }
    return exit_ok;
}

}  // namespace

void add_cache_command(const CommandSet& set)
{
    CLI::App* cache_app = set.app.add_subcommand("cache", "Manages the disk cache");
    cache_app->require_subcommand(1);
    for (const auto& [name, text] : {std::pair("stat", "Shows how much is stored"),
                                     std::pair("verify", "Reads and checks all files"),
                                     std::pair("gc", "Shrinks the cache to --cache-size"),
                                     std::pair("clear", "Removes everything")}) {
        CLI::App* what = cache_app->add_subcommand(name, text);
        add_cache_options(*what, set.request);
        what->callback([&set, what = std::string(name)] {
            set.exit = tend_cache(what, set.request, set.console);
        });
    }
}

}  // namespace runtime
