#pragma once

// Speed against error: cooks every combination of some parameters, measures how far a wire is from
// a reference and how long a frame takes, and says which setting meets an error soonest.

#include "runtime/commands/vary.hpp"
#include "runtime/cook/evaluator.hpp"

#include <limits>
#include <map>
#include <optional>

namespace runtime {

// How far a value is from the reference's, of one wire type. Throws std::invalid_argument, saying
// why, when they can't be compared.
using Distance = std::function<double(const graph::Value&, const graph::Value&)>;

struct StudyOptions {
    std::vector<Vary> varied;
    // "tip.value" or "shape.mesh": node.port of a type that has a distance. The first decides what
    // is nearest; the others are told beside it.
    std::vector<std::string> measures;
    std::string look;             // node.port to keep of the last frame of each trial, or empty
    std::vector<int> frames;      // ascending; empty: all of the graph
    std::optional<double> exact;  // an analytic reference, for a number
    std::optional<Settings> reference;  // a setting to compare with; neither: the last combination
    graph::LoadOptions load;
    Options cook;
    std::map<std::string, Distance> distances;  // by name of wire type; numbers need none
};

// One of the measures of a trial.
struct Measured {
    std::string wire;
    double value = std::numeric_limits<double>::quiet_NaN();  // of a number, at the last frame
    double error = std::numeric_limits<double>::quiet_NaN();  // root mean square over the frames
};

struct Trial {
    Settings settings;
    bool reference = false;    // what the others are compared with
    bool best = false;         // no other trial is both nearer and quicker
    double error = 0;          // root mean square over the frames, in the measure's unit
    double worst = 0;          // largest over the frames
    double relative = 0;       // error over the largest departure of the reference from its first
                               // frame (or over its largest magnitude, for a number), of the
                               // frames that can be compared with that one; not a number when
                               // that is 0
    double frame_seconds = 0;  // of all that ran anew at each frame, see seconds_a_frame()
    double setup_seconds = 0;  // of what ran once
    std::string failure;       // why it could not be cooked; empty when it could
    std::string incomparable;  // why it could not be compared with the reference, likewise
    std::vector<Measured> measured;     // each of the measures, where it could be cooked
    std::vector<std::string> warnings;  // of its document, and of its nodes, "'node': text"
    graph::Value look;
};

// Throws std::invalid_argument for options that make no sense of this graph, and graph::Cancelled
// when told to stop; a trial that fails is data. `told` is called after each trial.
std::vector<Trial> study(const std::filesystem::path& file, const graph::Registry& registry,
                         const StudyOptions& options,
                         const std::function<void(const Trial&)>& told = {});

// Seconds of a frame: of each node that ran, over the frames asked for and those that these needed
// of it. A simulation that is asked for frame 48 alone runs 48 times, what draws it once.
double seconds_a_frame(const std::vector<Run>& runs, const std::vector<int>& asked);

// Marks the trials that no other one is both nearer and quicker than.
void mark_best(std::vector<Trial>& trials);

// "12.7 ms per frame"; "40 ms in all" where nothing ran anew at a frame.
std::string time_of(const Trial& trial);

// Whether any trial but the reference has a relative error.
bool any_compared(const std::vector<Trial>& trials);

// Whether plot_program() has a point to draw: its axes are logarithmic.
bool any_to_plot(const std::vector<Trial>& trials);

// One sentence: the quickest trial whose relative error is at most `wanted`.
std::string soonest(const std::vector<Trial>& trials, double wanted);

// A line a trial, a column a varied parameter and a figure; the header first.
std::string to_csv(const std::vector<Trial>& trials);

// A gnuplot program that draws error against time from to_csv()'s file, best choices marked. The
// time is that of a frame, or of what runs once where nothing ran anew at a frame.
std::string plot_program(const std::vector<Trial>& trials, const std::string& csv_file,
                         const std::string& png_file, const std::string& title);

}  // namespace runtime
