#include "physics/layer_skin.hpp"

#include "geometry/normals.hpp"
#include "geometry/parallel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace physics {
namespace {

using geometry::TriMesh;
using geometry::Vec3f;

constexpr std::size_t skin_grain = 256;

std::vector<std::uint32_t> vertices_of_normals(const TriMesh& mesh)
{
    std::vector<std::uint32_t> vertex(mesh.normals.size(), 0xffffffff);
    const auto& topology = *mesh.topology;
    for (std::size_t t = 0; t < topology.normal_triangles.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            vertex[topology.normal_triangles[t][k]] = topology.triangles[t][k];
        }
    }
    return vertex;
}

struct Pull {
    std::uint32_t frame;
    double f;
};

// Who reaches p, by frame, the strongest first; the nearest skeleton's frame with f = 0 when
// nobody.
void find_reach(const Field& field, std::span<const std::uint32_t> frame_of, const Vec3& p,
                std::vector<Pull>& out)
{
    out.clear();
    double nearest = std::numeric_limits<double>::infinity();
    std::uint32_t owner = frame_of[0];
    for (std::uint32_t s = 0; s < field.count(); ++s) {
        const double r = geometry::foot(field, s, p).r;
        if (r - field.profile[s].e < nearest) {
            nearest = r - field.profile[s].e;
            owner = frame_of[s];
        }
        const double f = geometry::profile_at(field.profile[s], r).f;
        if (!(f > 0)) continue;
        const auto same = std::find_if(out.begin(), out.end(),
                                       [&](const Pull& o) { return o.frame == frame_of[s]; });
        if (same != out.end()) {
            same->f += f;
        } else {
            out.push_back({frame_of[s], f});
        }
    }
    if (out.empty()) out.push_back({owner, 0});
    std::stable_sort(out.begin(), out.end(),
                     [](const Pull& a, const Pull& b) { return a.f > b.f; });
    if (out.size() > LayerSkin::most) out.resize(LayerSkin::most);
}

// Along the gradient to D = value, in steps of a quarter of the thickness at most; stays where the
// field has no slope.
Vec3 onto_value(const DeformedLayer& layer, double value, double thickness, Vec3 p)
{
    for (int i = 0; i < 12; ++i) {
        const geometry::FieldValue at = value_at(layer, p);
        const double slope = at.gradient.norm();
        const double miss = value - at.f;
        if (!(slope > 0) || std::abs(miss) < 1e-9) break;
        p += std::clamp(miss / slope, -0.25 * thickness, 0.25 * thickness) * at.gradient / slope;
    }
    return p;
}

}  // namespace

LayerSkin bind(const TriMesh& mesh, const LayeredBody& body)
{
    if (body.layer.skeletons.empty()) {
        throw std::invalid_argument(
            "a skin needs a layer with skeletons to be bound to; this has none");
    }
    const Field field = geometry::make_field(body.layer, body.base.frames);
    const std::size_t n = mesh.positions.size();
    LayerSkin skin;
    skin.frame.resize(n);
    skin.weight.resize(n);
    skin.value.resize(n);
    skin.normal_vertex = vertices_of_normals(mesh);
    skin.thickness = std::numeric_limits<double>::infinity();
    for (const geometry::Contribution& c : body.layer.contributions) {
        skin.thickness = std::min(skin.thickness, c.thickness);
    }
    geometry::parallel_for(n, skin_grain, [&](std::size_t begin, std::size_t end) {
        std::vector<Pull> reach;
        for (std::size_t v = begin; v < end; ++v) {
            const Vec3 p = mesh.positions[v].cast<double>();
            find_reach(field, body.layer.frame, p, reach);
            double sum = 0;
            for (const Pull& r : reach) sum += r.f;
            for (std::size_t k = 0; k < LayerSkin::most; ++k) {
                const bool there = k < reach.size();
                skin.frame[v][k] = there ? reach[k].frame : 0;
                skin.weight[v][k] = !there ? 0 : sum > 0 ? reach[k].f / sum : 1;
            }
            skin.value[v] = geometry::value_at(field, p).f;
        }
    });
    for (const double value : skin.value) skin.out_of_reach += !(value > 0);
    return skin;
}

TriMesh follow(const LayerSkin& skin, const TriMesh& mesh, const LayeredScene& scene,
               std::size_t body)
{
    if (body >= scene.parts.size() || mesh.positions.size() != skin.value.size() ||
        mesh.normals.size() != skin.normal_vertex.size()) {
        throw std::invalid_argument(fmt::format("a skin of {} vertices and {} normals cannot make "
                                                "a mesh of {} and {} follow body {} of "
                                                "{}",
                                                skin.value.size(), skin.normal_vertex.size(),
                                                mesh.positions.size(), mesh.normals.size(), body,
                                                scene.parts.size()));
    }
    const LayeredMoment moment(scene);
    const std::vector<Transform>& rest = scene.parts[body].body->base.frames;
    std::vector<Transform> moved;
    for (std::size_t b = 0; b < rest.size(); ++b) {
        moved.push_back(moment.frames[body][b] * rest[b].inverse());
    }
    for (const auto& frames : skin.frame) {
        for (const std::uint32_t f : frames) {
            if (f >= moved.size()) {
                throw std::invalid_argument(fmt::format(
                    "a skin bound to frame {} cannot follow a body of {} frames", f, moved.size()));
            }
        }
    }
    const DeformedLayer layer =
        deformed(moment.bodies, static_cast<std::uint32_t>(body), moment.contacts);
    TriMesh out = mesh;
    geometry::parallel_for(mesh.positions.size(), skin_grain,
                           [&](std::size_t begin, std::size_t end) {
                               for (std::size_t v = begin; v < end; ++v) {
                                   const Vec3 at = mesh.positions[v].cast<double>();
                                   Vec3 p = Vec3::Zero();
                                   for (std::size_t k = 0; k < LayerSkin::most; ++k) {
                                       if (skin.weight[v][k] > 0)
                                           p += skin.weight[v][k] * (moved[skin.frame[v][k]] * at);
                                   }
                                   if (skin.value[v] > 0)
                                       p = onto_value(layer, skin.value[v], skin.thickness, p);
                                   out.positions[v] = p.cast<float>();
                               }
                           });
    if (!mesh.normals.empty()) geometry::compute_normals(out, 0.8);
    return out;
}

}  // namespace physics
