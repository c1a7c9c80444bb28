// Instances are added one after the other: faces are chosen, vertices welded, then normals, texture
// coordinates and names follow. At the end come normals that the file does not give, scale and
// place.

#include "geometry/io/assemble_mesh.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/numbering.hpp"
#include "geometry/base/parallel.hpp"
#include "geometry/base/srgb.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/io/file_axes.hpp"
#include "geometry/io/file_vertices.hpp"
#include "geometry/io/line_tubes.hpp"
#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/normals.hpp"
#include "geometry/mesh/polygons.hpp"
#include "geometry/mesh/transform.hpp"

#include <cmath>
#include <map>
#include <stdexcept>

namespace geometry {
namespace {

Transform world_of(const ImportedNode& node, const Transform& file_to_world)
{
    Transform T = Transform::Identity();
    T.matrix().topRows<3>() =
        Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(node.to_world.data());
    return file_to_world * T;
}

// What was left out, counted; said in sentences at the end.
struct Dropped {
    std::uint64_t not_there = 0, not_finite = 0, repeated = 0, lines = 0, points = 0, values = 0;

    std::vector<std::string> sentences() const
    {
        std::vector<std::string> all;
        const auto add = [&](std::uint64_t n, const char* one, const char* many) {
            if (n > 0) all.push_back("left out " + std::to_string(n) + " " + (n == 1 ? one : many));
        };
        add(not_there, "face that names a vertex which is not in the file",
            "faces that name a vertex which is not in the file");
        add(not_finite, "face or point whose position is not a finite number",
            "faces or points whose positions are not finite numbers");
        add(repeated, "face that has one vertex twice", "faces that have one vertex twice");
        add(lines, "line, which the output 'lines' has: set line_thickness to make a tube of it",
            "lines, which the output 'lines' has: set line_thickness to make tubes of them");
        add(points, "loose point beside the faces", "loose points beside the faces");
        add(values, "value of an attribute that is not a finite number: 0 stands in its place",
            "values of attributes that are not finite numbers: 0 stands in their places");
        for (std::string& s : all) s += ".";
        return all;
    }
};

// Numbers things 0, 1, 2 ... in order of appearance; those after number 65,535 share that one.
template <class Key> struct Numbered {
    std::vector<Key> order;
    std::map<Key, std::uint16_t> number_of;

    std::uint16_t number(const Key& key)
    {
        const auto next = static_cast<std::uint16_t>(std::min<std::size_t>(order.size(), 0xffff));
        const auto [found, is_new] = number_of.try_emplace(key, next);
        if (is_new && order.size() <= 0xffff) order.push_back(key);
        return found->second;
    }
    void warn(const char* things, std::vector<std::string>& warnings) const
    {
        if (number_of.size() == order.size()) return;
        warnings.push_back("the file has " + std::to_string(number_of.size()) + " " + things +
                           ": those after the first 65,535 are one. Join some, or split the file.");
    }
};

// The mesh while it grows, instance by instance.
struct Assembly {
    const ImportedScene* scene = nullptr;
    Dropped dropped;
    std::size_t vertices = 0, faces = 0;
    bool has_normals = false, has_uvs = false, has_colours = false, has_polygons = false;

    Numbering<4> place_of;   // position bits, and the group or 0 -> vertex
    Numbering<4> normal_of;  // vertex and normal bits -> normal
    Numbering<2> uv_of;
    Numbered<std::uint32_t> materials;
    Numbered<std::pair<std::string, std::uint32_t>> groups;  // a name, and whose
    std::vector<Vec3f> colours;
    std::vector<Attribute> attributes;  // of all meshes, each name once
    MeshTopology topology;

    bool weld_groups = false;  // each by itself

