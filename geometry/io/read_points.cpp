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

// What follows x, y and z, while each line has as many numbers.
struct FurtherColumns {
    std::vector<ImportedAttribute> all;
    std::size_t columns = 0;
    bool possible = true;

    // `names`: the words of a first line that holds no number.
    void add(const Line& line, const std::vector<std::string>& names)
    {
        if (columns == 0) {
            columns = line.count;
            for (std::size_t k = 3; k < columns; ++k) {
                all.push_back(
                    {names.size() == columns ? names[k] : fmt::format("column{}", k + 1), {}});
            }
        }
        possible = possible && line.count == columns;
        for (std::size_t k = 3; possible && k < columns; ++k) {
            all[k - 3].values.push_back(static_cast<float>(line.value[k]));
        }
    }
    // The first of each name; but for the last three where those are colours.
    std::vector<ImportedAttribute> taken(bool colours)
    {
        std::vector<ImportedAttribute> out;
        const std::size_t end = all.size() - (colours ? std::min<std::size_t>(3, all.size()) : 0);
        for (std::size_t k = 0; possible && k < end; ++k) {
            const auto same = [&](const ImportedAttribute& a) { return a.name == all[k].name; };
            if (std::none_of(out.begin(), out.end(), same)) out.push_back(std::move(all[k]));
        }
        return out;
    }
};

std::vector<std::string> words_of(std::string_view text)
{
    std::vector<std::string> out;
    for (std::size_t i = 0; i < text.size();) {
        std::size_t end = i;
        while (end < text.size() && !is_between(text[end])) ++end;
        if (end > i) out.emplace_back(text.substr(i, end - i));
        i = end + 1;
    }
    return out;
}

}  // namespace

ImportedScene read_points(std::string_view bytes)
{
    ImportedMesh mesh;
    Colours colours;
    FurtherColumns further;
    std::vector<std::string> names;
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
        if (is_names) names = words_of(text);
        if (is_names || (line.numbers_only && line.count == 1)) continue;
        if (!line.numbers_only || line.count < 3) {
            throw std::runtime_error(fmt::format("expected x, y and z in line {}, found \"{}\"",
                                                 number, text.substr(0, 60)));
        }
        mesh.positions.emplace_back(float(line.value[0]), float(line.value[1]),
                                    float(line.value[2]));
        colours.add(line);
        further.add(line, names);
    }
    mesh.attributes = further.taken(colours.are());
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
