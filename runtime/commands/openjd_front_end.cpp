#include "runtime/commands/openjd_front_end.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ostream>

namespace runtime {

namespace {

class OpenJd : public FrontEnd {
public:
    explicit OpenJd(Console& console)
        : console_(console), people_(make_front_end(Style::lines, console))
    {}

    void began(const graph::Graph& graph, std::size_t frames) override
    {
        graph_ = &graph;
        people_->began(graph, frames);
    }
    void progressed(const Progress& p) override
    {
        people_->progressed(p);
        // A line a second is as much as anybody looks at.
        const auto now = std::chrono::steady_clock::now();
        const bool last = p.done == p.total;
        if (p.total == 0 || (!last && now - told_ < std::chrono::seconds(1))) return;
        told_ = now;
        say(fmt::format("openjd_progress: {:.1f}",
                        100 * static_cast<double>(p.done) / static_cast<double>(p.total)));
        say(fmt::format("openjd_status: {} of {} results", p.done, p.total));
    }
    void failed(const Failure& f) override
    {
        people_->failed(f);
        std::string text = describe(*graph_, f);
        std::replace(text.begin(), text.end(), '\n', ' ');
        say("openjd_fail: " + text);
    }
    void warned(const Warning& w) override { people_->warned(w); }
    void wrote(std::uint32_t n, int frame, const Written& w) override
    {
        people_->wrote(n, frame, w);
    }
    void ran(const Run& run) override { people_->ran(run); }
    void expectation(const ExpectationResult& r) override
    {
        people_->expectation(r);
        if (!r.met) say("openjd_status: an expectation was missed");
    }
    void expectations_left_out(std::size_t count) override
    {
        people_->expectations_left_out(count);
    }
    void accuracy(const std::vector<AccuracyCard>& cards) override { people_->accuracy(cards); }
    void numbers(const std::vector<AskedNumber>& asked) override { people_->numbers(asked); }
    void finished(const Cooked& cooked, int exit) override
    {
        people_->finished(cooked, exit);
        if (exit == exit_missed) say("openjd_fail: an expectation was missed");
    }

private:
    void say(const std::string& line) { console_.out << line << "\n" << std::flush; }

    Console& console_;
    std::unique_ptr<FrontEnd> people_;
    const graph::Graph* graph_ = nullptr;
    std::chrono::steady_clock::time_point told_;
};

}  // namespace

std::unique_ptr<FrontEnd> openjd_front_end(Console& console)
{
    return std::make_unique<OpenJd>(console);
}

}  // namespace runtime
