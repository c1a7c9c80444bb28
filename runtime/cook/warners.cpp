#include "runtime/cook/warners.hpp"

#include "graph/document/kept_rigid.hpp"

#include <algorithm>

namespace runtime {

namespace {

// A simulation that warns of something else at each frame is heard out so far.
constexpr std::size_t most_heard = 64;

}  // namespace

void Warners::Heap::add(const Key& key, std::uint32_t node, int frame, const Result& result)
{
    for (const std::string& text : result.warnings) {
        warners_.nodes_.emplace(key, node);
        add(node, {key, frame, text});
    }
    for (const Heard& heard : result.heard) add(warners_.find(heard, node), heard);
}

void Warners::Heap::add(std::uint32_t node, const Heard& heard)
{
    for (Entry& entry : entries_) {
        if (entry.node != node || entry.heard.text != heard.text) continue;
        if (heard.frame < entry.heard.frame) entry.heard = heard;
        return;
    }
    entries_.push_back({node, heard});
}

std::vector<Heard> Warners::Heap::take()
{
    std::stable_sort(entries_.begin(), entries_.end(),
                     [](const Entry& a, const Entry& b) { return a.heard.frame < b.heard.frame; });
    entries_.resize(std::min(entries_.size(), most_heard));
    std::vector<Heard> all;
    for (Entry& entry : entries_) all.push_back(std::move(entry.heard));
    return all;
}

std::vector<Warning> Warners::news(const Key& key, std::uint32_t node, int frame,
                                   const Result& result)
{
    std::vector<Warning> all;
    const auto tell = [&](std::uint32_t n, int f, const std::string& text) {
        if (!told_.insert({n, text}).second) return;
        if (text.starts_with(graph::of_bending) && graph::kept_rigid(graph_, n)) return;
        all.push_back({n, f, text});
    };
    for (const Heard& heard : result.heard) tell(find(heard, node), heard.frame, heard.text);
    if (!result.warnings.empty()) nodes_.emplace(key, node);
    for (const std::string& text : result.warnings) tell(node, frame, text);
    return all;
}

std::uint32_t Warners::find(const Heard& heard, std::uint32_t below)
{
    if (const auto known = nodes_.find(heard.from); known != nodes_.end()) return known->second;
    const auto gave = [&](std::uint32_t n) {
        return heard.frame >= graph_.range.first && keys_.at(n, heard.frame) == heard.from;
    };
    std::vector<std::uint32_t> ahead{below};
    std::set<std::uint32_t> seen{below};
    while (!ahead.empty()) {
        const std::uint32_t n = ahead.back();
        ahead.pop_back();
        if (gave(n)) return nodes_.emplace(heard.from, n).first->second;
        for (const auto& port : graph_.nodes[n].inputs) {
            for (const graph::Link& link : port) {
                if (seen.insert(link.node).second) ahead.push_back(link.node);
            }
        }
    }
    return nodes_.emplace(heard.from, below).first->second;
}

}  // namespace runtime
