#pragma once

// What to tell a person whose command line was not understood.

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace runtime {

// "\n  stat    Shows how much is stored", a line for each command below this one.
std::string command_list(const CLI::App& app);

// What was not understood and the nearest name that would be, or what is missing; `otherwise` when
// it is neither.
std::string usage_mistake(const CLI::App& app, const std::vector<std::string>& args,
                          const std::string& otherwise);

}  // namespace runtime
