#include "render/fade.hpp"

#include "geometry/base/stop.hpp"
#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/unstated_material.hpp"

#include <charconv>
#include <stdexcept>
#include <system_error>

namespace render {
namespace {

Vec3f mixed(const Vec3f& a, const Vec3f& b, float share)
{
    return linear_from_srgb(Vec3f((1 - share) * srgb_from_linear(a) + share * srgb_from_linear(b)));
}

}  // namespace

TriMesh faded(const TriMesh& mesh, const Vec3f& colour, float share, float opacity)
{
    TriMesh out = mesh;
    geometry::MeshTopology topology = *mesh.topology;
    if (topology.materials.empty()) topology.materials.emplace_back();
    const bool own = geometry::has_vertex_colours(mesh);
    for (geometry::Material& material : topology.materials) {
        // Where the vertices are seen in their own colours, it stays one that nothing was said of.
        const bool unseen = own && geometry::is_unstated(material);
        if (!unseen) material.colour = mixed(material.colour, colour, share);
        material.opacity *= opacity;
        const bool cuts = material.use.alpha != geometry::TextureUse::Alpha::ignored;
        if (share > 0 && !cuts) material.texture = nullptr;
    }
    if (topology.triangles.empty() && out.colours.empty()) {  // a cloud has no material to see
        out.colours.assign(out.positions.size(), geometry::Material{}.colour);
    }
    for (Vec3f& c : out.colours) c = mixed(c, colour, share);
    out.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
    return out;
}

TriMesh onion_skin(std::span<const std::shared_ptr<const TriMesh>> meshes, const Fade& fade)
{
    std::vector<TriMesh> skins;
    for (std::size_t back = 0; back < meshes.size(); ++back) {
        geometry::stop_if_asked();
        const auto& mesh = *meshes[meshes.size() - 1 - back];
        const double ago = meshes.size() > 1 ? double(back) / double(meshes.size() - 1) : 0;
        skins.push_back(faded(mesh, fade.colour, static_cast<float>(fade.share * ago),
                              static_cast<float>(1 - (1 - fade.opacity) * ago)));
    }
    std::vector<const TriMesh*> all;
    for (const TriMesh& skin : skins) all.push_back(&skin);
    return geometry::merge(all);
}

std::vector<int> numbers_in(const std::string& text)
{
    std::vector<int> numbers;
    const auto parts = [](char c) { return c == ' ' || c == ','; };
    const char* at = text.data();
    const char* const end = at + text.size();
    while (true) {
        while (at < end && parts(*at)) ++at;
        if (at == end) break;
        int number = 0;
        const auto [after, error] = std::from_chars(at, end, number);
        if (error != std::errc() || (after < end && !parts(*after))) {
            throw std::invalid_argument("expected whole numbers parted by commas, found \"" + text +
                                        "\"");
        }
        numbers.push_back(number);
        at = after;
    }
    if (numbers.empty()) {
        throw std::invalid_argument("expected whole numbers parted by commas, found none");
    }
    return numbers;
}

}  // namespace render
