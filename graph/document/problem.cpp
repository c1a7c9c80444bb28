#include "graph/document/problem.hpp"

#include "graph/document/other_names.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace graph {

std::string describe(const Place& place)
{
    if (place.line <= 0) return place.file;
    return fmt::format("{}:{}:{}", place.file, place.line, place.column);
}

std::string describe(const Problem& p)
{
    static constexpr std::array severities = {"note", "warning", "error"};
    static constexpr std::array parts = {"", "parameter", "input", "output"};
    std::string text = describe(p.place);
    if (!text.empty()) text += ": ";
    text += fmt::format("{}: ", severities[static_cast<std::size_t>(p.severity)]);
    if (!p.node.empty()) text += fmt::format("node '{}'", p.node);
    if (p.part != Part::none) {
        text += fmt::format("{}{} '{}'", p.node.empty() ? "" : ", ",
                            parts[static_cast<std::size_t>(p.part)], p.port);
    }
    if (!p.node.empty() || p.part != Part::none) text += ": ";

    const char* between = "";
    const auto append = [&](const std::string& clause) {
        text += between + clause;
        between = "; ";
    };
    if (!p.message.empty()) append(p.message);
    if (!p.expected.empty()) append("expected " + p.expected);
    if (!p.found.empty()) {
        if (!p.expected.empty()) between = ", ";
        append("found " + p.found);
    }
    if (!p.suggestion.empty()) append(p.suggestion);
    return text;
}

bool has_errors(std::span<const Problem> problems)
{
    return std::any_of(problems.begin(), problems.end(),
                       [](const Problem& p) { return p.severity == Severity::error; });
}

void Problems::add(Problem p)
{
    errors_ = errors_ || p.severity == Severity::error;
    if (full())
        ++dropped_;
    else
        list_.push_back(std::move(p));
}

std::set<std::string, std::less<>> Problems::wrong_nodes() const
{
    std::set<std::string, std::less<>> names;
    for (const Problem& p : list_) {
        if (p.severity == Severity::error) names.insert(p.node);
    }
    return names;
}

std::vector<Problem> Problems::take()
{
    std::map<std::string, std::size_t> files;  // in order of first mention
    for (const Problem& p : list_) files.try_emplace(p.place.file, files.size());
    std::stable_sort(list_.begin(), list_.end(), [&](const Problem& a, const Problem& b) {
        return std::tuple(files[a.place.file], a.place.line, a.place.column) <
               std::tuple(files[b.place.file], b.place.line, b.place.column);
    });
    if (dropped_ > 0) {
        Problem more;
        more.severity = errors_ ? Severity::error : Severity::warning;
        more.message = fmt::format("{} more problems are not shown", dropped_);
        list_.push_back(std::move(more));
    }
    dropped_ = 0;
    errors_ = false;
    return std::exchange(list_, {});
}

namespace {

char lower(char c)
{
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

// Insertions, deletions, replacements and swaps of neighbours that make `b` of `a` (optimal string
// alignment); `limit` + 1 as soon as it is certain to exceed `limit`.
std::size_t edit_distance(std::string_view a, std::string_view b, std::size_t limit)
{
    const std::size_t gap = a.size() > b.size() ? a.size() - b.size() : b.size() - a.size();
    if (gap > limit) return limit + 1;
    std::vector<std::size_t> before(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) above[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        row[0] = i;
        std::size_t least = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const bool same = lower(a[i - 1]) == lower(b[j - 1]);
            row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (same ? 0 : 1)});
            if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) &&
                lower(a[i - 2]) == lower(b[j - 1])) {
                row[j] = std::min(row[j], before[j - 2] + 1);
            }
            least = std::min(least, row[j]);
        }
        if (least > limit) return limit + 1;
        before.swap(above);
        above.swap(row);
    }
    return above[b.size()];
}

