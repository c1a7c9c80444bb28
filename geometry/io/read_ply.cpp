#include "geometry/io/read_ply.hpp"

#include "geometry/base/numbering.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/io/mesh_text.hpp"
#include "geometry/mesh/polygons.hpp"
#include "geometry/mesh/triangulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>

namespace geometry {
namespace {

enum class Kind { i8, u8, i16, u16, i32, u32, f32, f64 };

std::optional<Kind> kind_named(std::string_view name)
{
    constexpr std::array<std::string_view, 16> names{
        "char", "int8",  "uchar", "uint8",  "short", "int16",   "ushort", "uint16",
        "int",  "int32", "uint",  "uint32", "float", "float32", "double", "float64"};
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) return {};
    return static_cast<Kind>((found - names.begin()) / 2);
}

struct Property {
    std::string name;
    Kind kind = Kind::f32;
    std::optional<Kind> list;  // of the count, when it is a list
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

enum class Format { ascii, little, big };

std::string_view next_line(std::string_view& rest)
{
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    return line;
}

std::string_view next_word(std::string_view& line)
{
    const auto is_space = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
    std::size_t begin = 0;
    while (begin < line.size() && is_space(line[begin])) ++begin;
    std::size_t end = begin;
    while (end < line.size() && !is_space(line[end])) ++end;
    const std::string_view word = line.substr(begin, end - begin);
    line.remove_prefix(end);
    return word;
}

struct Header {
    Format format = Format::ascii;
    std::vector<Element> elements;
    std::string texture;  // of "comment TextureFile wood.png", as MeshLab writes it
};

[[noreturn]] void refuse(std::string_view line)
{
    throw std::runtime_error(
        fmt::format("a line of its header is not PLY: \"{}\"", line.substr(0, 80)));
}

// `words`: of the line, after "element".
Element element_in(std::string_view line, std::string_view words,
                   const std::vector<Element>& before)
{
    Element element;
    element.name = next_word(words);
    const std::string_view count = next_word(words);
    const auto end = count.data() + count.size();
    if (count.empty() || std::from_chars(count.data(), end, element.count).ptr != end) {
        refuse(line);
    }
    const auto vertices = [](const Element& e) { return e.name == "vertex"; };
    if (vertices(element) && std::any_of(before.begin(), before.end(), vertices)) {
        throw std::runtime_error(fmt::format(
            "its header has a second element of vertices, \"{}\", where one was expected: join the "
            "two, or write them to two files",
            line.substr(0, 80)));
    }
    return element;
}

Header read_header(std::string_view& rest)
{
    if (next_line(rest) != "ply") throw std::runtime_error("expected \"ply\" as its first line");
    Header header;
    while (!rest.empty()) {
        const std::string_view line = next_line(rest);
        std::string_view words = line;
        const std::string_view first = next_word(words);
        if (first == "end_header") return header;
        if (first == "format") {
            const std::string_view format = next_word(words);
            if (format == "ascii") {
                header.format = Format::ascii;
            } else if (format == "binary_little_endian") {
                header.format = Format::little;
            } else if (format == "binary_big_endian") {
                header.format = Format::big;
            } else {
                refuse(line);
            }
        } else if (first == "element") {
            header.elements.push_back(element_in(line, words, header.elements));
        } else if (first == "property") {
            Property property;
            std::string_view kind = next_word(words);
            if (kind == "list") {
                property.list = kind_named(next_word(words));
                if (!property.list) refuse(line);
                kind = next_word(words);
            }
            const auto known = kind_named(kind);
            if (!known || header.elements.empty()) refuse(line);
            property.kind = *known;
            property.name = next_word(words);
            header.elements.back().properties.push_back(property);
        } else if (first == "comment" && next_word(words) == "TextureFile") {
            header.texture = words.substr(std::min(words.size(), words.find_first_not_of(' ')));
        } else if (!first.empty() && first != "comment" && first != "obj_info") {
            refuse(line);
        }
    }
    throw std::runtime_error("it is cut short: its header has no \"end_header\"");
}

// Numbers one after the other, from text or bytes.
class Numbers {
public:
    Numbers(std::string_view rest, Format format) : rest_(rest), format_(format) {}

    double next(Kind kind) { return format_ == Format::ascii ? from_text() : from_bytes(kind); }
    std::size_t bytes_left() const { return rest_.size(); }

