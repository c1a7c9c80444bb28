#include "graph/document/source.hpp"

#include <algorithm>
#include <utility>

namespace graph {

namespace {

constexpr std::size_t block = 256;

}  // namespace

Source::Source(std::string name, std::filesystem::path folder, std::string text, bool lines)
    : name_(std::move(name)), folder_(std::move(folder)), text_(std::move(text)), lines_(lines)
{
    line_starts_.push_back(0);
    std::uint32_t characters = 0;
    for (std::size_t i = 0; i < text_.size(); ++i) {
        if (i % block == 0) characters_.push_back(characters);
        if (begins_character(text_[i])) ++characters;
        if (text_[i] == '\n') line_starts_.push_back(static_cast<std::uint32_t>(i + 1));
    }
}

std::size_t Source::characters_before(std::size_t offset) const
{
    if (characters_.empty()) return 0;
    const std::size_t b = std::min(offset / block, characters_.size() - 1);
    std::size_t count = characters_[b];
    for (std::size_t i = b * block; i < offset; ++i) count += begins_character(text_[i]) ? 1 : 0;
    return count;
}

Place Source::place(std::size_t offset) const
{
    if (!lines_) return {name_, 0, 0};
    offset = std::min(offset, text_.size());
    const auto after = std::upper_bound(line_starts_.begin(), line_starts_.end(), offset);
    const std::size_t start = *(after - 1);
    return {name_, static_cast<int>(after - line_starts_.begin()),
            static_cast<int>(characters_before(offset) - characters_before(start)) + 1};
}

}  // namespace graph
