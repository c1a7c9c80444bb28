#pragma once

// What a node may ask of the run beyond its inputs and parameters: the frame, where output goes,
// when to stop.

#include "graph/types/figure.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <vector>

namespace graph {

// Both ends are cooked. Frame `first` is time 0.
struct FrameRange {
    int first = 1, last = 1;
    double fps = 24;

    int count() const { return last - first + 1; }
    double time(int frame) const { return (frame - first) / fps; }
    bool operator==(const FrameRange&) const = default;
};

// What a node may ask of the run beyond its inputs. Only what its description declares becomes
// part of its key, so asking for another is a bug and throws.
enum class Variable : unsigned {
    frame = 1,  // the frame's number, and its time
    fps = 2,    // frames a second, and the seconds a frame lasts
    range = 4,  // first and last frame of the document
    pace = 8,   // how fast time passes in the scene that the node depends on
};
constexpr unsigned operator|(Variable a, Variable b)
{
    return static_cast<unsigned>(a) | static_cast<unsigned>(b);
}
constexpr unsigned operator|(unsigned a, Variable b)
{
    return a | static_cast<unsigned>(b);
}

// What a warning begins with that says nothing of a body that keeps its shape.
inline constexpr const char* of_bending = "bending: ";

// What the runs of one cook know of each other. It is part of no key: only for sinks, which must
// not undo in one frame what they wrote in another.
class Cook {
public:
    explicit Cook(std::vector<int> all) : frames(std::move(all)) {}

    const std::vector<int> frames;  // ascending

    // What the first run that said something of `name` said.
    std::size_t first_said(const std::string& name, std::size_t value)
    {
        const std::lock_guard lock(mutex_);
        return said_.emplace(name, value).first->second;
    }

private:
    std::mutex mutex_;
    std::map<std::string, std::size_t> said_;
};

class Context {
public:
    Context() = default;
    // `pace`: s of the scene that pass in a frame; 0: as many as of the video. `animated`: whether
    // a parameter of the node varies by frame.
    Context(int frame, FrameRange range, unsigned declared, double pace = 0, bool animated = false)
        : frame_(frame), animated_(animated), range_(range), declared_(declared), pace_(pace)
    {}

    int frame() const { return need(Variable::frame), frame_; }
    double time() const { return need(Variable::frame), range_.time(frame_); }  // s
    double fps() const { return need(Variable::fps), range_.fps; }
    double frame_seconds() const { return need(Variable::fps), 1 / range_.fps; }
    const FrameRange& range() const { return need(Variable::range), range_; }
    // Whether keyframes or expressions vary a parameter of the node by frame. Its key says which.
    bool animated() const { return animated_; }
    // How many times slower than in the scene time passes in the video.
    double slow_motion() const
    {
        return need(Variable::pace), pace_ > 0 ? 1 / (pace_ * range_.fps) : 1;
    }

    std::stop_token stop;  // long kernels look now and then, and throw Cancelled when it is set

    // Where relative output paths live. Not part of any key.
    std::filesystem::path output_folder = ".";

    // Files that a read file names must lie below; empty: anywhere. Not part of any key.
    std::filesystem::path root;

    // For a node that gathers: the frame of each gathered value, in order. They are those that it
    // asked for, or, in a cook of fewer frames, the nearest cooked ones before them.
    std::vector<int> gathered;

    // Null: a cook of this frame only.
    std::shared_ptr<Cook> cook;

    // A sentence for the person who cooks; once a result, kept with it. One that begins with
    // of_bending is not told where all that compute with the body keep it rigid. Null in tests.
    std::function<void(const std::string&)> warn = [](const std::string&) {};

    // How accurate the result is; at most once. Kept with the result. Null in tests.
    std::function<void(Figures)> tell = [](const Figures&) {};

    // A file read beside those named in path_in parameters (a material library, a texture): its
    // bytes, or its absence, become part of the result's key.
    std::function<void(const std::filesystem::path&)> opened = [](const std::filesystem::path&) {};

private:
    void need(Variable v) const
    {
        if ((declared_ & static_cast<unsigned>(v)) == 0) {
            throw std::logic_error("this node reads a context variable that it does not declare");
        }
    }

    int frame_ = 1;
    bool animated_ = false;
    FrameRange range_;
    unsigned declared_ = 0;
    double pace_ = 0;
};

// Thrown by work that saw the stop token set.
struct Cancelled : std::exception {
    const char* what() const noexcept override { return "cancelled"; }
};

}  // namespace graph
