#pragma once

// Runs another program without a shell, in a process of its own, and listens to what it says.

#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace geometry {

struct ProgramCall {
    // The program, as a path or as a name that is looked for on the PATH, and its arguments.
    std::vector<std::string> words;
    std::vector<std::string> environment;  // "NAME=value" each; empty: this process's own
    int input = -1;   // a descriptor that it reads as its standard input; -1: it reads nothing
    int handed = -1;  // a descriptor that it finds as number 3; -1: none
    double seconds = std::numeric_limits<double>::infinity();  // it is killed after that
};

// How it ended.
struct ProgramRun {
    bool found = true;    // the program is there
    bool in_time = true;  // it ended by itself within call.seconds
    int status = 0;       // as waitpid() tells it; of one that was found and ended by itself
    std::string said;     // what it wrote to its standard output and error, the last 4,000 bytes
};

// Runs it and waits for its end. `check` is called about twenty times a second meanwhile; what it
// throws ends the program and is thrown on. Ctrl-C in a terminal does not reach the program: that
// is for `check` to decide. Never leaves a process behind. Throws std::runtime_error when the
// program is there and cannot be started.
ProgramRun run_program(const ProgramCall& call, const std::function<void()>& check);

}  // namespace geometry
