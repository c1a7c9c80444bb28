#include "geometry/mesh/split.hpp"
#include "geometry/cubes/assign_matter.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace nodes::split {

struct Part {
    enum class Match { any, group, material };
    std::string name = "*";
    Match match = Match::any;
};
struct Inputs {
    graph::Wire<geometry::TriMesh> mesh;
    std::vector<Part> parts;
};
struct Outputs {
    geometry::TriMesh mesh, rest;
};

// Which of the mesh's groups and materials a part names.
struct Named {
    std::vector<std::uint8_t> groups, materials;
};

static Named named_by(const Part& part, const geometry::MeshTopology& t)
{
    Named out;
    if (part.match != Part::Match::material) {
        for (const std::string& group : t.groups) {
            out.groups.push_back(geometry::matches(group, part.name));
        }
    }
    if (part.match != Part::Match::group) {
        for (const geometry::Material& material : t.materials) {
            out.materials.push_back(geometry::matches(material.name, part.name));
        }
    }
    return out;
}

// Marks the faces of a part; returns whether it has any.
static bool mark(const Part& part, const geometry::MeshTopology& t, std::vector<std::uint8_t>& kept)
{
    const Named named = named_by(part, t);
    const auto is_in = [](const std::vector<std::uint8_t>& these,
                          const std::vector<std::uint16_t>& of, std::size_t face) {
        const std::size_t number = of.empty() ? 0 : of[face];
        return number < these.size() && these[number] != 0;
    };
    bool found = false;
    for (std::size_t f = 0; f < kept.size(); ++f) {
        if (!is_in(named.groups, t.group, f) && !is_in(named.materials, t.material, f)) continue;
        kept[f] = 1;
        found = true;
    }
    return found;
}

// The names that a part could have, for people.
static std::string names_of(const geometry::MeshTopology& t, Part::Match match)
{
    std::vector<std::string> names;
    if (match != Part::Match::material) names = t.groups;
    if (match != Part::Match::group) {
        for (const geometry::Material& m : t.materials) names.push_back(m.name);
    }
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    std::erase(names, "");
    if (names.empty()) return "none has a name";
    constexpr std::size_t most = 8;
    const std::size_t more = names.size() - std::min(names.size(), most);
    names.resize(names.size() - more);
    return fmt::format("it has {}{}", fmt::join(names, ", "),
                       more > 0 ? fmt::format(" and {} more", more) : "");
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    const geometry::TriMesh& mesh = *in.mesh;
    std::vector<std::uint8_t> kept(mesh.triangles().size(), 0);
    for (std::size_t i = 0; i < in.parts.size(); ++i) {
        const Part& part = in.parts[i];
        if (mark(part, *mesh.topology, kept)) continue;
        constexpr const char* what[] = {"group or material", "group", "material"};
        context.warn(fmt::format("parts[{}].name \"{}\" matches no {} of the mesh: {}", i,
                                 part.name, what[std::size_t(part.match)],
                                 names_of(*mesh.topology, part.match)));
    }
    Outputs out;
    out.mesh = geometry::part_of(mesh, kept);
    for (auto& k : kept) k = k == 0;
    out.rest = geometry::part_of(mesh, kept);
    return out;
}

static graph::Faults check(const Inputs& in, const graph::Setting&)
{
    if (!in.parts.empty()) return {};
    return {{"parts", "expected the name of at least one part, as [{\"name\": \"leaves*\"}]; "
                      "'aspic info' lists the groups and materials of a file"}};
}

static void describe_part(graph::ParamsOf<Part>& p)
{
    p.param("name", &Part::name, "Name of the part: * stands for any text, ? for any character.")
        .choice("match", &Part::match, {"any", "group", "material"},
                "What has that name: a group (an object or a named part of a file), a material, or "
                "either.");
}

void add_to(graph::Registry& registry)
{
    registry.add("Split", 1, run)
        .summary("Takes parts out of a mesh by the names of their groups or materials, and hands "
                 "on the rest: a body and its collider from one file, or a tree without leaves.",
                 {"separate", "blast", "delete", "isolate", "prune", "extract", "filter", "group"})
        .input("mesh", &Inputs::mesh, "The mesh to split.")
        .list("parts", &Inputs::parts, describe_part,
              "The parts to take out; a face that any of them names is taken.")
        .check(check)
        .output("mesh", &Outputs::mesh,
                "The faces of the parts, with their vertices, normals, texture coordinates, "
                "materials, groups and attributes.")
        .output("rest", &Outputs::rest,
                "All other faces. Vertices that no face uses are left out of both.");
}

}  // namespace nodes::split
