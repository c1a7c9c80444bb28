#pragma once

// What ends a cook before it is done: a signal to the process, or a limit of time. Both set a stop
// token: no node starts any more, and those that run may give up.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

namespace runtime {

// Turns Ctrl-C, SIGTERM and the end of the terminal (SIGHUP) into a stop token: once asks the work
// to stop, Ctrl-C or SIGTERM twice ends the process at once. One at a time in a process, since a
// signal belongs to all of it.
class Interrupt {
public:
    Interrupt();
    ~Interrupt();
    Interrupt(const Interrupt&) = delete;

    std::stop_token token() const { return source_.get_token(); }

private:
    std::stop_source source_;
    int pipe_[2] = {-1, -1};
    struct sigaction before_[3] = {};  // what the signals did
    std::thread listener_;
};

// A stop token that is set when another one is, or after some seconds.
class Deadline {
public:
    Deadline(double seconds, const std::stop_token& other)
        : passed_on_(other, [this] { source_.request_stop(); }),
          timer_([this, seconds](const std::stop_token& ended) {
              std::mutex mutex;
              std::unique_lock lock(mutex);
              std::condition_variable_any nothing;
              nothing.wait_for(lock, ended, std::chrono::duration<double>(seconds),
                               [] { return false; });
              if (ended.stop_requested()) return;
              over_ = true;
              source_.request_stop();
          })
    {}

    std::stop_token token() const { return source_.get_token(); }
    bool over() const { return over_; }

private:
    std::stop_source source_;
    std::atomic<bool> over_{false};
    std::stop_callback<std::function<void()>> passed_on_;
    std::jthread timer_;  // last: it uses the rest
};

}  // namespace runtime
