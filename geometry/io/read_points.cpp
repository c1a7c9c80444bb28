#include "geometry/io/read_points.hpp"

#include "geometry/io/mesh_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace geometry {
namespace {

constexpr std::size_t most_numbers = 64;  // of a line that are read

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
        const auto [stop, error] = number_from(at, end, line.value[line.count]);
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

bool alike(std::string_view a, std::string_view b)
{
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
        return std::tolower(x) == std::tolower(y);
    });
}

// Where red, green and blue are in a line: in its last three numbers; by their names where there
// are names, nothing where those say nothing of colours.
std::optional<std::array<std::size_t, 3>> colour_columns(std::size_t columns,
                                                         const std::vector<std::string>& names)
{
    if (columns < 6) return {};
    if (names.size() != columns) return {{columns - 3, columns - 2, columns - 1}};
    constexpr std::array<std::array<std::string_view, 2>, 3> known{
        {{"r", "red"}, {"g", "green"}, {"b", "blue"}}};
    std::array<std::size_t, 3> out{};
    for (std::size_t k = 0; k < 3; ++k) {
        const auto is_it = [&](const std::string& name) {
            return alike(name, known[k][0]) || alike(name, known[k][1]);
        };
        const auto found = std::find_if(names.begin() + 3, names.end(), is_it);
        if (found == names.end()) return {};
        out[k] = static_cast<std::size_t>(found - names.begin());
    }
    return out;
}

// The colours of lines of as many numbers, while they may be that.
struct Colours {
    std::vector<Vec3f> all;
    std::optional<std::array<std::size_t, 3>> at;  // the columns
    bool possible = true, named = false;
    double largest = 0;
    std::size_t columns = 0;

    // `names`: of the columns, or as good as none.
    void add(const Line& line, const std::vector<std::string>& names)
    {
        if (columns == 0) {
            columns = line.count;
            named = names.size() == columns;
            at = colour_columns(columns, names);
        }
        possible = possible && line.count == columns && at;
        if (!possible) return;
        const std::array<double, 3> c{line.value[(*at)[0]], line.value[(*at)[1]],
                                      line.value[(*at)[2]]};
        possible = std::all_of(c.begin(), c.end(), is_byte);
        largest = std::max({largest, c[0], c[1], c[2]});
        all.emplace_back(float(c[0] / 255), float(c[1] / 255), float(c[2] / 255));
    }
    // Six columns of 0 and 1 are normals along the axes, unless their names say otherwise.
    bool are() const { return possible && !all.empty() && (columns > 6 || named || largest > 1); }
    // Those of a file that names its columns and has 0 and 1 alone are shares, not bytes.
    std::vector<Vec3f> taken()
    {
        if (named && largest <= 1) {
            for (Vec3f& c : all) c = (c.array() > 0).cast<float>();
        }
        return std::move(all);
    }
    bool have(std::size_t column) const
    {
        return are() && std::find(at->begin(), at->end(), column) != at->end();
    }
};

// What follows x, y and z, while each line has as many numbers.
struct FurtherColumns {
    std::vector<ImportedAttribute> all;
    std::size_t columns = 0;
    std::string warning;  // of the first line that has more or fewer

    // `names`: of the columns, or as good as none.
    void add(const Line& line, std::size_t number, const std::vector<std::string>& names)
    {
        if (columns == 0) {
            columns = line.count;
            for (std::size_t k = 3; k < columns; ++k) {
                const bool named = names.size() == columns && !names[k].empty();
                all.push_back({named ? names[k] : fmt::format("column{}", k + 1), {}});
            }
        }
        if (line.count != columns && warning.empty()) {
            warning = fmt::format("line {} has {} numbers where those before have {}: what follows "
                                  "x, y and z is left out. Give each line as many.",
                                  number, line.count, columns);
        }
        for (std::size_t k = 3; warning.empty() && k < columns; ++k) {
            all[k - 3].values.push_back(static_cast<float>(line.value[k]));
        }
    }
    // The first of each name, but for colours.
    std::vector<ImportedAttribute> taken(const Colours& colours)
    {
        std::vector<ImportedAttribute> out;
        for (std::size_t k = 0; warning.empty() && k < all.size(); ++k) {
            const auto same = [&](const ImportedAttribute& a) { return a.name == all[k].name; };
            if (colours.have(k + 3) || std::any_of(out.begin(), out.end(), same)) continue;
            out.push_back(std::move(all[k]));
        }
        return out;
    }
};

// A name without the spaces and the quotes around it.
std::string bare(std::string_view name)
{
    const auto strip = [&](std::string_view what) {
        const std::size_t begin = std::min(name.find_first_not_of(what), name.size());
        name = name.substr(begin, name.find_last_not_of(what) + 1 - begin);
    };
    strip(" \t\r");
    if (name.size() > 1 && (name[0] == '"' || name[0] == '\'') && name.back() == name[0]) {
        name = name.substr(1, name.size() - 2);
        strip(" \t\r");
    }
    return std::string(name);
}

// The names of columns: apart by commas or semicolons, or else by spaces; not within quotes.
std::vector<std::string> names_in(std::string_view text)
{
    const bool commas = text.find_first_of(",;") != std::string_view::npos;
    const auto parts = [&](char c) { return commas ? c == ',' || c == ';' : is_between(c); };
    std::vector<std::string> out;
    std::string field;
    char quote = 0;
    const auto end_field = [&] {
        if (commas || !field.empty()) out.push_back(bare(field));
        field.clear();
    };
    const auto blank = [](std::string_view of) {
        return of.find_first_not_of(" \t\r") == std::string_view::npos;
    };
    for (const char c : text) {
        if (c == quote) {
            quote = 0;
        } else if ((c == '"' || c == '\'') && blank(field)) {
            quote = c;
        } else if (quote == 0 && parts(c)) {
            end_field();
            continue;
        }
        field += c;
    }
    end_field();
    if (commas && out.back().empty()) out.pop_back();  // a comma at the end
    if (out.size() > most_numbers) out.resize(most_numbers);
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
    bytes = without_byte_order_mark(bytes);
    while (!bytes.empty()) {
        const std::size_t end = std::min(bytes.find('\n'), bytes.size());
        const std::string_view text = bytes.substr(0, end);
        bytes.remove_prefix(std::min(end + 1, bytes.size()));
        ++number;
        if (is_comment(text)) continue;
        const Line line = numbers_of(text);
        const bool is_first = ++used == 1;
        const bool is_names = is_first && !line.numbers_only && line.count == 0;
        if (is_names) names = names_in(text);
        if (is_names || (line.numbers_only && line.count == 1)) continue;
        if (!line.numbers_only || line.count < 3) {
            throw std::runtime_error(fmt::format("expected x, y and z in line {}, found \"{}\"",
                                                 number, text.substr(0, 60)));
        }
        mesh.positions.emplace_back(float(line.value[0]), float(line.value[1]),
                                    float(line.value[2]));
        colours.add(line, names);
        further.add(line, number, names);
    }
    mesh.attributes = further.taken(colours);
    if (colours.are()) mesh.colours = colours.taken();
    ImportedScene scene;
    if (!further.warning.empty()) scene.warnings.push_back(std::move(further.warning));
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
