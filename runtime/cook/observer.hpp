#pragma once

// What a cook tells while it runs. Calls come from any thread, but one at a time and in order.

#include "runtime/cache/result.hpp"

namespace runtime {

struct Progress {
    std::size_t done = 0, total = 0;  // of the wanted results
    double elapsed = 0;               // s
    double left = 0;                  // s, from what each node took so far; NaN while unknown
};

// A node that could not give its result: named once, where the trouble is, not where it arrives.
struct Failure {
    std::uint32_t node = 0;  // into Graph::nodes
    int frame = 0;
    std::string what;
};

struct Warning {
    std::uint32_t node = 0;
    int frame = 0;
    std::string text;
};

// One run of a node or of a preparation.
struct Run {
    std::uint32_t node = 0;
    int frame = 0;
    int preparation = -1;  // which, or -1 for the node itself
    int thread = 0;        // 0, 1, ... of those that cook
    double begin = 0;      // s since the cook began
    double seconds = 0;
    std::size_t bytes = 0;
};

class Observer {
public:
    virtual ~Observer() = default;
    virtual void progressed(const Progress&) {}
    virtual void failed(const Failure&) {}
    virtual void warned(const Warning&) {}  // once for each distinct text of a node
    virtual void told(const Told&) {}       // once for each result that tells of its accuracy
    virtual void wrote(std::uint32_t /*node*/, int /*frame*/, const Written&) {}
    virtual void ran(const Run&) {}
};

// Hands all on to another observer.
class Relay : public Observer {
public:
    explicit Relay(Observer& next) : next_(next) {}
    void progressed(const Progress& p) override { next_.progressed(p); }
    void failed(const Failure& f) override { next_.failed(f); }
    void warned(const Warning& w) override { next_.warned(w); }
    void told(const Told& t) override { next_.told(t); }
    void wrote(std::uint32_t n, int frame, const Written& w) override { next_.wrote(n, frame, w); }
    void ran(const Run& run) override { next_.ran(run); }

private:
    Observer& next_;
};

}  // namespace runtime
