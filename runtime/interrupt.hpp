#pragma once

#include <stop_token>
#include <thread>

namespace runtime {

// Turns Ctrl-C into a stop token: once asks the work to stop, twice ends the process at once. One
// at a time in a process, since a signal belongs to all of it.
class Interrupt {
public:
    Interrupt();
    ~Interrupt();
    Interrupt(const Interrupt&) = delete;

    std::stop_token token() const { return source_.get_token(); }

private:
    std::stop_source source_;
    int pipe_[2] = {-1, -1};
    std::thread listener_;
};

}  // namespace runtime