    // Words of the text that are no numbers, and the first of them. NaN stands for each.
    std::uint64_t unread = 0;
    std::string first_unread;

    struct CutShort {};

private:
    double from_text()
    {
        const std::string_view word = next_word(rest_);
        if (word.empty()) throw CutShort();
        const char *begin = word.data() + (word[0] == '+'), *end = word.data() + word.size();
        double value = 0;
        const auto [stop, error] = number_from(begin, end, value);
        if (error == std::errc() && stop == end) return value;
        if (unread++ == 0) first_unread = word.substr(0, 40);
        return std::numeric_limits<double>::quiet_NaN();
    }
    template <class T> double take()
    {
        if (rest_.size() < sizeof(T)) throw CutShort();
        std::array<char, sizeof(T)> bytes;
        std::memcpy(bytes.data(), rest_.data(), sizeof(T));
        if (format_ == Format::big) std::reverse(bytes.begin(), bytes.end());
        rest_.remove_prefix(sizeof(T));
        return static_cast<double>(std::bit_cast<T>(bytes));
    }
    double from_bytes(Kind kind)
    {
        switch (kind) {
        case Kind::i8:
            return take<std::int8_t>();
        case Kind::u8:
            return take<std::uint8_t>();
        case Kind::i16:
            return take<std::int16_t>();
        case Kind::u16:
            return take<std::uint16_t>();
        case Kind::i32:
            return take<std::int32_t>();
        case Kind::u32:
            return take<std::uint32_t>();
        case Kind::f32:
            return take<float>();
        case Kind::f64:
            return take<double>();
        }
        return 0;
    }

    std::string_view rest_;
    Format format_;
};

// What a property of a vertex fills: component `part` of `what`, or attribute `part`.
struct Target {
    enum class What { nothing, position, normal, colour, uv, own } what = What::nothing;
    int part = 0;
    double scale = 1;
};

Target target_of(const Property& property)
{
    using What = Target::What;
    std::string_view name = property.name;
    if (name.starts_with("diffuse_")) name.remove_prefix(8);
    const auto part = [&](std::initializer_list<std::string_view> names) {
        const auto found = std::find(names.begin(), names.end(), name);
        return found == names.end() ? -1 : static_cast<int>(found - names.begin());
    };
    const double most = property.kind == Kind::u8 ? 255 : property.kind == Kind::u16 ? 65535 : 1;
    if (property.list) return {};
    if (const int k = part({"x", "y", "z"}); k >= 0) return {What::position, k, 1};
    if (const int k = part({"nx", "ny", "nz"}); k >= 0) return {What::normal, k, 1};
    if (const int k = part({"red", "green", "blue"}); k >= 0) return {What::colour, k, 1 / most};
    if (const int k = part({"r", "g", "b"}); k >= 0) return {What::colour, k, 1 / most};
    if (const int k = part({"s", "t"}); k >= 0) return {What::uv, k, 1};
    if (const int k = part({"u", "v"}); k >= 0) return {What::uv, k, 1};
    if (const int k = part({"texture_u", "texture_v"}); k >= 0) return {What::uv, k, 1};
    return {};
}

// The same for all properties of vertices. Numbers that mean nothing here become attributes, the
// first of each name.
std::vector<Target> targets_of(const Element& element, ImportedMesh& mesh)
{
    std::vector<Target> targets;
    for (const Property& p : element.properties) {
        Target target = target_of(p);
        const auto taken =
            std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
                         [&](const ImportedAttribute& a) { return a.name == p.name; });
        if (target.what == Target::What::nothing && !p.list && !p.name.empty() &&
            taken == mesh.attributes.end()) {
            target = {Target::What::own, static_cast<int>(mesh.attributes.size()), 1};
            mesh.attributes.push_back({p.name, {}});
        }
        targets.push_back(target);
    }
    return targets;
}

std::uint64_t list_length(Numbers& numbers, const Property& property)
{
    const double n = numbers.next(*property.list);
    if (!(n >= 0)) throw std::runtime_error("a list in it has a negative length");
    // Each entry takes a byte at least.
    if (n > double(numbers.bytes_left())) throw Numbers::CutShort();
    return static_cast<std::uint64_t>(n);
}

void skip(Numbers& numbers, const Property& property)
{
    const std::uint64_t n = property.list ? list_length(numbers, property) : 1;
    for (std::uint64_t i = 0; i < n; ++i) numbers.next(property.kind);
}

void read_vertex(Numbers& numbers, const Element& element, const std::vector<Target>& targets,
                 ImportedMesh& mesh)
{
    Vec3f position(0, 0, 0), normal(0, 0, 0), colour(0, 0, 0);
    Vec2f uv(0, 0);
    for (std::size_t i = 0; i < targets.size(); ++i) {
        const Target& t = targets[i];
        if (t.what == Target::What::nothing) {
            skip(numbers, element.properties[i]);
            continue;
        }
        const auto value = static_cast<float>(t.scale * numbers.next(element.properties[i].kind));
        switch (t.what) {
        case Target::What::position:
            position[t.part] = value;
            break;
        case Target::What::normal:
            normal[t.part] = value;
            break;
        case Target::What::colour:
            colour[t.part] = value;
            break;
        case Target::What::uv:
            uv[t.part] = value;
            break;
        case Target::What::own:
            mesh.attributes[static_cast<std::size_t>(t.part)].values.push_back(value);
            break;
        case Target::What::nothing:
            break;
        }
    }
    const auto has = [&](Target::What what) {
        return std::any_of(targets.begin(), targets.end(),
                           [&](const Target& t) { return t.what == what; });
    };
    mesh.positions.push_back(position);
    if (has(Target::What::normal)) mesh.normals.push_back(normal);
    if (has(Target::What::colour)) mesh.colours.push_back(colour);
    if (has(Target::What::uv)) mesh.uvs.push_back(uv);
}

void read_list(Numbers& numbers, const Property& property, std::vector<std::int64_t>& out)
{
    const std::uint64_t n = list_length(numbers, property);
    out.clear();
    for (std::uint64_t i = 0; i < n; ++i) {
        const double x = numbers.next(property.kind);
        const bool index = x >= -1 && x < 4294967295.0 && x == std::floor(x);
        out.push_back(index ? static_cast<std::int64_t>(x) : 4294967294);
    }
}

// Texture coordinates of corners. A vertex has those of the first corner that names it; a corner
// with others names a copy of it, after all vertices, which assemble_mesh() welds to it again.
struct CornerCoordinates {
    std::vector<float> list;  // of the face being read: u and v of each corner
    std::vector<bool> given;  // of the vertices
    std::map<std::array<std::uint32_t, 3>, std::uint32_t> copies;  // by vertex and bits of u, v

