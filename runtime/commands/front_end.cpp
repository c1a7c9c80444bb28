// Parts: text for people (class Text), JSON lines for programs (class JsonLines), grouping of file
// names.

#include "runtime/commands/front_end.hpp"

#include "runtime/cache/quantities.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <condition_variable>
#include <mutex>
#include <ostream>
#include <regex>
#include <thread>

namespace runtime {

namespace {

using Clock = std::chrono::steady_clock;

std::string time_left(const Progress& p)
{
    if (std::isnan(p.left) || p.done == p.total) return {};
    return ", about " + format_seconds(p.left) + " left";
}

std::string number(double x)
{
    return fmt::format("{:.6g}", x);
}

std::string bounds(const graph::Expectation& e)
{
    if (std::isinf(e.min)) return "at most " + number(e.max);
    if (std::isinf(e.max)) return "at least " + number(e.min);
    return number(e.min) + " to " + number(e.max);
}

std::string name_of(const graph::Graph& graph, const graph::Link& link)
{
    const graph::Node& node = graph.nodes[link.node];
    return node.name + "." + node.type->outputs[link.output].name;
}

// "collider 1 of 2" with the name of the node that is linked there. Kernels, and what they warned
// of in the cache, know numbers only: names are no part of a result.
std::string with_names(const graph::Graph& graph, const graph::Node& node, const std::string& text)
{
    static const std::regex numbered("(ollider|oint force) (\\d{1,4}) of \\d+");
    std::smatch found;
    if (!std::regex_search(text, found, numbered)) return text;
    const std::string port = found[1] == "ollider" ? "colliders" : "forces";
    const std::size_t number = std::stoul(found[2]);
    for (std::size_t i = 0; i < node.inputs.size(); ++i) {
        if (node.type->inputs[i].name != port || number < 1 || number > node.inputs[i].size()) {
            continue;
        }
        return fmt::format("{} '{}'{}", found.prefix().str() + found[1].str(),
                           graph.nodes[node.inputs[i][number - 1].node].name, found.suffix().str());
    }
    return text;
}

// Text for people, as lines; with or without one that changes at the end.
class Text : public FrontEnd {
public:
    Text(Console& console, Style style) : console_(console), style_(style) {}

    void began(const graph::Graph& graph, std::size_t frames) override
    {
        const std::lock_guard lock(mutex_);
        graph_ = &graph;
        files_.clear(), failures_.clear(), last_ = {}, missed_ = 0, checked_ = 0;
        left_out_ = 0;
        start_ = shown_ = Clock::now();
        if (style_ == Style::quiet) return;
        say(fmt::format("{}: {} nodes, {} frame{}", graph.file, graph.nodes.size(), frames,
                        frames == 1 ? "" : "s"));
        if (style_ == Style::terminal) {
            ticker_ = std::jthread([this](const std::stop_token& stop) { tick(stop); });
        }
    }

    void progressed(const Progress& p) override
    {
        const std::lock_guard lock(mutex_);
        last_ = p;
        if (style_ == Style::quiet) return;
        const auto pause = style_ == Style::terminal ? std::chrono::milliseconds(100)
                                                     : std::chrono::milliseconds(5000);
        if (Clock::now() - shown_ < pause && p.done != p.total) return;
        shown_ = Clock::now();
        if (style_ == Style::terminal) return draw();
        if (p.elapsed > 1) say(line());
    }

    void failed(const Failure& f) override
    {
        const std::lock_guard lock(mutex_);
        // The same trouble at many frames is one trouble.
        if (++failures_[{f.node, f.what}] == 1) say("error: " + describe(*graph_, f));
    }

    void warned(const Warning& w) override
    {
        const std::lock_guard lock(mutex_);
        say(fmt::format("warning: '{}', frame {}: {}", graph_->nodes[w.node].name, w.frame,
                        with_names(*graph_, graph_->nodes[w.node], w.text)));
    }

    void wrote(std::uint32_t node, int, const Written& file) override
    {
        const std::lock_guard lock(mutex_);
        files_[node].push_back(file.path);
    }

    void expectation(const ExpectationResult& r) override
    {
        const std::lock_guard lock(mutex_);
        ++checked_;
        if (r.met) return;
        ++missed_;
        say("missed: " + missed_text(*graph_, r));
    }

    void expectations_left_out(std::size_t count) override { left_out_ = count; }

    void accuracy(const std::vector<AccuracyCard>& cards) override
    {
        constexpr std::size_t most = 6;  // lines that a person reads
        const std::lock_guard lock(mutex_);
        for (const AccuracyCard& card : cards) {
            for (const std::string& warning : card_warnings(card)) say("warning: " + warning);
        }
        if (style_ == Style::quiet) return;
        for (std::size_t i = 0; i < std::min(cards.size(), most); ++i) {
            say("accuracy: " + card_summary(cards[i]));
        }
        if (cards.size() > most) {
            say(fmt::format("accuracy: {} more, told by aspic card --motion", cards.size() - most));
        }
    }

