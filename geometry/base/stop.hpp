#pragma once

// Lets long kernels end early. Whoever calls kernels opens a StopScope on its thread, and long
// loops look at its token now and then: serial ones by a StopCheck, those of parallel.hpp by
// themselves. Kernels are not handed a token: all would have to hand it on, and none decides by
// it. It changes no result: a kernel returns all of it or throws Stopped.

#include <cstddef>
#include <exception>
#include <stop_token>
#include <utility>

namespace geometry {

struct Stopped : std::exception {
    const char* what() const noexcept override { return "stopped"; }
};

// While it lives, work on this thread looks at `token` (null: at none).
class StopScope {
public:
    explicit StopScope(const std::stop_token* token) : before_(std::exchange(current(), token)) {}
    ~StopScope() { current() = before_; }
    StopScope(const StopScope&) = delete;

    static const std::stop_token*& current()
    {
        static thread_local const std::stop_token* token = nullptr;
        return token;
    }

private:
    const std::stop_token* before_;
};

inline void stop_if_asked()
{
    const std::stop_token* const token = StopScope::current();
    if (token && token->stop_requested()) throw Stopped();
}

// For the inside of a long loop: looks at every 1024th turn.
class StopCheck {
public:
    void operator()()
    {
        if ((++turns_ & 1023) == 0) stop_if_asked();
    }

private:
    unsigned turns_ = 0;
};

}  // namespace geometry