    std::uint32_t corner(std::uint32_t v, std::size_t k, ImportedMesh& mesh)
    {
        if (v >= mesh.uvs.size()) return v;
        const Vec2f uv(list[2 * k], list[2 * k + 1]);
        if (given.size() < mesh.uvs.size()) given.resize(mesh.uvs.size());
        if (!given[v]) mesh.uvs[v] = uv;
        given[v] = true;
        if (bits(mesh.uvs[v]) == bits(uv)) return v;
        const auto next = static_cast<std::uint32_t>(mesh.positions.size());
        const auto b = bits(uv);
        const auto [at, is_new] = copies.try_emplace({v, b[0], b[1]}, next);
        if (is_new) {
            mesh.positions.push_back(Vec3f(mesh.positions[v]));
            if (v < mesh.normals.size()) mesh.normals.push_back(Vec3f(mesh.normals[v]));
            if (v < mesh.colours.size()) mesh.colours.push_back(Vec3f(mesh.colours[v]));
            mesh.uvs.push_back(uv);
            for (ImportedAttribute& a : mesh.attributes) {
                a.values.push_back(v < a.values.size() ? float(a.values[v]) : 0.f);
            }
            given.push_back(true);
            ++mesh.copies;
        }
        return at->second;
    }
};

// What is kept from one element to the next.
struct Lists {
    std::vector<std::int64_t> indices;
    CornerCoordinates coordinates;
};

void read_coordinates(Numbers& numbers, const Property& property, std::vector<float>& out)
{
    const std::uint64_t n = list_length(numbers, property);
    out.clear();
    for (std::uint64_t i = 0; i < n; ++i) {
        out.push_back(static_cast<float>(numbers.next(property.kind)));
    }
}

// A polygon, whose corners may name vertices that are not there: assemble_mesh() counts those.
void add_face(Lists& lists, ImportedMesh& mesh)
{
    const std::vector<std::int64_t>& list = lists.indices;
    CornerCoordinates& at = lists.coordinates;
    std::vector<std::uint32_t> corner;
    if (!at.list.empty() && mesh.uvs.empty()) {
        mesh.uvs.assign(mesh.positions.size(), Vec2f(Vec2f::Zero()));
    }
    const bool has_coordinates = !list.empty() && at.list.size() == 2 * list.size() &&
                                 mesh.uvs.size() == mesh.positions.size();
    for (std::size_t k = 0; k < list.size(); ++k) {
        const auto v = static_cast<std::uint32_t>(list[k]);
        corner.push_back(has_coordinates ? at.corner(v, k, mesh) : v);
    }
    if (corner.size() == 2) ++mesh.lines;
    const std::size_t before = mesh.triangles.size();
    triangulate(corner, mesh.positions, mesh.triangles);
    add_polygon(mesh.polygon, mesh.triangles.size() - before);
}

// Strips of triangles, every other one turned over; -1 begins a new strip.
void add_strips(const std::vector<std::int64_t>& list, ImportedMesh& mesh)
{
    std::size_t begin = 0;
    for (std::size_t i = 0; i < list.size(); ++i) {
        if (list[i] < 0) {
            begin = i + 1;
        } else if (i >= begin + 2) {
            const bool turned = (i - begin) % 2 == 1;
            const auto at = [&](std::size_t k) { return static_cast<std::uint32_t>(list[k]); };
            add_polygon(mesh.polygon, 1);
            mesh.triangles.push_back(turned ? Triangle{at(i - 1), at(i - 2), at(i)}
                                            : Triangle{at(i - 2), at(i - 1), at(i)});
        }
    }
}

void read_one(Numbers& numbers, const Element& element, const std::vector<Target>& targets,
              Lists& lists, ImportedMesh& mesh)
{
    if (element.name == "vertex") return read_vertex(numbers, element, targets, mesh);
    const bool face = element.name == "face";
    lists.indices.clear();
    lists.coordinates.list.clear();
    for (const Property& p : element.properties) {
        const bool indices = p.list && (p.name == "vertex_indices" || p.name == "vertex_index");
        if (indices && (face || element.name == "tristrips")) {
            read_list(numbers, p, lists.indices);
        } else if (face && p.list && p.name == "texcoord") {
            read_coordinates(numbers, p, lists.coordinates.list);
        } else {
            skip(numbers, p);
        }
    }
    if (face) add_face(lists, mesh);
    if (element.name == "tristrips") add_strips(lists.indices, mesh);
}

}  // namespace

