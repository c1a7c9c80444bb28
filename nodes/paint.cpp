#include "nodes/paint.hpp"

#include "geometry/base/whole_file.hpp"
#include "geometry/cubes/assign_matter.hpp"
#include "geometry/mesh/sample_texture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace nodes {
namespace {

using geometry::MeshTopology;
using geometry::TriMesh;
using geometry::Vec2f;
using geometry::Vec3;

constexpr std::size_t places = 3;
constexpr std::array texture_names{"texture_r", "texture_g", "texture_b", "texture_a"};

bool is_letter(char c)
{
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

bool known(const std::vector<std::string>& names, std::string_view name)
{
    return std::find(names.begin(), names.end(), name) != names.end();
}

bool is_of_texture(std::string_view name)
{
    return std::find(texture_names.begin(), texture_names.end(), name) != texture_names.end();
}

bool uses_texture(std::span<const std::string> expressions)
{
    return std::any_of(expressions.begin(), expressions.end(), [](const std::string& text) {
        return std::any_of(texture_names.begin(), texture_names.end(),
                           [&](const char* name) { return mentions(text, name); });
    });
}

const geometry::Material* material_of(const MeshTopology& t, std::size_t face)
{
    const std::size_t m = t.material.empty() ? 0 : t.material[face];
    return m < t.materials.size() ? &t.materials[m] : nullptr;
}

}  // namespace

double Ramp::operator()(double x) const
{
    if (points.empty() || std::isnan(x)) return x;
    if (x < points.front().at) return points.front().value;
    const auto next = std::upper_bound(points.begin(), points.end(), x,
                                       [](double v, const RampPoint& p) { return v < p.at; });
    if (next == points.end()) return points.back().value;
    const RampPoint& low = *(next - 1);
    double t = (x - low.at) / (next->at - low.at);
    if (shape == RampShape::smooth) t = t * t * (3 - 2 * t);
    return low.value + t * (next->value - low.value);
}

void check(const Ramp& ramp)
{
    for (std::size_t i = 1; i < ramp.points.size(); ++i) {
        const double before = ramp.points[i - 1].at, at = ramp.points[i].at;
        if (at >= before) continue;
        throw std::invalid_argument(fmt::format(
            "ramp.points[{}].at: expected at least {:g}, that of the point before, found {:g}", i,
            before, at));
    }
}

static void describe_point(graph::ParamsOf<RampPoint>& p)
{
    p.param("at", &RampPoint::at, "Value of the expression.", {})
        .param("value", &RampPoint::value, "What becomes of it.", {});
}

void describe_ramp(graph::ParamsOf<Ramp>& p)
{
    p.list("points", &Ramp::points, describe_point,
           "Points of the curve, in rising order of `at`. Values beyond the first and the last "
           "become theirs. Empty: values stay as they are.")
        .choice("shape", &Ramp::shape, {"linear", "smooth"},
                "Curve between two points. linear: straight. smooth: level at each point.");
}

bool mentions(std::string_view expression, std::string_view name)
{
    for (std::size_t i = expression.find(name); i != std::string_view::npos;
         i = expression.find(name, i + 1)) {
        const std::size_t end = i + name.size();
        const bool whole = (i == 0 || !is_letter(expression[i - 1])) &&
                           (end == expression.size() || !is_letter(expression[end]));
        if (whole) return true;
    }
    return false;
}

graph::FunctionOf compiled(const std::string& expression, const std::vector<std::string>& names)
{
    try {
        return graph::Grammar().compile_of(expression, names);
    } catch (const graph::ExpressionError& error) {
        throw std::invalid_argument(fmt::format(
            "{}{}{}", error.what(), error.suggestion.empty() ? "" : "; ", error.suggestion));
    }
}

void check_name(const std::string& name)
{
    const std::vector<std::string> taken{"x", "y", "z", "r", "g", "b"};
    if (graph::Grammar::free_name(name) && !known(taken, name) && !is_of_texture(name)) return;
    throw std::invalid_argument(fmt::format(
        "expected a name of letters, digits and _ that means nothing else in expressions, found "
        "\"{}\"",
        name));
}

std::vector<std::string> usable_names(const std::vector<std::string>& names,
                                      std::vector<std::string> taken)
{
    const auto free = [&](const std::string& name) {
        return graph::Grammar::free_name(name) && !known(taken, name) && !is_of_texture(name);
    };
    std::vector<std::string> out(names.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (!free(names[i])) continue;
        out[i] = names[i];
        taken.push_back(names[i]);
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (!out[i].empty()) continue;
        std::string name = names[i].substr(0, 48);  // as long as a name may be, and room for more
        for (char& c : name) c = is_letter(c) ? c : '_';
        if (name.empty() || (name[0] >= '0' && name[0] <= '9')) name.insert(0, "_");
        const std::string start = name;
        for (int more = 1; !free(name); ++more) {
            name =
                start + (more < 8 ? std::string(std::size_t(more), '_') : fmt::format("_{}", more));
        }
        out[i] = name;
        taken.push_back(name);
    }
    return out;
}

std::shared_ptr<const geometry::Picture> picture_of(const std::filesystem::path& path,
                                                    std::span<const std::string> expressions)
{
    if (path.empty() || !uses_texture(expressions)) return nullptr;
    const auto bytes = geometry::read_whole_file(path);
    if (!bytes) throw std::invalid_argument(path.string() + " cannot be read");
    try {
        return std::make_shared<const geometry::Picture>(geometry::decode_picture(*bytes));
    } catch (const std::runtime_error& error) {
        throw std::invalid_argument(path.string() + " " + error.what());
    }
}

Paint::Paint(const TriMesh* mesh, std::shared_ptr<const geometry::Picture> picture,
             std::span<const std::string> expressions, At at)
    : picture_(std::move(picture))
{
    const bool wants_texture = uses_texture(expressions);
    if (wants_texture && !mesh) {
        throw std::invalid_argument("a texture lies on a mesh: link one to the input 'mesh'");
    }
    if (!mesh || (at != At::vertices && mesh->triangles().empty())) return;
    mesh_ = mesh;
    add_names();
    if (wants_texture) need_texture();
    if (at == At::vertices) {
        if (textured_) add_corners();
        return;
    }
    surface_ = at == At::faces;
    for (std::size_t i = places; i < names_.size(); ++i) {
        for (const std::string& text : expressions) {
            surface_ = surface_ || mentions(text, names_[i]);
        }
    }
    if (surface_) tree_ = geometry::TriangleBvh(*mesh);
}

void Paint::add_names()
{
    coloured_ = !mesh_->colours.empty() && mesh_->colours.size() == mesh_->positions.size();
    if (coloured_) names_.insert(names_.end(), {"r", "g", "b"});
    std::vector<std::string> own;
    for (const geometry::Attribute& a : mesh_->attributes) {
        if (a.values.size() != mesh_->positions.size()) continue;
        own.push_back(a.name);
        attributes_.push_back(&a);
    }
    const auto usable = usable_names(own, names_);
    names_.insert(names_.end(), usable.begin(), usable.end());
    const MeshTopology& t = *mesh_->topology;
    has_uvs_ = !t.triangles.empty() && t.uv_triangles.size() == t.triangles.size();
    if (has_uvs_) names_.insert(names_.end(), texture_names.begin(), texture_names.end());
}

void Paint::need_texture()
{
    if (!has_uvs_) {
        throw std::invalid_argument("a texture needs texture coordinates, and the mesh has none: "
                                    "unwrap it in its program and export them");
    }
    textured_ = true;
    const auto& materials = mesh_->topology->materials;
    const bool any =
        picture_ || std::any_of(materials.begin(), materials.end(),
                                [](const geometry::Material& m) { return m.texture != nullptr; });
    if (!any) {
        throw std::invalid_argument("no material of the mesh has a texture: set the parameter "
                                    "'texture'");
    }
}

// The corners of faces at each vertex, in the faces' order.
void Paint::add_corners()
{
    const auto& triangles = mesh_->triangles();
    first_.assign(mesh_->positions.size() + 1, 0);
    for (const geometry::Triangle& t : triangles) {
        for (const auto v : t) ++first_[v + 1];
    }
    for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    corner_.resize(first_.back());
    for (std::uint32_t f = 0; f < triangles.size(); ++f) {
        for (std::uint32_t k = 0; k < 3; ++k) corner_[next[triangles[f][k]]++] = 3 * f + k;
    }
}

std::array<double, 4> Paint::texture_at(std::size_t face, const Vec2f& uv) const
{
    if (picture_) return geometry::picture_at(*picture_, {}, uv);
    const geometry::Material* material = material_of(*mesh_->topology, face);
    if (!material || !material->texture) return {1, 1, 1, 1};
    return geometry::picture_at(material->texture->picture(), material->use, uv);
}

std::array<double, 4> Paint::texture_at_vertex(std::size_t vertex) const
{
    const MeshTopology& t = *mesh_->topology;
    if (first_[vertex] == first_[vertex + 1]) return {1, 1, 1, 1};  // of no face
    std::array<double, 4> sum{};
    const double count = first_[vertex + 1] - first_[vertex];
    for (std::uint32_t i = first_[vertex]; i < first_[vertex + 1]; ++i) {
        const std::uint32_t face = corner_[i] / 3;
        const auto at = texture_at(face, t.uvs[t.uv_triangles[face][corner_[i] % 3]]);
        for (std::size_t k = 0; k < 4; ++k) sum[k] += at[k] / count;
    }
    return sum;
}

std::uint32_t Paint::look(const Vec3& place, std::vector<double>& values) const
{
    values.assign(names_.size(), 0.0);
    std::copy_n(place.data(), places, values.begin());
    if (!surface_) return geometry::no_index;
    const auto hit = tree_.closest(place);
    if (!hit) return geometry::no_index;
    const MeshTopology& topology = *mesh_->topology;
    const geometry::Triangle& t = topology.triangles[hit.triangle];
    Vec2f uv(0, 0);
    std::size_t at = places;
    for (std::size_t k = 0; k < 3; ++k) {
        const double weight = hit.barycentric[static_cast<Eigen::Index>(k)];
        at = places;
        for (Eigen::Index c = 0; coloured_ && c < 3; ++c) {
            values[at++] += weight * double(mesh_->colours[t[k]][c]);
        }
        for (const geometry::Attribute* a : attributes_) {
            values[at++] += weight * double(a->values[t[k]]);
        }
        if (textured_) {
            uv += float(weight) * topology.uvs[topology.uv_triangles[hit.triangle][k]];
        }
    }
    if (textured_) {
        const auto colour = texture_at(hit.triangle, uv);
        std::copy(colour.begin(), colour.end(), values.begin() + std::ptrdiff_t(at));
    }
    return hit.triangle;
}

void Paint::at_vertex(std::size_t vertex, std::vector<double>& values) const
{
    values.assign(names_.size(), 0.0);
    for (Eigen::Index k = 0; k < 3; ++k) {
        values[static_cast<std::size_t>(k)] = double(mesh_->positions[vertex][k]);
    }
    std::size_t at = places;
    for (Eigen::Index c = 0; coloured_ && c < 3; ++c) {
        values[at++] = double(mesh_->colours[vertex][c]);
    }
    for (const geometry::Attribute* a : attributes_) values[at++] = double(a->values[vertex]);
    if (!textured_) return;
    const auto colour = texture_at_vertex(vertex);
    std::copy(colour.begin(), colour.end(), values.begin() + std::ptrdiff_t(at));
}

bool Paint::has_part(const std::string& pattern) const
{
    const std::size_t faces = mesh_ ? mesh_->triangles().size() : 0;
    for (std::uint32_t f = 0; f < faces; ++f) {
        if (in_part(f, pattern)) return true;
    }
    return false;
}

bool Paint::in_part(std::uint32_t face, const std::string& pattern) const
{
    if (face == geometry::no_index) return false;
    const MeshTopology& t = *mesh_->topology;
    const std::size_t group = t.group.empty() ? 0 : t.group[face];
    if (group < t.groups.size() && geometry::matches(t.groups[group], pattern)) return true;
    const geometry::Material* material = material_of(t, face);
    return material && geometry::matches(material->name, pattern);
}

}  // namespace nodes
