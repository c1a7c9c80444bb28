#include "nodes/mesh_info.hpp"

#include "geometry/io/find_textures.hpp"
#include "geometry/io/read_mesh.hpp"
#include "geometry/mesh/doubled_faces.hpp"
#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "geometry/mesh/pieces.hpp"
#include "geometry/mesh/polygons.hpp"
#include "geometry/mesh/solid_faces.hpp"
#include "graph/types/context.hpp"
#include "nodes/filled_between.hpp"
#include "nodes/large_cubes.hpp"
#include "physics/bricks/bending_error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace nodes {
namespace {

using Json = nlohmann::ordered_json;

constexpr double most_cubes = 50'000;  // of what is suggested: a step of them takes some 0.1 s

struct NamedUnit {
    const char* name;
    geometry::LengthUnit unit;
    double metres;
};
constexpr std::array units{
    NamedUnit{"auto", geometry::LengthUnit::automatic, 0},
    NamedUnit{"m", geometry::LengthUnit::metre, 1},
    NamedUnit{"cm", geometry::LengthUnit::centimetre, 0.01},
    NamedUnit{"mm", geometry::LengthUnit::millimetre, 0.001},
    NamedUnit{"inch", geometry::LengthUnit::inch, 0.0254},
    NamedUnit{"foot", geometry::LengthUnit::foot, 0.3048},
};

std::string unit_name(double metres)
{
    for (const NamedUnit& u : units) {
        if (std::abs(metres - u.metres) <= 1e-6 * metres) return u.name;
    }
    return fmt::format("{:.6g} m", metres);
}

double two_digits_below(double x)
{
    const double digit = std::pow(10, std::floor(std::log10(x)) - 1);
    return std::floor(x / digit * (1 + 1e-12)) * digit;
}

double two_digits_above(double x)
{
    const double digit = std::pow(10, std::floor(std::log10(x)) - 1);
    return std::ceil(x / digit * (1 - 1e-12)) * digit;
}

// About how many cubes of a size there are: the volume's, and of those that the surface passes, one
// and a half a square of it on average over directions, the half that lies outside.
double cube_count(const MeshInfo& info, double size)
{
    const double volume = info.closed ? std::abs(info.body.mass) : 0;
    const double of_surface = info.area / (size * size) * (info.closed ? 0.75 : 1.5);
    return std::max(1.0, volume / (size * size * size) + of_surface);
}

void advise(MeshInfo& info)
{
    const double longest = info.box.size().maxCoeff();
    if (!(longest > 0) || info.triangles == 0) return;
    double size = two_digits_below(longest / 32);
    if (info.thinnest) size = std::min(size, physics::size_for_wall(info.thinnest->thickness));
    const CubeAdvice best{size, cube_count(info, size)};
    info.cubes = best;
    if (best.count <= most_cubes) return;
    double low = size, high = longest;
    for (int i = 0; i < 40; ++i) {
        const double middle = std::sqrt(low * high);
        (cube_count(info, middle) > most_cubes ? low : high) = middle;
    }
    const double coarse = std::max(size, two_digits_above(high));
    info.cubes = {coarse, cube_count(info, coarse)};
    info.fine = best;
}

// The faces as Voxelize and Sample take them: doubled ones once, and those that are wound against
// the rest turned over, so that they bound no holes. Where all are wound inwards it is the mesh
// itself.
geometry::TriMesh mended(const geometry::TriMesh& mesh, MeshInfo& info)
{
    const geometry::SolidFaces faces = geometry::solid_faces(mesh);
    info.doubled = faces.doubled + geometry::count_sheet_backs(mesh);
    const bool all = faces.turned == faces.triangles.size();
    if (faces.doubled == 0 && (faces.turned == 0 || all)) return mesh;
    info.turned = all ? 0 : faces.turned;
    return mesh_of(mesh, faces);
}

void measure_surface(const geometry::TriMesh& as_read, MeshInfo& info)
{
    if (as_read.triangles().empty()) return;
    info.disagreeing = geometry::disagreeing_edges(as_read.triangles(), as_read.positions.size());
    const geometry::TriMesh mesh = mended(as_read, info);
    const std::size_t count = mesh.positions.size();
    const auto& triangles = mesh.triangles();
    info.closed = geometry::is_closed(triangles, count);
    info.pieces = geometry::find_pieces(mesh).count();
    const auto once = geometry::without_doubled(as_read);
    info.area = geometry::surface_area(once ? once->mesh : mesh);
    for (const auto& rim : geometry::border_loops(triangles, count)) {
        ++info.holes;
        double length = 0;
        for (std::size_t i = 0; i < rim.size(); ++i) {
            const geometry::Vec3f side =
                mesh.positions[rim[i]] - mesh.positions[rim[(i + 1) % rim.size()]];
            length += side.cast<double>().norm();
        }
        info.longest_rim = std::max(info.longest_rim, length);
    }
    info.shell = find_filled_shell(mesh, geometry::Inside::winding, 0).filled();
    info.between = find_filled_between(mesh, geometry::Inside::winding).pieces;
    if (info.closed) {
        constexpr double nothing = 1e-9;  // of area^1.5, as rounding leaves
        info.body = geometry::mass_properties(mesh);
        info.two_sided =
            std::abs(info.body.mass) <= nothing * std::pow(geometry::surface_area(mesh), 1.5);
        info.closed = !info.two_sided;
    }
    if (const auto wall = physics::thinnest_wall(mesh)) {
        info.thinnest = MeshInfo::Wall{wall->thickness, wall->name, wall->where};
    }
}

// Whether the picture is there for ReadMesh.
bool is_there(const std::filesystem::path& model, const std::string& name)
{
    if (name.starts_with("*")) return true;  // within the model's file
    const auto places =
        geometry::picture_places(name, std::filesystem::absolute(model).parent_path());
    return std::any_of(places.begin(), places.end(), [](const auto& place) {
        std::error_code none;
        return std::filesystem::is_regular_file(place, none);
    });
}

std::array<std::size_t, 3> count_polygons(const geometry::MeshTopology& topology)
{
    std::array<std::size_t, 3> count{};
    const geometry::Outlines faces = geometry::outlines(topology);
    for (std::size_t p = 0; p < faces.count(); ++p) {
        ++count[std::min<std::size_t>(faces[p].size(), 5) - 3];
    }
    return count;
}

std::string polygons_text(const std::array<std::size_t, 3>& count)
{
    constexpr std::array names{"triangle", "quad", "larger polygon"};
    std::string text;
    for (std::size_t i : {1u, 2u, 0u}) {
        if (count[i] == 0) continue;
        text += fmt::format("{}{} {}{}", text.empty() ? "" : ", ", count[i], names[i],
                            count[i] == 1 ? "" : "s");
    }
    return text;
}

std::string length_text(double metres)
{
    return fmt::format("{:.4g} m", metres);
}

std::string joined(const std::vector<std::string>& names, const char* none)
{
    constexpr std::size_t shown = 12;
    if (names.empty()) return none;
    std::string text = fmt::format("{}: ", names.size());
    for (std::size_t i = 0; i < std::min(names.size(), shown); ++i) {
        text += (i > 0 ? ", " : "") + (names[i].empty() ? "(no name)" : names[i]);
    }
    return names.size() > shown ? text + ", ..." : text;
}

std::string unit_text(const MeshInfo& info)
{
    const std::string read = unit_name(info.read_unit);
    if (info.stated_unit > 0) {
        const std::string stated = unit_name(info.stated_unit);
        if (info.converted) return stated + ", from the unit that the file states";
        return stated + ", as the file states" + (stated == read ? "" : "; read here as " + read);
    }
    std::string text = "not stated by the file; read here as " + read;
    const double longest = info.box.size().maxCoeff();
    if (info.unit.name != read && longest > 0) {
        text += fmt::format("; if {} is too long, set `unit` of ReadMesh: in {} it is {}",
                            length_text(longest), info.unit.name,
                            length_text(longest / info.read_unit * info.unit.metres));
    }
    return text;
}

std::string surface_text(const MeshInfo& info)
{
    if (info.triangles == 0) return "none: points only";
    std::string text = "closed";
    if (info.two_sided) {
        text = "open, each face with one that looks the other way: it encloses nothing";
    } else if (!info.closed) {
        text = info.holes == 1 ? "open: 1 hole" : fmt::format("open: {} holes", info.holes);
        text += fmt::format(", the longest rim {}", length_text(info.longest_rim));
        if (info.shell) {
            text += ". Voxelize fills it up to the rim with method = solid: for a shell, set "
                    "method = surface and its thickness";
        }
        if (info.between > 0) {
            text += fmt::format(". Voxelize takes what lies between {} of its open pieces for a "
                                "solid with method = solid: for leaves, set pieces = each, or "
                                "method = surface and its thickness",
                                info.between);
        }
    }
    if (info.closed && info.body.mass < 0) text += ", but its faces look inward";
    if (info.turned > 0) {
        text += fmt::format("; {} of its triangles {} wound the other way round than the rest: "
                            "Voxelize and Sample turn them over",
                            info.turned, info.turned == 1 ? "is" : "are");
    } else if (info.disagreeing > 0) {  // a strip that has one side
        text += fmt::format("; faces on {} edges disagree on what is outside", info.disagreeing);
    }
    if (info.doubled > 0) {
        text += fmt::format("; {} {} on another one: Voxelize, Sample, Sheet and Collider count "
                            "both as one",
                            info.doubled, info.doubled == 1 ? "triangle lies" : "triangles lie");
    }
    return text;
}

std::string cubes_text(const MeshInfo& info)
{
    const auto advice = [](const CubeAdvice& cubes) {
        const double digit = std::pow(10, std::max(0.0, std::floor(std::log10(cubes.count)) - 1));
        return fmt::format("{:.2g} m (about {:.0f})", cubes.size,
                           std::round(cubes.count / digit) * digit);
    };
    if (info.cubes.size == 0) return "none";
    std::string text = advice(info.cubes);
    if (info.fine.size > 0 && info.thinnest) {
        text += fmt::format("; its thinnest wall is then {:.2g} cubes thick, and bends rightly in "
                            "cubes of {}",
                            info.thinnest->thickness / info.cubes.size, advice(info.fine));
    }
    return text;
}

Json vector_json(const geometry::Vec3& v)
{
    return {v.x(), v.y(), v.z()};
}

Json cubes_json(const CubeAdvice& cubes)
{
    return cubes.size > 0 ? Json{{"size", cubes.size}, {"count", std::round(cubes.count)}} : Json();
}

Json body_json(const MeshInfo& info)
{
    if (!info.closed) return {};
    Json inertia = Json::array();
    for (int i = 0; i < 3; ++i) inertia.push_back(vector_json(info.body.inertia.row(i)));
    return {{"volume", info.body.mass},
            {"centre", vector_json(info.body.centre)},
            {"inertia", inertia}};
}

}  // namespace

