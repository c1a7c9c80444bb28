#pragma once

// Parallel loops under ThreadSanitizer. Debian's oneTBB is not instrumented: the order that it
// keeps between tasks cannot be seen, and every loop would look like a race. Here the same loops
// run on two std::threads beside the caller's, whose order can be seen. Only the tsan preset reads
// this.

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <pthread.h>

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

namespace tsan_loops {

using Piece = std::function<void(std::size_t)>;

class Crew {
public:
    Crew()
    {
        for (std::size_t h = 0; h < hands_.size(); ++h) {
            hands_[h] = std::thread([this, h] { serve(h); });
        }
        pthread_atfork(nullptr, nullptr, [] { forked() = true; });
    }
    ~Crew()
    {
        if (forked()) {
            for (auto& hand : hands_) hand.detach();
            return;
        }
        {
            std::lock_guard lock(mutex_);
            leaving_ = true;
        }
        called_.notify_all();
        for (auto& hand : hands_) hand.join();
    }
    Crew(const Crew&) = delete;
    Crew& operator=(const Crew&) = delete;

    static Crew& one()
    {
        static Crew crew;
        return crew;
    }

    // A loop within a loop, or beside another's, runs on its caller's thread alone.
    void run(std::size_t n, const Piece& piece)
    {
        std::unique_lock turn(turn_, std::defer_lock);
        if (n < 2 || inside() || forked() || !turn.try_lock()) {
            for (std::size_t i = 0; i < n; ++i) piece(i);
            return;
        }
        {
            std::lock_guard lock(mutex_);
            piece_ = &piece, pieces_ = n, begun_ = 0, ended_ = 0, ++calls_;
        }
        called_.notify_all();
        take(hands_.size());
        await(ended_);
        if (const auto error = std::exchange(error_, nullptr)) std::rethrow_exception(error);
    }

private:
    static bool& inside()
    {
        thread_local bool value = false;
        return value;
    }
    static std::atomic<bool>& forked()
    {
        static std::atomic<bool> value = false;
        return value;
    }

    void serve(std::size_t hand)
    {
        std::size_t seen = 0;
        for (;;) {
            {
                std::unique_lock lock(mutex_);
                called_.wait(lock, [&] { return leaving_ || calls_ != seen; });
                if (leaving_) return;
                seen = calls_;
            }
            take(hand);
        }
    }

    void await(std::atomic<std::size_t>& count) const
    {
        while (count.load(std::memory_order_acquire) < hands_.size() + 1) std::this_thread::yield();
    }

    // Pieces are dealt, not raced for, so that short loops too run on every thread; and nobody
    // begins before all are here, or what the last comer locked would order it after the others.
    void take(std::size_t first)
    {
        begun_.fetch_add(1, std::memory_order_release);
        await(begun_);
        inside() = true;
        try {
            for (std::size_t i = first; i < pieces_; i += hands_.size() + 1) (*piece_)(i);
        } catch (...) {
            std::lock_guard lock(failing_);
            if (!error_) error_ = std::current_exception();
        }
        inside() = false;
        ended_.fetch_add(1, std::memory_order_release);
    }

    std::mutex turn_, mutex_, failing_;
    std::condition_variable called_;
    std::array<std::thread, 2> hands_;
    const Piece* piece_ = nullptr;
    std::size_t pieces_ = 0, calls_ = 0;
    std::atomic<std::size_t> begun_ = 0, ended_ = 0;
    std::exception_ptr error_;
    bool leaving_ = false;
};

}  // namespace tsan_loops

namespace tbb {

template <class Index, class Body>
void tsan_parallel_for(const blocked_range<Index>& all, const Body& body)
{
    const std::size_t grain = all.grainsize(), n = (all.size() + grain - 1) / grain;
    tsan_loops::Crew::one().run(n, [&](std::size_t i) {
        const auto begin = static_cast<Index>(all.begin() + static_cast<Index>(i * grain));
        const auto left = static_cast<std::size_t>(all.end() - begin);
        body(blocked_range<Index>(begin, static_cast<Index>(begin + (left < grain ? left : grain)),
                                  grain));
    });
}

template <class Index, class Body> void tsan_parallel_for(Index first, Index last, const Body& body)
{
    if (last <= first) return;
    tsan_loops::Crew::one().run(static_cast<std::size_t>(last - first), [&](std::size_t i) {
        body(static_cast<Index>(first + static_cast<Index>(i)));
    });
}

template <class... Bodies> void tsan_parallel_invoke(const Bodies&... bodies)
{
    const std::array<std::function<void()>, sizeof...(Bodies)> all{std::cref(bodies)...};
    tsan_loops::Crew::one().run(all.size(), [&](std::size_t i) { all[i](); });
}

}  // namespace tbb

#define parallel_for tsan_parallel_for
#define parallel_invoke tsan_parallel_invoke