    void numbers(const std::vector<AskedNumber>& asked) override
    {
        const std::lock_guard lock(mutex_);
        if (!asked.empty()) clear();
        for (const AskedNumber& n : asked) {
            const std::string when = n.frame ? fmt::format(" at frame {}", *n.frame) : "";
            console_.out << fmt::format("{}{}: {}\n", name_of(*graph_, n.from), when,
                                        number(n.value));
        }
        console_.out.flush();
    }

    void finished(const Cooked& cooked, int) override
    {
        if (ticker_.joinable()) {
            ticker_.request_stop();
            wake_.notify_all();
            ticker_.join();
        }
        const std::lock_guard lock(mutex_);
        for (const auto& [what, times] : failures_) {
            if (times > 1) {
                say(fmt::format("error: '{}' failed the same way at {} more frame{}",
                                graph_->nodes[what.first].name, times - 1, times == 2 ? "" : "s"));
            }
        }
        if (cooked.blocked > 0) {
            say(fmt::format("not cooked because of {}: {} result{}",
                            cooked.failures == 1 ? "this failure" : "these failures",
                            cooked.blocked, cooked.blocked == 1 ? "" : "s"));
        }
        if (style_ == Style::quiet) return;
        clear();
        std::size_t runs = 0, found = 0;
        for (const Tally& t : cooked.tallies) runs += t.runs, found += t.found();
        say(fmt::format("{} in {}: {} cooked, {} from the cache",
                        cooked.cancelled      ? "cancelled"
                        : cooked.failures > 0 ? "failed"
                                              : "done",
                        format_seconds(cooked.seconds), runs, found));
        if (checked_ + left_out_ > 0) say(expectations());
        for (auto& [node, files] : files_) {
            for (const std::string& group : group_files(files)) {
                console_.out << "  " << graph_->nodes[node].name << ": " << group << "\n";
            }
        }
        console_.out.flush();
    }

private:
    std::string expectations() const
    {
        const std::size_t all = checked_ + left_out_;
        const char* const s = all == 1 ? "" : "s";
        if (missed_ == 0 && left_out_ == 0) return fmt::format("all {} expectation{} met", all, s);
        std::string text = missed_ == 0
                               ? fmt::format("{} of {} expectation{} met", checked_, all, s)
                               : fmt::format("{} of {} expectation{} missed", missed_, all, s);
        if (left_out_ > 0) text += fmt::format(", {} could not be checked", left_out_);
        return text;
    }

    void tick(const std::stop_token& stop)
    {
        std::unique_lock lock(mutex_);
        while (!stop.stop_requested()) {
            if (!wake_.wait_for(lock, stop, std::chrono::milliseconds(500), [] { return false; })) {
                if (!stop.stop_requested()) draw();
            }
        }
    }

    std::string line() const
    {
        const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
        return fmt::format("{} of {}, {}{}", last_.done, last_.total, format_seconds(elapsed),
                           time_left(last_));
    }
    void draw()
    {
        if (last_.total == 0) return;
        const int width = 30;
        const auto filled = static_cast<int>(width * last_.done / last_.total);
        console_.err << "\r\033[K[" << std::string(static_cast<std::size_t>(filled), '#')
                     << std::string(static_cast<std::size_t>(width - filled), '.') << "] " << line()
                     << std::flush;
        drawn_ = true;
    }
    void clear()
    {
        if (std::exchange(drawn_, false)) console_.err << "\r\033[K";
    }
    void say(const std::string& text)
    {
        clear();
        console_.err << text << "\n" << std::flush;
    }

    Console& console_;
    Style style_;
    const graph::Graph* graph_ = nullptr;
    std::mutex mutex_;
    std::condition_variable_any wake_;
    std::map<std::uint32_t, std::vector<std::filesystem::path>> files_;
    std::map<std::pair<std::uint32_t, std::string>, std::size_t> failures_;
    Progress last_;
    std::size_t missed_ = 0, checked_ = 0, left_out_ = 0;
    Clock::time_point start_, shown_;
    bool drawn_ = false;
    std::jthread ticker_;  // last: it uses the rest
};

class JsonLines : public FrontEnd {
public:
    explicit JsonLines(Console& console) : console_(console) {}

