#include "geometry/io/read_points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

namespace geometry {
namespace {

constexpr std::size_t most_numbers = 16;

bool is_between(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == ',' || c == ';';
}

// The numbers of a line, and whether it holds nothing else.
struct Line {
    std::array<double, most_numbers> value{};
    std::size_t count = 0;
    bool numbers_only = true;
};

Line numbers_of(std::string_view text)
{
    Line line;
    const char *at = text.data(), *const end = text.data() + text.size();
    while (true) {
        while (at < end && is_between(*at)) ++at;
        if (at == end || line.count == most_numbers) return line;
        if (*at == '+') ++at;
        const auto [stop, error] = std::from_chars(at, end, line.value[line.count]);
        const bool is_number = error == std::errc() && (stop == end || is_between(*stop));
        if (!is_number) {
            line.numbers_only = false;
            return line;
        }
        ++line.count;
        at = stop;
    }
}

bool is_comment(std::string_view text)
{
    const std::size_t begin = text.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return true;
    return text[begin] == '#' || text.substr(begin, 2) == "//";
}

bool is_byte(double x)
{
    return x >= 0 && x <= 255 && x == std::floor(x);
}

// The colours in the last three of each line's numbers, while they may be that.
struct Colours {
    std::vector<Vec3f> all;
    bool possible = true;
    double largest = 0;
    std::size_t columns = 0;

    void add(const Line& line)
    {
        if (all.empty() && columns == 0) columns = line.count;
        possible = possible && line.count == columns && columns >= 6;
        if (!possible) return;
        const std::size_t first = columns - 3;
        const std::array<double, 3> c{line.value[first], line.value[first + 1],
                                      line.value[first + 2]};
        possible = std::all_of(c.begin(), c.end(), is_byte);
        largest = std::max({largest, c[0], c[1], c[2]});
        all.emplace_back(float(c[0] / 255), float(c[1] / 255), float(c[2] / 255));
    }
    // Six columns of 0 and 1 are normals along the axes.
    bool are() const { return possible && !all.empty() && (columns > 6 || largest > 1); }
};

}  // namespace

ImportedScene read_points(std::string_view bytes)
{
    ImportedMesh mesh;
    Colours colours;
    std::size_t number = 0, used = 0;
    while (!bytes.empty()) {
        const std::size_t end = std::min(bytes.find('\n'), bytes.size());
        const std::string_view text = bytes.substr(0, end);
        bytes.remove_prefix(std::min(end + 1, bytes.size()));
        ++number;
        if (is_comment(text)) continue;
        const Line line = numbers_of(text);
        const bool is_first = ++used == 1;
        const bool is_names = is_first && !line.numbers_only && line.count == 0;
        if (is_names || (line.numbers_only && line.count == 1)) continue;
        if (!line.numbers_only || line.count < 3) {
            throw std::runtime_error(fmt::format("expected x, y and z in line {}, found \"{}\"",
                                                 number, text.substr(0, 60)));
        }
        mesh.positions.emplace_back(float(line.value[0]), float(line.value[1]),
                                    float(line.value[2]));
        colours.add(line);
    }
    if (colours.are()) mesh.colours = std::move(colours.all);
    ImportedScene scene;
    scene.meshes.push_back(std::move(mesh));
    scene.nodes.push_back({"", 0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}});
    return scene;
}

bool is_points_file(const std::filesystem::path& path)
{
    std::string ending = path.extension().string();
    for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return ending == ".xyz" || ending == ".pts" || ending == ".asc";
}

}  // namespace geometry
