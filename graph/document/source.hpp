#pragma once

// The text that values come from, and where in it a byte stands for people.

#include "graph/document/problem.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace graph {

// Whether a UTF-8 character begins with this byte.
inline bool begins_character(char c)
{
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
}

// A text, and an index from byte offsets to lines and columns.
class Source {
public:
    // `lines`: whether places in it have lines and columns (a command line's have not).
    Source(std::string name, std::filesystem::path folder, std::string text, bool lines = true);

    Place place(std::size_t offset) const;
    const std::string& name() const { return name_; }
    const std::filesystem::path& folder() const { return folder_; }  // relative paths start here
    const std::string& text() const { return text_; }

private:
    std::size_t characters_before(std::size_t offset) const;

    std::string name_;
    std::filesystem::path folder_;
    std::string text_;
    bool lines_;
    std::vector<std::uint32_t> line_starts_;
    std::vector<std::uint32_t> characters_;  // before every 256th byte
};

}  // namespace graph