    std::uint32_t group = 0;                    // of the instance being added
    std::vector<Vec3f> position;                // likewise
    std::vector<std::uint32_t> vertex;          // likewise
    std::vector<Triangle> kept;                 // likewise
    std::vector<const ImportedAttribute*> own;  // likewise, one of each of attributes; may be null
};

Assembly begin_assembly(const ImportedScene& scene)
{
    Assembly a;
    a.scene = &scene;
    for (const ImportedNode& node : scene.nodes) {
        if (node.mesh >= scene.meshes.size()) continue;
        const ImportedMesh& mesh = scene.meshes[node.mesh];
        a.vertices += mesh.positions.size();
        a.faces += mesh.triangles.size();
        a.has_normals = a.has_normals || !mesh.normals.empty();
        a.has_uvs = a.has_uvs || !mesh.uvs.empty();
        a.has_colours = a.has_colours || !mesh.colours.empty();
        a.has_polygons = a.has_polygons || !mesh.polygon.empty();
        for (const ImportedAttribute& own : mesh.attributes) {
            const auto same = [&](const Attribute& b) { return b.name == own.name; };
            if (std::none_of(a.attributes.begin(), a.attributes.end(), same)) {
                a.attributes.push_back({own.name, "", {}});
            }
        }
    }
    if (a.vertices >= no_index || a.faces >= no_index / 3) {
        throw std::runtime_error("it has " + std::to_string(a.faces) +
                                 " faces in all its instances, the limit is 1.4 billion");
    }
    a.place_of = Numbering<4>(a.vertices / 4);
    return a;
}

// a.own: the attributes of `in` by the number of their name in a.attributes.
void find_attributes(Assembly& a, const ImportedMesh& in)
{
    a.own.assign(a.attributes.size(), nullptr);
    for (const ImportedAttribute& own : in.attributes) {
        const auto same = [&](const Attribute& b) { return b.name == own.name; };
        const auto found = std::find_if(a.attributes.begin(), a.attributes.end(), same);
        if (found == a.attributes.end()) continue;
        a.own[static_cast<std::size_t>(found - a.attributes.begin())] = &own;
    }
}

// The vertex at that place.
std::uint32_t place_number(Assembly& a, const Vec3f& p)
{
    const auto b = bits(p);
    return a.place_of.add({b[0], b[1], b[2], a.weld_groups ? a.group : 0});
}

// The numbers at a vertex that is new here: white and 0 where the file has none. A vertex that is
// welded to another keeps the other's.
void add_vertex_values(Assembly& a, const ImportedMesh& in, std::size_t from, std::uint32_t vertex)
{
    if (a.has_colours && vertex == a.colours.size()) {
        a.colours.push_back(in.colours.size() > from ? in.colours[from] : Vec3f(Vec3f::Ones()));
    }
    for (std::size_t i = 0; i < a.attributes.size(); ++i) {
        Attribute& to = a.attributes[i];
        if (vertex != to.values.size()) continue;
        const ImportedAttribute* own = a.own[i];
        const float value = own && own->values.size() > from ? own->values[from] : 0.f;
        if (!std::isfinite(value)) ++a.dropped.values;
        to.values.push_back(std::isfinite(value) ? value : 0.f);
    }
}

void add_points(Assembly& a, const ImportedMesh& in, const Transform& T)
{
    // A file with no faces may call its vertices points or say nothing of them.
    for (std::size_t v = 0; v < in.positions.size(); ++v) {
        const Vec3f q = (T * in.positions[v].cast<double>()).cast<float>();
        if (q.allFinite()) {
            add_vertex_values(a, in, v, place_number(a, q));
        } else {
            ++a.dropped.not_finite;
        }
    }
}

// Whether a face is worth keeping; counted where it is not.
bool is_usable(Assembly& a, const Triangle& t)
{
    if (std::max({t[0], t[1], t[2]}) >= a.position.size()) {
        ++a.dropped.not_there;
        return false;
    }
    const Vec3f &p = a.position[t[0]], &q = a.position[t[1]], &r = a.position[t[2]];
    if (!p.allFinite() || !q.allFinite() || !r.allFinite()) {
        ++a.dropped.not_finite;
        return false;
    }
    if (p == q || q == r || r == p) {
        ++a.dropped.repeated;
        return false;
    }
    return true;
}

// a.kept: the faces worth keeping, as corners in the imported mesh.
void choose_faces(Assembly& a, const ImportedMesh& in, bool mirrored)
{
    a.kept.clear();
    a.kept.reserve(in.triangles.size());
    std::vector<std::uint8_t> gone;  // needed where there are polygons
    StopCheck check;
    for (Triangle t : in.triangles) {
        check();
        const bool usable = is_usable(a, t);
        if (mirrored) std::swap(t[1], t[2]);
        if (usable) a.kept.push_back(t);
        if (a.has_polygons) gone.push_back(usable ? 0 : 1);
    }
    if (!a.has_polygons) return;
    const std::vector<std::uint32_t> left = polygons_left(in.polygon, gone);
    const std::uint32_t first = a.topology.polygon.empty() ? 0 : a.topology.polygon.back() + 1;
    for (const std::uint32_t number : left) a.topology.polygon.push_back(first + number);
    for (std::size_t f = left.size(); f < a.kept.size(); ++f) add_polygon(a.topology.polygon, 1);
}

// a.vertex: the welded vertex of each that a kept face uses, in the file's order of vertices.
void number_vertices(Assembly& a, const ImportedMesh& in)
{
    a.vertex.assign(a.position.size(), no_index);
    for (const Triangle& t : a.kept) {
        for (const auto v : t) a.vertex[v] = 0;
    }
    for (std::size_t v = 0; v < a.vertex.size(); ++v) {
        if (a.vertex[v] == no_index) continue;
        a.vertex[v] = place_number(a, a.position[v]);
        add_vertex_values(a, in, v, a.vertex[v]);
    }
    for (const Triangle& t : a.kept) {
        a.topology.triangles.push_back({a.vertex[t[0]], a.vertex[t[1]], a.vertex[t[2]]});
    }
}

void add_normals(Assembly& a, const ImportedMesh& in, const Mat3& linear)
{
    if (!a.has_normals) return;
    const bool given = in.normals.size() == in.positions.size();
    TriMesh turned;  // normals alone
    if (given) turned.normals = in.normals;
    for (Vec3f& n : turned.normals) {
        const float length = n.norm();
        n = length > 1e-20f && std::isfinite(length) ? Vec3f(n / length) : Vec3f(Vec3f::Zero());
    }
    Transform T = Transform::Identity();
    T.linear() = linear;
    move(turned, T);
    StopCheck check;
    for (const Triangle& t : a.kept) {
        check();
        Triangle corner{no_index, no_index, no_index};
        for (std::size_t k = 0; k < 3 && given; ++k) {
            const Vec3f& n = turned.normals[t[k]];
            if (n.isZero(0) || !n.allFinite()) continue;
            const auto b = bits(n);
            corner[k] = a.normal_of.add({a.vertex[t[k]], b[0], b[1], b[2]});
        }
        a.topology.normal_triangles.push_back(corner);
    }
}

void add_uvs(Assembly& a, const ImportedMesh& in)
{
    if (!a.has_uvs) return;
    const bool given = in.uvs.size() == in.positions.size();
    for (const Triangle& t : a.kept) {
        Triangle corner;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec2f uv = given ? in.uvs[t[k]] : Vec2f(0, 0);
            corner[k] = a.uv_of.add(bits(uv.allFinite() ? uv : Vec2f(0, 0)));
        }
        a.topology.uv_triangles.push_back(corner);
    }
}

void add_names(Assembly& a, const ImportedMesh& in)
{
    a.topology.material.resize(a.topology.triangles.size(), a.materials.number(in.material));
    a.topology.group.resize(a.topology.triangles.size(), static_cast<std::uint16_t>(a.group));
}

void add_instance(Assembly& a, const ImportedNode& node, const Transform& T)
{
    const ImportedMesh& in = a.scene->meshes[node.mesh];
    a.dropped.lines += in.lines;
    find_attributes(a, in);
    if (a.faces == 0) {
        add_points(a, in, T);
        return;
    }
    a.group =
        node.name.empty() ? a.groups.number({in.name, 0}) : a.groups.number({node.name, node.node});
    a.dropped.points += in.points.size();
    a.position.resize(in.positions.size());
    parallel_for(a.position.size(), 16384, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            a.position[v] = (T * in.positions[v].cast<double>()).cast<float>();
        }
    });
    choose_faces(a, in, mirrors(T.linear()));
    number_vertices(a, in);
    parallel_for(2, a.kept.size() > 10'000 ? 1 : 2, [&](std::size_t begin, std::size_t end) {
        if (begin == 0) add_normals(a, in, T.linear());
        if (end == 2) add_uvs(a, in);
    });
    add_names(a, in);
}

