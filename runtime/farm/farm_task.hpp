#pragma once

// A cook cut into tasks, each of them a cook of its own that any machine may run. They share no
// more than the disk cache and the output folder.
//
//   shared   what is the same at all frames and what several tasks need
//   chain    simulations: frames that remember the last one, from the first to the last
//   frames   all other results that differ from frame to frame, a few frames a task
//   last     the whole cook again: it finds the rest in the cache, gathers frames into videos and
//            sheets, checks the expectations and writes the manifest
//   sweep    the table and the sheet of all settings of a document

#include "runtime/cache/key.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace runtime {

enum class Stage : std::uint8_t { shared, chain, frames, last, sweep };

inline constexpr std::array all_stages{Stage::shared, Stage::chain, Stage::frames, Stage::last,
                                       Stage::sweep};

struct FarmTask {
    std::string name;  // "bridge.frames-3", each once
    Stage stage = Stage::last;
    std::uint32_t shot = 0;            // into Cut::shots
    std::vector<std::string> nodes;    // to be cooked; none: all that the shot is asked for
    std::vector<int> frames;           // at these
    std::vector<std::uint32_t> after;  // tasks that have to be done before; all stand before it
    double seconds = 0;                // s of work that is left, as far as that is known
};

// One graph with its settings and its output folder.
struct Shot {
    std::string name;                    // "bridge", or "bridge-003" of several settings
    std::string file;                    // the document
    std::vector<std::string> sets;       // as --set takes them
    std::vector<std::string> variables;  // as --var takes them
    std::filesystem::path folder;        // absolute
    std::size_t results = 0;             // that are asked for, a node at a frame each
    std::size_t held = 0;                // of those: in the cache already
    bool measured = false;               // false: nothing is known of its times, they are guesses
};

struct Cut {
    std::vector<Shot> shots;
    std::vector<FarmTask> tasks;
};

const char* name_of(Stage stage);

}  // namespace runtime
