#include "geometry/ply_length.hpp"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <vector>

namespace geometry {
namespace {

struct Element {
    std::uint64_t count = 0;
    std::uint64_t least_bytes = 0;  // of one, in a binary file: a list may be empty
};

struct Header {
    bool ascii = false;
    std::vector<Element> elements;
};

// False when it is no PLY header.
bool read_header(std::istream& in, Header& out)
{
    static const std::map<std::string, std::uint64_t> size{
        {"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},  {"short", 2}, {"ushort", 2},
        {"int16", 2}, {"uint16", 2},  {"int", 4},    {"uint", 4},   {"int32", 4}, {"uint32", 4},
        {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
    std::string line;
    for (int number = 0; number < 10'000 && std::getline(in, line); ++number) {
        std::istringstream words(line);
        std::string first, type;
        words >> first;
        if (number == 0 && first != "ply") return false;
        if (first == "format") {
            words >> type;
            out.ascii = type == "ascii";
        } else if (first == "element") {
            Element element;
            if (!(words >> type >> element.count)) return false;
            out.elements.push_back(element);
        } else if (first == "property") {
            words >> type;
            if (type == "list") words >> type;
            const auto found = size.find(type);
            if (found == size.end() || out.elements.empty()) return false;
            out.elements.back().least_bytes += found->second;
        } else if (first == "end_header") {
            return true;
        }
    }
    return false;
}

}  // namespace

std::string what_ply_lacks(const std::filesystem::path& path)
{
    std::ifstream in(path, std::ios::binary);
    Header header;
    if (!read_header(in, header)) return "";
    const auto start = static_cast<std::uint64_t>(in.tellg());
    const std::uint64_t follows = std::filesystem::file_size(path) - start;

    // In text every element has a line of its own, of two bytes at least; so a header of nonsense
    // is found out before the lines are counted.
    double needed = 0, elements = 0;
    for (const Element& e : header.elements) {
        elements += double(e.count);
        needed += double(e.count) * double(header.ascii ? 1 : e.least_bytes);
    }
    const auto lacks = [&](const std::string& kind, double wanted, std::uint64_t found) {
        char text[200];
        std::snprintf(text, sizeof text, "its header announces %.0f %s at least, only %.0f follow",
                      wanted, kind.c_str(), double(found));
        return std::string(text);
    };
    if (needed > double(follows)) return lacks("bytes", needed, follows);
    if (!header.ascii) return "";

    std::uint64_t lines = 0;
    bool text = false;  // on the line being read
    std::vector<char> piece(1 << 16);
    while (in.read(piece.data(), std::ssize(piece)) || in.gcount() > 0) {
        for (std::streamsize i = 0; i < in.gcount(); ++i) {
            const char c = piece[std::size_t(i)];
            if (c == '\n' || c == '\r') {
                lines += text;
                text = false;
            } else if (c != ' ' && c != '\t') {
                text = true;
            }
        }
    }
    lines += text;
    return double(lines) < elements ? lacks("lines", elements, lines) : "";
}

}  // namespace geometry
