#include "runtime/cook/interrupt.hpp"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <stdexcept>
#include <unistd.h>

namespace runtime {

namespace {

// A signal handler may do next to nothing: it counts, and writes a byte for the listener, which
// may do what a stop token needs (locks, callbacks).
std::atomic<int> write_end{-1};
std::atomic<int> signals{0};
constexpr std::array stopping{SIGINT, SIGTERM, SIGHUP};

extern "C" void on_signal(int signal)
{
    // A terminal that closes sends its signal more than once, and nobody pressed a key.
    if (signal != SIGHUP && signals.fetch_add(1) > 0) _exit(130);
    const int before = errno;
    const char byte = 1;
    [[maybe_unused]] const auto written = ::write(write_end, &byte, 1);
    errno = before;
}

}  // namespace

Interrupt::Interrupt()
{
    if (::pipe2(pipe_, O_CLOEXEC) != 0) throw std::runtime_error("no pipe for signals");
    write_end = pipe_[1];
    signals = 0;
    listener_ = std::thread([this] {
        char byte = 0;
        while (::read(pipe_[0], &byte, 1) < 0 && errno == EINTR) {
        }
        if (byte == 1) source_.request_stop();
    });
    struct sigaction action = {};
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESTART;
    for (std::size_t i = 0; i < stopping.size(); ++i) {
        ::sigaction(stopping[i], nullptr, &before_[i]);
        const bool ignored = before_[i].sa_handler == SIG_IGN;  // by nohup, say
        if (!ignored || stopping[i] != SIGHUP) ::sigaction(stopping[i], &action, nullptr);
    }
}

Interrupt::~Interrupt()
{
    for (std::size_t i = 0; i < stopping.size(); ++i) {
        ::sigaction(stopping[i], &before_[i], nullptr);
    }
    const char end = 0;
    [[maybe_unused]] const auto written = ::write(pipe_[1], &end, 1);
    listener_.join();
    ::close(pipe_[0]);
    ::close(pipe_[1]);
}

}  // namespace runtime