// "ReadMesh" as "read" and "mesh", "left_leg" as "left" and "leg".
std::vector<std::string> words_of(std::string_view name)
{
    std::vector<std::string> words;
    bool begins = true;
    for (std::size_t i = 0; i < name.size(); ++i) {
        const auto is = [&](std::size_t k, int (*kind)(int)) {
            return k < name.size() && kind(static_cast<unsigned char>(name[k])) != 0;
        };
        const bool in_capitals = i > 0 && is(i - 1, std::isupper) && !is(i + 1, std::islower);
        begins = begins || (is(i, std::isupper) && !in_capitals);
        if (!is(i, std::isalpha)) {
            begins = true;
            continue;
        }
        if (begins) words.emplace_back();
        words.back() += lower(name[i]);
        begins = false;
    }
    return words;
}

// Whether two names have a word in common, or one that the other's begins with.
bool share_word(const std::vector<std::string>& a, const std::vector<std::string>& b)
{
    constexpr std::size_t least = 3, least_of_longer = 4;
    for (const std::string& one : a) {
        for (const std::string& other : b) {
            const std::size_t common = std::min(one.size(), other.size());
            const bool whole = one.size() == other.size();
            if (common < (whole ? least : least_of_longer)) continue;
            if (one.compare(0, common, other, 0, common) == 0) return true;
        }
    }
    return false;
}

// The candidates of a long list that may be meant, the nearest first: those that share a word with
// the name, or three fifths of its letters. What is only less far off than others says nothing.
std::vector<std::string_view> akin_to(std::string_view name,
                                      std::span<const std::string_view> candidates)
{
    constexpr std::size_t very_long = 256, longest_name = 64;
    if (candidates.size() > very_long || name.size() > longest_name) return {};
    const std::vector<std::string> words = words_of(name);
    std::vector<std::pair<std::size_t, std::string_view>> found;
    for (const std::string_view candidate : candidates) {
        if (candidate.size() > longest_name) continue;
        const std::size_t most = 2 * std::max(name.size(), candidate.size()) / 5;
        const bool shares = share_word(words, words_of(candidate));
        const std::size_t d = edit_distance(name, candidate, shares ? longest_name : most);
        if (shares || d <= most) found.emplace_back(d, candidate);
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<std::string_view> names;
    for (const auto& [distance, candidate] : found) names.push_back(candidate);
    return names;
}

}  // namespace

std::string nearest(std::string_view name, std::span<const std::string_view> candidates)
{
    if (name.size() > 64) return {};
    std::size_t best = std::max<std::size_t>(1, name.size() / 3) + 1;
    std::string_view found;
    for (const std::string_view candidate : candidates) {
        const std::size_t d = edit_distance(name, candidate, best - 1);
        if (d < best && d < std::max(name.size(), candidate.size())) {
            best = d;
            found = candidate;
            if (d == 0) break;
        }
    }
    return std::string(found);
}

std::string suggest(std::string_view name, std::span<const std::string_view> candidates)
{
    const std::vector<std::string_view> own = own_names_of(name, candidates);
    if (!own.empty()) return fmt::format("did you mean '{}'?", fmt::join(own, "' or '"));
    const std::string near = nearest(name, candidates);
    if (!near.empty()) return fmt::format("did you mean '{}'?", near);
    if (candidates.empty()) return {};
    if (candidates.size() <= listed) return fmt::format("available: {}", list_names(candidates));
    const std::vector<std::string_view> akin = akin_to(name, candidates);
    if (akin.empty()) return {};
    std::string text;
    const std::size_t shown = std::min<std::size_t>(akin.size(), 5);
    for (std::size_t i = 0; i < shown; ++i) text += fmt::format("'{}', ", akin[i]);
    text.resize(text.size() - 2);
    return fmt::format("available: {} and {} more", text, candidates.size() - shown);
}

std::string list_names(std::span<const std::string_view> names, std::size_t most)
{
    std::string text;
    const std::size_t n = std::min(names.size(), most);
    for (std::size_t i = 0; i < n; ++i) {
        if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
        text += fmt::format("'{}'", names[i]);
    }
    if (n < names.size()) text += fmt::format(" and {} more", names.size() - n);
    return text;
}

}  // namespace graph