// Everything but normals that the file does not give.
TriMesh finish(Assembly& a, const ReadOptions& options, const FoundTextures& textures)
{
    TriMesh out;
    for (const auto& key : a.place_of.keys()) {
        out.positions.emplace_back(std::bit_cast<float>(key[0]), std::bit_cast<float>(key[1]),
                                   std::bit_cast<float>(key[2]));
    }
    a.place_of = Numbering<4>();
    const bool linear = options.colours == ColourSpace::linear ||
                        (options.colours == ColourSpace::automatic && a.scene->linear_colours);
    const auto light = [&](const Vec3f& c) {
        const Vec3f sane = c.unaryExpr([](float x) { return x >= 0 ? std::min(x, 1.f) : 0.f; });
        return linear ? sane : linear_from_srgb(sane);
    };
    if (a.has_colours) {
        for (const Vec3f& c : a.colours) out.colours.push_back(light(c));
    }
    out.attributes = std::move(a.attributes);
    for (const auto& key : a.normal_of.keys()) {
        out.normals.emplace_back(std::bit_cast<float>(key[1]), std::bit_cast<float>(key[2]),
                                 std::bit_cast<float>(key[3]));
    }
    for (const auto& key : a.uv_of.keys()) {
        a.topology.uvs.emplace_back(std::bit_cast<float>(key[0]), std::bit_cast<float>(key[1]));
    }
    for (auto& group : a.groups.order) a.topology.groups.push_back(std::move(group.first));
    if (has_triangles_only(a.topology.polygon)) a.topology.polygon.clear();
    for (const auto m : a.materials.order) {
        Material& made = a.topology.materials.emplace_back();
        if (m >= a.scene->materials.size()) continue;  // the file has none: Material's own
        const ImportedMaterial& in = a.scene->materials[m];
        const auto unit = [](float x, float otherwise) {
            return std::isfinite(x) ? std::clamp(x, 0.f, 1.f) : otherwise;
        };
        made = {in.name, light(in.colour), unit(in.opacity, 1), unit(in.roughness, 0.6f),
                unit(in.metallic, 0)};
        if (m >= textures.of_material.size()) continue;
        made.normal_map = textures.normal_maps[m];
        made.texture = textures.of_material[m];
        if (made.normal_map && std::isfinite(in.bump)) made.bump = in.bump;
        if (made.texture || made.normal_map) made.use = textures.use[m];
        if (!made.texture) continue;
        // Black would hide the picture: it is what some programs write beside one.
        if (made.colour.isZero(0)) made.colour.setOnes();
    }
    out.topology = std::make_shared<const MeshTopology>(std::move(a.topology));
    return out;
}

