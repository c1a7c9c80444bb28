#include "geometry/read_mesh.hpp"

#include "geometry/colour.hpp"
#include "geometry/distinct.hpp"
#include "geometry/measure.hpp"
#include "geometry/normals.hpp"
#include "geometry/parallel.hpp"
#include "geometry/read_ply.hpp"
#include "geometry/transform.hpp"

#include <tbb/parallel_invoke.h>

#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <stdexcept>

namespace geometry {
namespace {

constexpr std::uint32_t nothing = ~std::uint32_t{0};

double metres_of(LengthUnit unit, double custom, double said)
{
    switch (unit) {
    case LengthUnit::automatic:
        return said > 0 && std::isfinite(said) ? said : 1;
    case LengthUnit::metre:
        return 1;
    case LengthUnit::centimetre:
        return 0.01;
    case LengthUnit::millimetre:
        return 0.001;
    case LengthUnit::inch:
        return 0.0254;
    case LengthUnit::foot:
        return 0.3048;
    case LengthUnit::custom:
        if (!(custom > 0) || !std::isfinite(custom)) {
            throw std::invalid_argument("the custom unit must be a positive number of metres");
        }
        return custom;
    }
    throw std::invalid_argument("no such unit");
}

Mat3 to_y_up(UpAxis up, const ImportedScene& scene)
{
    Mat3 M = Mat3::Identity();
    switch (up) {
    case UpAxis::automatic:
        if (scene.has_axes) {
            M = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
                scene.to_y_up.data());
        }
        return M;
    case UpAxis::y:
        return M;
    case UpAxis::z:
        M << 1, 0, 0, 0, 0, 1, 0, -1, 0;
        return M;
    case UpAxis::x:
        M << 0, -1, 0, 1, 0, 0, 0, 0, 1;
        return M;
    }
    throw std::invalid_argument("no such axis");
}

Transform world_of(const ImportedNode& node, const Transform& file_to_world)
{
    Transform T = Transform::Identity();
    T.matrix().topRows<3>() =
        Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(node.to_world.data());
    return file_to_world * T;
}

// What was left out, counted; said in sentences at the end.
struct Dropped {
    std::uint64_t not_there = 0, not_finite = 0, repeated = 0, lines = 0, points = 0;

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
        add(lines, "line: only faces and points are used", "lines: only faces and points are used");
        add(points, "loose point beside the faces", "loose points beside the faces");
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
};

// The mesh while it grows, instance by instance.
class Assembly {
public:
    explicit Assembly(const ImportedScene& scene) : scene_(scene)
    {
        for (const ImportedNode& node : scene.nodes) {
            if (node.mesh >= scene.meshes.size()) continue;
            const ImportedMesh& mesh = scene.meshes[node.mesh];
            vertices_ += mesh.positions.size();
            faces_ += mesh.triangles.size();
            has_normals_ = has_normals_ || !mesh.normals.empty();
            has_uvs_ = has_uvs_ || !mesh.uvs.empty();
            has_colours_ = has_colours_ || !mesh.colours.empty();
        }
        if (vertices_ >= nothing || faces_ >= nothing / 3) {
            throw std::runtime_error("it has " + std::to_string(faces_) +
                                     " faces in all its "
                                     "instances; a mesh holds at most 1.4 billion");
        }
        place_of_ = Distinct<3>(vertices_ / 4);
    }

    void add(const ImportedNode& node, const Transform& T)
    {
        const ImportedMesh& in = scene_.meshes[node.mesh];
        dropped.lines += in.lines;
        if (faces_ == 0) {
            add_points(in, T);
            return;
        }
        dropped.points += in.points.size();
        position_.resize(in.positions.size());
        parallel_for(position_.size(), 16384, [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v) {
                position_[v] = (T * in.positions[v].cast<double>()).cast<float>();
            }
        });
        choose_faces(in, mirrors(T.linear()));
        number_vertices(in);
        if (kept_.size() > 10'000) {
            tbb::parallel_invoke([&] { add_normals(in, T.linear()); }, [&] { add_uvs(in); });
        } else {
            add_normals(in, T.linear());
            add_uvs(in);
        }
        add_names(in, node);
    }

    Dropped dropped;