    void began(const graph::Graph& graph, std::size_t frames) override
    {
        graph_ = &graph;
        say({{"event", "began"},
             {"file", graph.file},
             {"nodes", graph.nodes.size()},
             {"frames", frames}});
    }
    void progressed(const Progress& p) override
    {
        Json line{
            {"event", "progress"}, {"done", p.done}, {"total", p.total}, {"elapsed", p.elapsed}};
        if (!std::isnan(p.left)) line["left"] = p.left;
        say(line);
    }
    void failed(const Failure& f) override
    {
        Json line = about(f.node, f.frame, "failed");
        line["message"] = f.what;
        say(line);
    }
    void warned(const Warning& w) override
    {
        Json line = about(w.node, w.frame, "warning");
        line["message"] = w.text;
        say(line);
    }
    void wrote(std::uint32_t node, int frame, const Written& file) override
    {
        Json line = about(node, frame, "wrote");
        line["path"] = file.path.string();
        say(line);
    }
    void expectation(const ExpectationResult& r) override
    {
        Json line{{"event", "expectation"},
                  {"value", name_of(*graph_, r.expectation->value)},
                  {"frame", r.frame},
                  {"met", r.met},
                  {"why", r.expectation->why}};
        if (std::isfinite(r.expectation->min)) line["min"] = r.expectation->min;
        if (std::isfinite(r.expectation->max)) line["max"] = r.expectation->max;
        if (r.value) line["found"] = *r.value;
        say(line);
    }
    void expectations_left_out(std::size_t count) override
    {
        if (count > 0) say({{"event", "expectations_left_out"}, {"count", count}});
    }
    void accuracy(const std::vector<AccuracyCard>& cards) override
    {
        for (const AccuracyCard& card : cards) {
            Json line{{"event", "accuracy"}};
            line.update(card_json(card));
            say(line);
        }
    }
    void numbers(const std::vector<AskedNumber>& asked) override
    {
        for (const AskedNumber& n : asked) {
            Json line{{"event", "number"}, {"value", name_of(*graph_, n.from)}};
            if (n.frame) line["frame"] = *n.frame;
            line["found"] = n.value;
            say(line);
        }
    }
    void finished(const Cooked& cooked, int exit) override
    {
        std::size_t runs = 0, found = 0;
        for (const Tally& t : cooked.tallies) runs += t.runs, found += t.found();
        say({{"event", "finished"},
             {"exit", exit},
             {"seconds", cooked.seconds},
             {"runs", runs},
             {"hits", found},
             {"failures", cooked.failures},
             {"blocked", cooked.blocked}});
    }

private:
    using Json = nlohmann::ordered_json;

    Json about(std::uint32_t n, int frame, const char* event) const
    {
        const graph::Node& node = graph_->nodes[n];
        Json line{
            {"event", event}, {"node", node.name}, {"type", node.type->name}, {"frame", frame}};
        if (node.place.line > 0) {
            line["file"] = node.place.file;
            line["line"] = node.place.line;
            line["column"] = node.place.column;
        }
        return line;
    }
    void say(const Json& line)
    {
        console_.out << line.dump(-1, ' ', false, Json::error_handler_t::replace) << "\n"
                     << std::flush;
    }

    Console& console_;
    const graph::Graph* graph_ = nullptr;
};

bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

// The name with its last run of digits replaced by as many '#'.
std::string numbered(const std::filesystem::path& path)
{
    std::string name = path.filename().string();
    const std::string stem = path.stem().string();
    std::size_t end = stem.size();
    while (end > 0 && !is_digit(stem[end - 1])) --end;
    for (std::size_t i = end; i > 0 && is_digit(stem[i - 1]); --i) name[i - 1] = '#';
    return (path.parent_path() / name).string();
}

}  // namespace

std::vector<std::string> group_files(const std::vector<std::filesystem::path>& files)
{
    std::map<std::string, std::set<std::filesystem::path>> groups;
    for (const auto& file : files) groups[numbered(file)].insert(file);
    std::vector<std::string> lines;
    for (const auto& [pattern, members] : groups) {
        lines.push_back(members.size() == 1
                            ? members.begin()->string()
                            : fmt::format("{} ({} files)", pattern, members.size()));
    }
    return lines;
}

std::string missed_text(const graph::Graph& graph, const ExpectationResult& missed)
{
    const graph::Expectation& e = *missed.expectation;
    return fmt::format("{}{} at frame {}: expected {}, found {}{}",
                       e.place.line > 0 ? graph::describe(e.place) + ": " : "",
                       name_of(graph, e.value), missed.frame, bounds(e),
                       missed.value ? number(*missed.value) : "nothing",
                       e.why.empty() ? "" : " (" + e.why + ")");
}

std::unique_ptr<FrontEnd> make_front_end(Style style, Console& console)
{
    if (style == Style::json) return std::make_unique<JsonLines>(console);
    return std::make_unique<Text>(console, style);
}

}  // namespace runtime
