#pragma once

// An error budget: the coarsest cubes and the longest steps whose results are within an error.
//
// One parameter after the other is halved and doubled, and what a graph's measures say is followed.
// Of values v1, v2, v3 at spacings h, 2h, 4h,
//   p = log2((v3 - v2) / (v2 - v1)),   v* = v1 + (v1 - v2) / (2^p - 1)
// are the observed order and the value at spacing 0 (Richardson, Gaunt. The deferred approach to
// the limit. Phil. Trans. A 226, 1927; Roache. Quantification of uncertainty in computational fluid
// dynamics. Annu. Rev. Fluid Mech. 29, 1997). Two spacings would not show whether the values have
// begun to converge.

#include "runtime/commands/sweep.hpp"

#include <array>

namespace runtime {

// What three values say of the limit.
struct Limit {
    double value = 0;        // v*
    double uncertainty = 0;  // of it
    double order = 0;        // p; 0: none, the values do not converge yet
};

// Of values at spacings h, 2h, 4h, the finest first.
Limit limit_of(const std::array<double, 3>& values);

struct TuneOptions {
    double error = 0.05;      // relative
    std::string size, steps;  // node.param, or a variable; empty: found in the graph
    int most = 6;             // settings of a parameter
    double most_cubes = 1e6;
    SweepOptions sweep;  // measures, frames; empty measures: those of Measure nodes
    std::function<double(const graph::Value&)> count_cubes = {};
    std::function<void(const Settings&)> begins = {};  // called before each setting
};

// A setting that was tried.
struct Tuned {
    Settings settings;
    double spacing = 0;           // of the parameter, in any unit
    double cubes = 0;             // 0: unknown
    std::vector<double> numbers;  // one a measure, at the last frame
    std::vector<double> all;      // at all frames
    double error = 0;             // estimated, relative: the worst of all
    double seconds = 0;
    std::string failure;
    std::vector<std::string> warnings;
};

struct Tuning {
    std::vector<std::string> measures;
    std::vector<std::vector<Tuned>> tried;  // by parameter, the coarsest first
    Settings recommended;
    double error = 0;    // of it, estimated
    double seconds = 0;  // that it took
    // Cubes of it, where they are solids with stiffness = filled, and their node; 0: others, or
    // unknown.
    double filled = 0;
    std::string filled_node;
    bool reached = false;    // the error that was asked for
    std::string at_end;      // the parameter whose range ended before that; empty: none
    bool cancelled = false;  // `tried` holds the settings that were cooked before
};

// Throws std::invalid_argument when the graph has no such parameters or measures. `told` is called
// after each setting.
Tuning tune(const std::filesystem::path& file, const graph::Registry& registry,
            const TuneOptions& options, Caches& caches,
            const std::function<void(const Tuned&)>& told = {});

}  // namespace runtime