// Corners whose normal the file does not give get a computed one.
void complete_normals(TriMesh& mesh, const ReadOptions& options)
{
    const auto& given = mesh.topology->normal_triangles;
    const auto lacks = [](const Triangle& t) {
        return t[0] == no_index || t[1] == no_index || t[2] == no_index;
    };
    if (options.normals == FileNormals::computed || given.empty()) {
        compute_normals(mesh, options.crease);
        return;
    }
    if (std::none_of(given.begin(), given.end(), lacks)) return;

    TriMesh computed = mesh;
    compute_normals(computed, options.crease);
    auto topology = std::make_shared<MeshTopology>(*mesh.topology);
    const auto base = static_cast<std::uint32_t>(mesh.normals.size());
    for (std::size_t f = 0; f < given.size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) {
            auto& n = topology->normal_triangles[f][k];
            if (n == no_index) n = base + computed.topology->normal_triangles[f][k];
        }
    }
    mesh.normals.insert(mesh.normals.end(), computed.normals.begin(), computed.normals.end());
    mesh.topology = std::move(topology);
}

void drop_normals(TriMesh& mesh)
{
    auto topology = std::make_shared<MeshTopology>(*mesh.topology);
    topology->normal_triangles.clear();
    mesh.topology = std::move(topology);
    mesh.normals.clear();
}

