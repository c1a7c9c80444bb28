#include "geometry/io/assimp/remembering_files.hpp"

#include <assimp/MemoryIOWrapper.h>

#include <algorithm>
#include <cstring>
#include <memory>

namespace geometry::assimp {

namespace fs = std::filesystem;

namespace {

// The first word of a line.
std::string word_of(const std::string& line)
{
    const std::size_t first = line.find_first_not_of(" \t");
    if (first == std::string::npos) return {};
    return line.substr(first, line.find_first_of(" \t\r", first) - first);
}

// A material library as assimp 5.2 can read it, both of what Blender writes: without lines on
// anisotropy, which it takes for ambient colours and gives up; and with white where a material has
// a picture and no colour, which it makes up as grey.
std::string readable_library(const std::string& text)
{
    std::string out;
    bool colour = false, picture = false;
    const auto end_material = [&] {
        if (picture && !colour) out += "Kd 1 1 1\n";
        colour = picture = false;
    };
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        const std::string line = text.substr(at, end - at);
        const std::string word = lower(word_of(line));  // assimp takes them in either case
        at = end + 1;
        if (word.starts_with("aniso")) continue;
        if (word == "newmtl") end_material();
        colour = colour || word == "kd";
        picture = picture || word == "map_kd";
        out += line + '\n';
    }
    end_material();
    return out;
}

std::string all_of(std::unique_ptr<Assimp::IOStream> file)
{
    std::string text(file->FileSize(), '\0');
    text.resize(file->Read(text.data(), 1, text.size()));
    return text;
}

Assimp::IOStream* stream_of(const std::string& text)
{
    auto* const bytes = new std::uint8_t[text.size() + 1];
    std::copy(text.begin(), text.end(), bytes);
    return new Assimp::MemoryIOStream(bytes, text.size(), true);
}

// Keeps the blanks within the names of an OBJ's objects; false where there are none.
bool keep_blanks(std::string& text)
{
    bool any = false;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        if (text[at] == 'o' && at + 1 < end && (text[at + 1] == ' ' || text[at + 1] == '\t')) {
            const std::size_t first = text.find_first_not_of(" \t\r", at + 1);
            const std::size_t last = text.find_last_not_of(" \t\r", end - 1);
            for (std::size_t i = first; i < last; ++i) {
                if (text[i] != ' ' && text[i] != '\t') continue;
                text[i] = kept_blank;
                any = true;
            }
        }
        at = end + 1;
    }
    return any;
}

bool is_blank(char c)
{
    return c == ' ' || c == '\t';
}

// Where the line around `at` begins. One that ends in a backslash goes on in the next.
std::size_t line_start(const std::string& text, std::size_t at)
{
    while (at > 0) {
        at = text.rfind('\n', at - 1);
        if (at == std::string::npos || at == 0) return at + 1;
        const std::size_t last = text.find_last_not_of('\r', at - 1);
        if (last == std::string::npos || text[last] != '\\') return at + 1;
    }
    return 0;
}

// Whether it is in a line of a position, normal or texture coordinates.
bool is_of_vertex(const std::string& text, std::size_t at)
{
    const std::size_t line = line_start(text, at);
    const std::string word = word_of(text.substr(line, at - line));
    return word == "v" || word == "vn" || word == "vt";
}

// Where the numbers of vertices begin with a point.
std::vector<std::size_t> bare_points(const std::string& text)
{
    std::vector<std::size_t> out;
    std::size_t line_end = 0;  // of the last line looked at
    bool of_vertex = false;
    const auto look = [&](std::size_t at) {
        const bool digit = at + 1 < text.size() && text[at + 1] >= '0' && text[at + 1] <= '9';
        if (text[at] != '.' || !(is_blank(text[at - 1]) || text[at - 1] == '\n') || !digit) return;
        if (at >= line_end) {
            of_vertex = is_of_vertex(text, at);
            line_end = std::min(text.find('\n', at), text.size());
        }
        if (of_vertex) out.push_back(at);
    };
    const char* const t = text.data();
    constexpr std::size_t block = 4096;
    for (std::size_t from = 1; from < text.size(); from += block) {
        const std::size_t to = std::min(from + block, text.size());
        bool any = false;  // most blocks have none: found without a branch, many at once
        for (std::size_t i = from; i < to; ++i) any |= (t[i] == '.') & (t[i - 1] <= ' ');
        for (std::size_t i = from; any && i < to; ++i) look(i);
    }
    return out;
}

// Writes 0.5 for the .5 of vertices: assimp 5.2 counts the numbers of a line that begin with a
// digit or a sign, and leaves out vertices of which others are too few. False where there are none.
bool complete_numbers(std::string& text)
{
    const std::vector<std::size_t> points = bare_points(text);
    std::string out;
    out.reserve(points.empty() ? 0 : text.size() + points.size());
    std::size_t from = 0;
    for (const std::size_t point : points) {
        out.append(text, from, point - from) += '0';
        from = point;
    }
    if (!points.empty()) text = out.append(text, from);
    return !points.empty();
}

}  // namespace

std::string lower(std::string text)
{
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

RememberingFiles::RememberingFiles(fs::path mesh, const fs::path& root,
                                   std::vector<ImportedFile>& files)
    : mesh_(std::move(mesh)), is_obj_(lower(mesh_.extension().string()) == ".obj"),
      root_(root.empty() ? root : fs::weakly_canonical(root)), files_(files)
{}

bool RememberingFiles::Exists(const char* path) const
{
    const bool found = allowed(path) && DefaultIOSystem::Exists(path);
    if (!found) remember(path, false);
    return found;
}

Assimp::IOStream* RememberingFiles::Open(const char* path, const char* mode)
{
    if (std::strchr(mode, 'w')) return nullptr;
    Assimp::IOStream* stream = allowed(path) ? DefaultIOSystem::Open(path, mode) : nullptr;
    remember(path, stream != nullptr);
    const bool numbered = lenses && path == mesh_;
    if (!stream || !(is_obj_ || numbered)) return stream;
    std::string text = all_of(std::unique_ptr<Assimp::IOStream>(stream));
    if (numbered) {
        *lenses = number_lenses(text);
        return stream_of(text);
    }
    // Whatever an OBJ opens beside itself, by any name, is a library.
    if (path != mesh_) return stream_of(readable_library(text));
    const bool blanks = keep_blanks(text), numbers = complete_numbers(text);
    if (blanks || numbers) return stream_of(text);
    text = {};
    return DefaultIOSystem::Open(path, mode);
}

bool RememberingFiles::allowed(const fs::path& path) const
{
    std::error_code none;
    if (!fs::is_regular_file(path, none)) return false;  // no folders, devices or pipes
    if (root_.empty() || path == mesh_) return true;
    const fs::path real = fs::weakly_canonical(path);
    return std::mismatch(root_.begin(), root_.end(), real.begin(), real.end()).first == root_.end();
}

void RememberingFiles::remember(const std::string& path, bool found) const
{
    for (ImportedFile& f : files_) {
        if (f.path == path) {
            f.found = f.found || found;
            return;
        }
    }
    files_.push_back({path, found});
}

}  // namespace geometry::assimp