FileUnit guess_unit(double longest)
{
    constexpr double largest = 50;  // m
    for (const auto& [name, metres] : {std::pair{"m", 1.0}, {"cm", 0.01}}) {
        if (longest * metres <= largest) return {name, metres};
    }
    return {"mm", 0.001};
}

MeshInfo mesh_info(const std::filesystem::path& file, const geometry::ReadOptions& options)
{
    const geometry::ReadMesh read = geometry::read_mesh(file, options);
    MeshInfo info;
    info.box = geometry::bounds(read.mesh);
    info.stated_unit = read.unit;
    info.converted = read.converted_unit;
    info.read_unit = read.unit > 0 ? read.unit : 1;
    for (const NamedUnit& u : units) {
        if (u.unit == options.unit && u.metres > 0) info.read_unit = u.metres;
    }
    info.unit = read.unit > 0 ? FileUnit{unit_name(read.unit), read.unit}
                              : guess_unit(info.box.size().maxCoeff() / info.read_unit);
    info.vertices = read.mesh.positions.size();
    info.triangles = read.mesh.triangles().size();
    info.polygons = count_polygons(*read.mesh.topology);
    measure_surface(read.mesh, info);
    for (const auto& m : read.mesh.topology->materials) info.materials.push_back(m.name);
    info.groups = read.mesh.topology->groups;
    for (const std::string& name : read.textures) {
        info.textures.push_back({name, is_there(file, name)});
    }
    info.warnings = read.warnings;
    advise(info);
    return info;
}