// The lines of a mesh. Files often store only segments: segments that follow each other are one
// line, until it closes.
void add_lines(const ImportedMesh& in, const Transform& T, Polylines& out)
{
    bool open = false;
    for (const auto& [i, j] : in.segments) {
        if (i >= in.positions.size() || j >= in.positions.size()) continue;
        const Vec3 a = T * in.positions[i].cast<double>(), b = T * in.positions[j].cast<double>();
        if (!a.allFinite() || !b.allFinite() || a == b) continue;
        const auto closed = [&] {
            const auto& last = out.lines.back();
            return last.size() > 2 && last.front() == last.back();
        };
        if (!open || out.lines.back().back() != a || closed()) out.lines.push_back({a});
        out.lines.back().push_back(b);
        open = true;
    }
}

// Lines go with the mesh.
void fit_and_place(TriMesh& mesh, Polylines& lines, const ReadOptions& options)
{
    double scale = 1;
    if (options.fit > 0) {
        const double largest = bounds(mesh).size().maxCoeff();
        if (!(largest > 0)) {
            throw std::runtime_error("all of it is in one place: it cannot be scaled to a size");
        }
        scale = options.fit / largest;
    }
    if (scale == 1 && options.place == Placement::keep) return;

    const Box box = bounds(mesh);
    Vec3 origin = Vec3::Zero();  // what comes to lie at the origin
    if (options.place != Placement::keep) origin = box.centre();
    if (options.place == Placement::ground) origin.y() = box.lo.y();
    for (Vec3f& p : mesh.positions) {
        p = ((p.cast<double>() - origin) * scale).cast<float>();
        if (!p.allFinite())
            throw std::runtime_error(
                "scaled to that size, its coordinates exceed single precision");
    }
    for (std::vector<Vec3>& line : lines.lines) {
        for (Vec3& p : line) p = (p - origin) * scale;
    }
}

}  // namespace

ReadMesh assemble_mesh(const ImportedScene& given, const ReadOptions& options,
                       const FoundTextures& textures, std::span<const Vec3f> of_file)
{
    ReadMesh out;
    ImportedScene thickened;
    if (options.line_thickness > 0) {
        thickened = given;
        add_line_tubes(thickened, options.line_thickness /
                                      metres_of(options.unit, options.custom_unit, given.unit));
    }
    const ImportedScene& scene = options.line_thickness > 0 ? thickened : given;
    Assembly assembly = begin_assembly(scene);
    assembly.weld_groups = options.weld == Weld::groups;
    Transform file_to_world = Transform::Identity();
    file_to_world.linear() = to_metres(scene, options);
    for (const ImportedNode& node : scene.nodes) {
        if (node.mesh >= scene.meshes.size()) continue;
        add_instance(assembly, node, world_of(node, file_to_world));
        add_lines(scene.meshes[node.mesh], world_of(node, file_to_world), out.lines);
    }
    out.warnings = assembly.dropped.sentences();
    assembly.groups.warn("groups", out.warnings);
    assembly.materials.warn("materials", out.warnings);
    out.mesh = finish(assembly, options, textures);
    out.unit = scene.unit;
    out.textures = scene.textures;
    if (out.mesh.positions.empty()) {
        std::string why;
        for (const std::string& w : out.warnings) why += (why.empty() ? ": " : " ") + w;
        throw std::runtime_error("it has no usable faces and no usable points" + why);
    }
    if (out.mesh.triangles().empty() || options.normals == FileNormals::none) {
        drop_normals(out.mesh);
    } else {
        complete_normals(out.mesh, options);
    }
    constexpr const char* remedy = "move it to the origin in the program that wrote the file";
    if (std::string far = far_from_origin(out.mesh, remedy); !far.empty()) {
        out.warnings.push_back(std::move(far));
    }
    if (!of_file.empty()) {
        std::vector<Vec3f> moved;
        for (const Vec3f& p : of_file) {
            moved.push_back((file_to_world * p.cast<double>()).cast<float>());
        }
        keep_file_vertices(out.mesh, moved, options.weld == Weld::groups);
    }
    fit_and_place(out.mesh, out.lines, options);
    return out;
}

}  // namespace geometry