    // Everything but normals that the file does not give.
    TriMesh finish(const ReadOptions& options)
    {
        TriMesh out;
        for (const auto& key : place_of_.keys()) {
            out.positions.emplace_back(std::bit_cast<float>(key[0]), std::bit_cast<float>(key[1]),
                                       std::bit_cast<float>(key[2]));
        }
        place_of_ = Distinct<3>();
        const bool linear = options.colours == ColourSpace::linear ||
                            (options.colours == ColourSpace::automatic && scene_.linear_colours);
        const auto light = [&](const Vec3f& c) {
            const Vec3f sane = c.unaryExpr([](float x) { return x >= 0 ? std::min(x, 1.f) : 0.f; });
            return linear ? sane : linear_from_srgb(sane);
        };
        if (has_colours_) {
            for (const Vec3f& c : colours_) out.colours.push_back(light(c));
        }
        for (const auto& key : normal_of_.keys()) {
            out.normals.emplace_back(std::bit_cast<float>(key[1]), std::bit_cast<float>(key[2]),
                                     std::bit_cast<float>(key[3]));
        }
        for (const auto& key : uv_of_.keys()) {
            topology_.uvs.emplace_back(std::bit_cast<float>(key[0]), std::bit_cast<float>(key[1]));
        }
        topology_.groups = std::move(groups_.order);
        for (const auto m : materials_.order) {
            const ImportedMaterial in =
                m < scene_.materials.size() ? scene_.materials[m] : ImportedMaterial{};
            const auto unit = [](float x, float otherwise) {
                return std::isfinite(x) ? std::clamp(x, 0.f, 1.f) : otherwise;
            };
            topology_.materials.push_back({in.name, light(in.colour), unit(in.opacity, 1),
                                           unit(in.roughness, 0.6f), unit(in.metallic, 0)});
        }
        out.topology = std::make_shared<const MeshTopology>(std::move(topology_));
        return out;
    }

private:
    void add_points(const ImportedMesh& in, const Transform& T)
    {
        const auto add = [&](const Vec3f& p, const Vec3f* colour) {
            const Vec3f q = (T * p.cast<double>()).cast<float>();
            if (!q.allFinite()) {
                ++dropped.not_finite;
                return;
            }
            if (place_of_.add(bits(q)) == colours_.size() && has_colours_) {
                colours_.push_back(colour ? *colour : Vec3f(Vec3f::Ones()));
            }
        };
        // A file with no faces may call its vertices points or say nothing of them.
        for (std::size_t v = 0; v < in.positions.size(); ++v) {
            add(in.positions[v], in.colours.size() > v ? &in.colours[v] : nullptr);
        }
    }

    // kept_: the faces worth keeping, as corners in the imported mesh.
    void choose_faces(const ImportedMesh& in, bool mirrored)
    {
        kept_.clear();
        kept_.reserve(in.triangles.size());
        for (Triangle t : in.triangles) {
            if (std::max({t[0], t[1], t[2]}) >= position_.size()) {
                ++dropped.not_there;
                continue;
            }
            const Vec3f &a = position_[t[0]], &b = position_[t[1]], &c = position_[t[2]];
            if (!a.allFinite() || !b.allFinite() || !c.allFinite()) {
                ++dropped.not_finite;
            } else if (a == b || b == c || c == a) {
                ++dropped.repeated;
            } else {
                if (mirrored) std::swap(t[1], t[2]);
                kept_.push_back(t);
            }
        }
    }

    // vertex_: the welded vertex of each that a kept face uses, in the file's order of vertices.
    void number_vertices(const ImportedMesh& in)
    {
        vertex_.assign(position_.size(), nothing);
        for (const Triangle& t : kept_) {
            for (const auto v : t) vertex_[v] = 0;
        }
        for (std::size_t v = 0; v < vertex_.size(); ++v) {
            if (vertex_[v] == nothing) continue;
            vertex_[v] = place_of_.add(bits(position_[v]));
            if (has_colours_ && vertex_[v] == colours_.size()) {
                colours_.push_back(in.colours.size() > v ? in.colours[v] : Vec3f(Vec3f::Ones()));
            }
        }
        for (const Triangle& t : kept_) {
            topology_.triangles.push_back({vertex_[t[0]], vertex_[t[1]], vertex_[t[2]]});
        }
    }

    void add_normals(const ImportedMesh& in, const Mat3& linear)
    {
        if (!has_normals_) return;
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
        for (const Triangle& t : kept_) {
            Triangle corner{nothing, nothing, nothing};
            for (std::size_t k = 0; k < 3 && given; ++k) {
                const Vec3f& n = turned.normals[t[k]];
                if (n.isZero(0) || !n.allFinite()) continue;
                const auto b = bits(n);
                corner[k] = normal_of_.add({vertex_[t[k]], b[0], b[1], b[2]});
            }
            topology_.normal_triangles.push_back(corner);
        }
    }

    void add_uvs(const ImportedMesh& in)
    {
        if (!has_uvs_) return;
        const bool given = in.uvs.size() == in.positions.size();
        for (const Triangle& t : kept_) {
            Triangle corner;
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec2f uv = given ? in.uvs[t[k]] : Vec2f(0, 0);
                corner[k] = uv_of_.add(bits(uv.allFinite() ? uv : Vec2f(0, 0)));
            }
            topology_.uv_triangles.push_back(corner);
        }
    }

    void add_names(const ImportedMesh& in, const ImportedNode& node)
    {
        topology_.material.resize(topology_.triangles.size(), materials_.number(in.material));
        topology_.group.resize(topology_.triangles.size(),
                               groups_.number(node.name.empty() ? in.name : node.name));
    }

    const ImportedScene& scene_;
    std::size_t vertices_ = 0, faces_ = 0;
    bool has_normals_ = false, has_uvs_ = false, has_colours_ = false;

    Distinct<3> place_of_;   // position bits -> vertex
    Distinct<4> normal_of_;  // vertex and normal bits -> normal
    Distinct<2> uv_of_;
    Numbered<std::uint32_t> materials_;
    Numbered<std::string> groups_;
    std::vector<Vec3f> colours_;
    MeshTopology topology_;

    std::vector<Vec3f> position_;        // of the instance being added
    std::vector<std::uint32_t> vertex_;  // likewise
    std::vector<Triangle> kept_;         // likewise
};