std::string info_text(const std::string& file, const MeshInfo& info)
{
    std::string text = file + "\n";
    const auto line = [&](const char* what, const std::string& value) {
        text += fmt::format("  {:<13} {}\n", what, value);
    };
    const geometry::Vec3 size = info.box.size();
    line("size", fmt::format("{:.4g} x {:.4g} x {:.4g} m, from {} to {}", size.x(), size.y(),
                             size.z(), place_text(info.box.lo), place_text(info.box.hi)));
    line("unit", unit_text(info));
    line("vertices", std::to_string(info.vertices));
    line("triangles", std::to_string(info.triangles));
    if (info.polygons[0] < info.triangles) line("polygons", polygons_text(info.polygons));
    line("surface", surface_text(info));
    line("pieces", std::to_string(info.pieces));
    line("groups", joined(info.groups, "none"));
    if (info.closed) {
        const double rounding = 1e-9 * size.maxCoeff();
        const geometry::Vec3 centre =
            info.body.centre.unaryExpr([&](double v) { return std::abs(v) < rounding ? 0 : v; });
        line("volume", fmt::format("{:.4g} m^3, centre at {}", info.body.mass, place_text(centre)));
        const geometry::Vec3 inertia = info.body.inertia.diagonal() / info.body.mass;
        line("inertia", fmt::format("{:.4g}, {:.4g}, {:.4g} m^2 about x, y, z per mass",
                                    inertia.x(), inertia.y(), inertia.z()));
    }
    line("area", fmt::format("{:.4g} m^2", info.area));
    line("materials", joined(info.materials, "none"));
    std::vector<std::string> textures;
    for (const auto& t : info.textures)
        textures.push_back(t.name + (t.found ? "" : " (not found)"));
    line("textures", joined(textures, "none"));
    line("thinnest wall",
         !info.thinnest ? std::string("unknown: no piece is closed")
                        : fmt::format("{}{}, at {}", length_text(info.thinnest->thickness),
                                      info.thinnest->part.empty() ? "" : ", " + info.thinnest->part,
                                      place_text(info.thinnest->where)));
    line("cubes", cubes_text(info));
    for (const std::string& w : info.warnings) line("warning", w);
    return text;
}

