#include "runtime/farm/schedule.hpp"

#include "runtime/farm/cut.hpp"

#include <algorithm>
#include <queue>
#include <utility>

namespace runtime {

std::vector<double> seconds_to_end(const Cut& cut)
{
    std::vector<double> left(cut.tasks.size(), 0);
    for (std::size_t t = cut.tasks.size(); t-- > 0;) {  // each stands after those that it waits for
        left[t] += cut.tasks[t].seconds;
        for (const std::uint32_t before : cut.tasks[t].after) {
            left[before] = std::max(left[before], left[t]);
        }
    }
    return left;
}

std::vector<std::uint32_t> critical_path(const Cut& cut)
{
    std::vector<std::uint32_t> path;
    if (cut.tasks.empty()) return path;
    const std::vector<double> left = seconds_to_end(cut);
    const auto dependants = dependants_of(cut);
    const auto longer = [&](std::uint32_t a, std::uint32_t b) { return left[a] < left[b]; };
    path.push_back(
        static_cast<std::uint32_t>(std::max_element(left.begin(), left.end()) - left.begin()));
    while (!dependants[path.back()].empty()) {
        const auto& next = dependants[path.back()];
        path.push_back(*std::max_element(next.begin(), next.end(), longer));
    }
    return path;
}

double makespan(const Cut& cut, std::size_t machines, double overhead)
{
    using Timed = std::pair<double, std::uint32_t>;
    const std::vector<double> left = seconds_to_end(cut);
    const auto dependants = dependants_of(cut);
    std::vector<std::size_t> missing;
    // Most work behind it first; of equal ones, the first of the list.
    const auto later = [](const Timed& a, const Timed& b) {
        return a.first < b.first || (a.first == b.first && a.second > b.second);
    };
    std::priority_queue<Timed, std::vector<Timed>, decltype(later)> ready(later);
    std::priority_queue<Timed, std::vector<Timed>, std::greater<>> running;
    for (std::uint32_t t = 0; t < cut.tasks.size(); ++t) {
        missing.push_back(cut.tasks[t].after.size());
        if (missing[t] == 0) ready.push({left[t], t});
    }
    double now = 0;
    while (!ready.empty() || !running.empty()) {
        while (!ready.empty() && running.size() < machines) {
            const std::uint32_t t = ready.top().second;
            ready.pop();
            running.push({now + cut.tasks[t].seconds + overhead, t});
        }
        now = running.top().first;
        const std::uint32_t done = running.top().second;
        running.pop();
        for (const std::uint32_t t : dependants[done]) {
            if (--missing[t] == 0) ready.push({left[t], t});
        }
    }
    return now;
}

}  // namespace runtime