// Corners whose normal the file does not give get a computed one.
void complete_normals(TriMesh& mesh, const ReadOptions& options)
{
    const auto& given = mesh.topology->normal_triangles;
    const auto lacks = [](const Triangle& t) {
        return t[0] == nothing || t[1] == nothing || t[2] == nothing;
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
            if (n == nothing) n = base + computed.topology->normal_triangles[f][k];
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

void fit_and_place(TriMesh& mesh, const ReadOptions& options)
{
    double scale = 1;
    if (options.fit > 0) {
        const double largest = bounds(mesh).size().maxCoeff();
        if (!(largest > 0)) {
            throw std::runtime_error("it is a single point: it cannot be scaled to a size");
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
        if (!p.allFinite()) throw std::runtime_error("scaled to that size it is too large");
    }
}

bool is_ply(const std::filesystem::path& path)
{
    std::string ending = path.extension().string();
    for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return ending == ".ply";
}

ImportedScene ply_scene(const std::filesystem::path& path)
{
    want_mesh_file(path);
    std::ifstream in(path, std::ios::binary);
    std::string bytes(std::filesystem::file_size(path), '\0');
    in.read(bytes.data(), std::ssize(bytes));
    if (!in) throw std::runtime_error(path.string() + " could not be read to its end");
    try {
        return read_ply(bytes);
    } catch (const std::runtime_error& error) {
        throw std::runtime_error(path.string() + ": " + error.what());
    }
}

// Each file once that was looked for and never found. One that is not where it should be is looked
// for in other folders too, and by names that nobody gave: without its extension, or with the
// model's own name.
std::vector<std::string> files_not_found(const std::vector<ImportedFile>& files,
                                         const std::filesystem::path& model)
{
    std::set<std::string> known;
    for (const ImportedFile& f : files) {
        if (f.found) known.insert(std::filesystem::path(f.path).filename());
    }
    std::vector<std::string> missing;
    for (const ImportedFile& f : files) {
        const std::filesystem::path asked(f.path);
        const bool guess = !asked.has_extension() || asked.stem() == model.stem();
        if (f.found || (guess && !missing.empty())) continue;
        if (known.insert(asked.filename()).second) missing.push_back(f.path);
    }
    return missing;
}

}  // namespace

ReadMesh assemble(const ImportedScene& scene, const ReadOptions& options)
{
    ReadMesh out;
    Assembly assembly(scene);
    Transform file_to_world = Transform::Identity();
    file_to_world.linear() =
        metres_of(options.unit, options.custom_unit, scene.unit) * to_y_up(options.up, scene);
    for (const ImportedNode& node : scene.nodes) {
        if (node.mesh < scene.meshes.size()) assembly.add(node, world_of(node, file_to_world));
    }
    out.mesh = assembly.finish(options);
    out.warnings = assembly.dropped.sentences();
    if (out.mesh.positions.empty()) {
        std::string why;
        for (const std::string& w : out.warnings) why += (why.empty() ? ": " : " ") + w;
        throw std::runtime_error("it holds no faces and no points that can be used" + why);
    }
    if (out.mesh.triangles().empty() || options.normals == FileNormals::none) {
        drop_normals(out.mesh);
    } else {
        complete_normals(out.mesh, options);
    }
    if (std::string far = far_from_origin(out.mesh); !far.empty()) {
        out.warnings.push_back(std::move(far));
    }
    fit_and_place(out.mesh, options);
    return out;
}

ReadMesh read_mesh(const std::filesystem::path& path, const ReadOptions& options)
{
    const ImportedScene scene = is_ply(path) ? ply_scene(path) : import_scene(path, options.import);
    if (!scene.error.empty()) {
        throw std::runtime_error(path.string() +
                                 " is damaged, or not of the format its name says: " + scene.error);
    }
    try {
        ReadMesh out = assemble(scene, options);
        const std::string itself = std::filesystem::absolute(path).string();
        for (const ImportedFile& f : scene.files) {
            if (f.path == itself) continue;
            out.side_files.push_back(f.path);
        }
        for (const std::string& name : files_not_found(scene.files, path)) {
            out.warnings.push_back("it names " + name + ", which cannot be opened.");
        }
        for (std::string& w : out.warnings) w = path.filename().string() + ": " + w;
        return out;
    } catch (const std::runtime_error& error) {
        throw std::runtime_error(path.string() + ": " + error.what());
    }
}

}  // namespace geometry