bool has_meaning_in_ply(std::string_view name)
{
    return target_of({std::string(name), Kind::f32, {}}).what != Target::What::nothing;
}

ImportedScene read_ply(std::string_view bytes)
{
    bytes = without_byte_order_mark(bytes);
    const Header header = read_header(bytes);
    Numbers numbers(bytes, header.format);
    ImportedScene scene;
    ImportedMesh mesh;
    Lists lists;
    std::string unread_in;  // the first of them: "vertex 3"

    for (const Element& element : header.elements) {
        if (element.properties.empty()) continue;  // however many, they hold nothing
        const std::vector<Target> targets = element.name == "vertex"
                                                ? targets_of(element, mesh)
                                                : std::vector<Target>(element.properties.size());
        StopCheck check;
        for (std::uint64_t i = 0; i < element.count; ++i) {
            check();
            try {
                read_one(numbers, element, targets, lists, mesh);
            } catch (const Numbers::CutShort&) {
                throw std::runtime_error(
                    fmt::format("it is cut short: its header announces {} of element {}, and the "
                                "file ends in number {}: copy or export it again",
                                element.count, element.name, i + 1));
            }
            if (numbers.unread > 0 && unread_in.empty()) {
                unread_in = fmt::format("{} {}", element.name, i + 1);
            }
        }
    }
    if (numbers.unread > 0) {
        scene.warnings.push_back(fmt::format(
            "{} of its words {} no number, the first is \"{}\" in {}: write numbers like 1.5.",
            numbers.unread, numbers.unread == 1 ? "is" : "are", numbers.first_unread, unread_in));
    }
    if (has_triangles_only(mesh.polygon)) mesh.polygon.clear();
    scene.meshes.push_back(std::move(mesh));
    if (!header.texture.empty()) {
        scene.materials.emplace_back().colour.setOnes();
        scene.materials[0].picture.path = header.texture;
    }
    scene.nodes.push_back({"", 0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}});
    return scene;
}

}  // namespace geometry