std::string info_json(const std::string& file, const MeshInfo& info)
{
    Json textures = Json::array();
    for (const auto& t : info.textures) textures.push_back({{"name", t.name}, {"found", t.found}});
    Json wall;
    if (info.thinnest) {
        wall = {{"thickness", info.thinnest->thickness},
                {"part", info.thinnest->part},
                {"where", vector_json(info.thinnest->where)}};
    }
    const Json all{
        {"file", file},
        {"size", vector_json(info.box.size())},
        {"lowest", vector_json(info.box.empty() ? geometry::Vec3(0, 0, 0) : info.box.lo)},
        {"unit",
         {{"name", info.unit.name},
          {"metres", info.unit.metres},
          {"stated", info.stated_unit > 0},
          {"read_as", info.read_unit}}},
        {"vertices", info.vertices},
        {"triangles", info.triangles},
        {"polygons",
         {{"triangles", info.polygons[0]},
          {"quads", info.polygons[1]},
          {"larger", info.polygons[2]}}},
        {"closed", info.closed},
        {"holes", info.holes},
        {"longest_rim", info.longest_rim},
        {"shell", info.shell},
        {"pieces_filled_between", info.between},
        {"disagreeing_edges", info.disagreeing},
        {"triangles_wound_otherwise", info.turned},
        {"doubled_triangles", info.doubled},
        {"pieces", info.pieces},
        {"groups", info.groups},
        {"area", info.area},
        {"body", body_json(info)},
        {"materials", info.materials},
        {"textures", textures},
        {"thinnest_wall", wall},
        {"cubes", cubes_json(info.cubes)},
        {"cubes_for_thinnest_wall", cubes_json(info.fine.size > 0 ? info.fine : info.cubes)},
        {"warnings", info.warnings}};
    // Names in a file need not be UTF-8.
    return all.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string describe_mesh(const std::string& file, const std::string& unit, bool json,
                          const std::stop_token& stop)
{
    geometry::ReadOptions options;
    options.import.check = [stop] {
        if (stop.stop_requested()) throw graph::Cancelled();
    };
    const auto* const known = std::find_if(units.begin(), units.end(),
                                           [&](const NamedUnit& u) { return u.name == unit; });
    if (known == units.end()) throw std::invalid_argument("no such unit: " + unit);
    options.unit = known->unit;
    const MeshInfo info = mesh_info(file, options);
    return json ? info_json(file, info) : info_text(file, info);
}

}  // namespace nodes
