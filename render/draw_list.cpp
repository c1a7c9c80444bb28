#include "render/draw_list.hpp"

#include "geometry/normals.hpp"
#include "geometry/parallel.hpp"
#include "render/surface_layout.hpp"

#include <atomic>
#include <cmath>
#include <stdexcept>

namespace render {
namespace {

using geometry::Triangle;
using geometry::Vec2f;

constexpr std::size_t grain = 8192;
constexpr double crease = 0.7;    // radians, for meshes that come without normals
constexpr float farthest = 1e6;   // stage units: what lies beyond takes no part
constexpr float floor_reach = 9;  // stage units, FLOOR_REACH of shaders/frame.glsl

std::uint8_t byte(float x)
{
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(x, 0.0f, 1.0f)));
}

std::array<std::uint8_t, 4> root_and(const Vec3f& linear, float fourth)
{
    const Vec3f root = linear.cwiseMax(0).cwiseSqrt();
    return {byte(root[0]), byte(root[1]), byte(root[2]), byte(fourth)};
}

std::array<std::int16_t, 2> packed(const Vec3f& normal)
{
    const float length = normal.norm();
    const Vec2f at = octahedral(length > 0 && std::isfinite(length) ? Vec3f(normal / length)
                                                                    : Vec3f(Vec3f::UnitY()));
    return {static_cast<std::int16_t>(std::lround(at[0] * 32767)),
            static_cast<std::int16_t>(std::lround(at[1] * 32767))};
}

// Gathers shapes into a DrawList.
class Gatherer {
public:
    Gatherer(DrawList& list, const Vec3& towards_eye)
        : list_(list), towards_eye_(towards_eye.cast<float>())
    {
        centre_ = list.units.centre.cast<float>();
        reach_ = farthest / float(list.units.scale);
    }

    void add(const Surface& surface, std::size_t number);
    void add(const Lines& lines);
    void add(const Balls& balls);
    void finish();  // sorts what is transparent

private:
    bool drawable(const Vec3f& p) const
    {
        return (p - centre_).cwiseAbs().maxCoeff() <= reach_;  // false for not-a-number
    }
    void warn(std::string text) { list_.warnings.push_back(std::move(text)); }
    Batch open(Batch::Shape shape) const
    {
        Batch batch;
        batch.shape = shape;
        batch.first = static_cast<std::uint32_t>(list_.indices.size());
        return batch;
    }
    void close(Batch batch)
    {
        batch.count = static_cast<std::uint32_t>(list_.indices.size()) - batch.first;
        if (batch.count > 0) list_.opaque.push_back(batch);
    }

    struct ClearTriangle {
        float depth;
        Triangle corners;
        std::uint32_t style;  // into styles_
    };

    DrawList& list_;
    Vec3f towards_eye_, centre_;
    float reach_;
    std::vector<ClearTriangle> clear_;
    std::vector<Batch> styles_;
};

// The mesh with normals, or the given one when it has them. Null when it has none and none can be
// computed, as its faces name vertices that are not there.
std::shared_ptr<const TriMesh> with_normals(const std::shared_ptr<const TriMesh>& mesh)
{
    const auto& topology = *mesh->topology;
    if (topology.normal_triangles.size() == topology.triangles.size() &&
        (!mesh->normals.empty() || topology.triangles.empty())) {
        return mesh;
    }
    auto out = std::make_shared<TriMesh>();
    out->topology = mesh->topology;
    out->positions = mesh->positions;
    out->colours = mesh->colours;
    out->attributes = mesh->attributes;
    const std::size_t count = mesh->positions.size();
    const auto broken = [&](const Triangle& t) {
        return t[0] >= count || t[1] >= count || t[2] >= count;
    };
    if (std::any_of(topology.triangles.begin(), topology.triangles.end(), broken)) return nullptr;
    geometry::compute_normals(*out, crease);
    return out;
}

const geometry::Attribute* find_attribute(const TriMesh& mesh, const std::string& name)
{
    for (const auto& a : mesh.attributes) {
        if (a.name == name && a.values.size() == mesh.positions.size()) return &a;
    }
    return nullptr;
}

[[noreturn]] void no_such_attribute(const TriMesh& mesh, const std::string& wanted)
{
    std::string has;
    for (const auto& a : mesh.attributes) has += (has.empty() ? "" : ", ") + a.name;
    throw std::invalid_argument("the mesh is to be coloured by `" + wanted +
                                "`, which it does not have; it has " +
                                (has.empty() ? "no attributes" : has));
}

void Gatherer::add(const Surface& surface, std::size_t number)
{
    const auto mesh = with_normals(surface.mesh);
    const std::string name = "surface " + std::to_string(number + 1);
    if (!mesh) {
        warn(name + " is not drawn: it has no normals, and faces that name vertices that are not "
                    "there");
        return;
    }
    SurfaceLayout made;
    const SurfaceLayout* layout = surface.layout.get();
    if (!layout || !layout->suits(*mesh)) {
        made = surface_layout(*mesh);
        layout = &made;
    }
    if (layout->skipped > 0) {
        warn(name + ": " + std::to_string(layout->skipped) +
             " faces are not drawn: they name vertices, normals or materials that are not there");
    }

    const Paint& paint = surface.paint;
    const geometry::Attribute* attribute = nullptr;
    if (paint.by == Paint::By::attribute) {
        attribute = find_attribute(*mesh, paint.attribute);
        if (!attribute) no_such_attribute(*mesh, paint.attribute);
    }
    const bool by_vertex =
        paint.by == Paint::By::vertex_colour && mesh->colours.size() == mesh->positions.size();

    // What each material looks like, once.
    const geometry::Material plain;
    const auto& materials = mesh->topology->materials;
    std::vector<Vertex> looks(std::max<std::size_t>(1, materials.size()));
    for (std::size_t m = 0; m < looks.size(); ++m) {
        const geometry::Material& material = m < materials.size() ? materials[m] : plain;
        const Vec3f& colour = paint.by == Paint::By::constant ? paint.colour : material.colour;
        looks[m] = {};
        looks[m].colour = root_and(colour, material.roughness);
        looks[m].material = {byte(material.metallic), byte(material.opacity * surface.opacity),
                             surface.receives ? std::uint8_t{255} : std::uint8_t{0}, 0};
    }

    const std::size_t base = list_.vertices.size(), count = layout->position.size();
    list_.vertices.resize(base + count);
    std::atomic<std::size_t> bad = 0;
    geometry::parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
        std::size_t bad_here = 0;
        for (std::size_t i = begin; i < end; ++i) {
            Vertex& v = list_.vertices[base + i];
            const std::uint32_t from = layout->position[i];
            const Vec3f& p = mesh->positions[from];
            v = looks[layout->material[i]];
            v.position = {p[0], p[1], p[2]};
            v.normal = packed(mesh->normals[layout->normal[i]]);
            if (attribute) v.value = paint.scale.place(attribute->values[from]);
            if (by_vertex) {
                const auto rough = v.colour[3];
                v.colour = root_and(mesh->colours[from], 0);
                v.colour[3] = rough;
            }
            bad_here += drawable(p) ? 0 : 1;
        }
        bad += bad_here;
    });
    if (bad > 0) {
        warn(name + ": " + std::to_string(bad) +
             " vertices are not finite or immensely far away: their faces are not drawn");
    }

    const auto offset = static_cast<std::uint32_t>(base);
    const auto draws = [&](const Triangle& t) {
        if (bad == 0) return true;
        for (const auto i : t) {
            const auto& p = list_.vertices[offset + i].position;
            if (!drawable({p[0], p[1], p[2]})) return false;
        }
        return true;
    };
    Batch batch = open(Batch::Shape::triangles);
    batch.mapped = attribute != nullptr;
    batch.map = paint.scale.map;
    batch.shadow = surface.shadow;
    const std::size_t opaque = surface.opacity < 1 ? 0 : layout->opaque;
    list_.indices.reserve(list_.indices.size() + 3 * opaque);
    for (std::size_t f = 0; f < opaque; ++f) {
        const Triangle& t = layout->triangles[f];
        if (!draws(t)) continue;
        for (const auto i : t) list_.indices.push_back(offset + i);
    }
    close(batch);

    const auto style = static_cast<std::uint32_t>(styles_.size());
    styles_.push_back(batch);
    for (std::size_t f = opaque; f < layout->triangles.size(); ++f) {
        const Triangle& t = layout->triangles[f];
        if (!draws(t)) continue;
        Vec3f sum = Vec3f::Zero();
        for (const auto i : t) sum += Vec3f(list_.vertices[offset + i].position.data()) - centre_;
        clear_.push_back(
            {sum.dot(towards_eye_), {offset + t[0], offset + t[1], offset + t[2]}, style});
    }
}

void Gatherer::add(const Lines& lines)
{
    Batch batch = open(Batch::Shape::lines);
    batch.size = lines.width;
    batch.shadow = false;
    Vertex v{};
    v.colour = root_and(lines.colour, 1);
    v.material = {0, 255, 0, 0};
    for (std::size_t i = 0; i + 1 < lines.ends.size(); i += 2) {
        if (!drawable(lines.ends[i]) || !drawable(lines.ends[i + 1])) continue;
        for (std::size_t k = i; k < i + 2; ++k) {
            const Vec3f& p = lines.ends[k];
            v.position = {p[0], p[1], p[2]};
            list_.indices.push_back(static_cast<std::uint32_t>(list_.vertices.size()));
            list_.vertices.push_back(v);
        }
    }
    close(batch);
}

void Gatherer::add(const Balls& balls)
{
    if (balls.colours.size() != 1 && balls.colours.size() != balls.centres.size()) {
        throw std::invalid_argument("balls need one colour, or one for each");
    }
    Batch batch = open(Batch::Shape::balls);
    batch.shadow = balls.shadow;
    batch.size = balls.smallest;
    Vertex v{};
    v.material = {0, 255, 255, 0};
    v.value = balls.radius;
    for (std::size_t i = 0; i < balls.centres.size(); ++i) {
        const Vec3f& p = balls.centres[i];
        if (!drawable(p)) continue;
        v.position = {p[0], p[1], p[2]};
        v.colour = root_and(balls.colours[balls.colours.size() == 1 ? 0 : i], 0.5);
        list_.indices.push_back(static_cast<std::uint32_t>(list_.vertices.size()));
        list_.vertices.push_back(v);
    }
    close(batch);
}

// Far to near by the triangles' centres. Neighbours in that order with the same style share a
// batch.
void Gatherer::finish()
{
    std::stable_sort(
        clear_.begin(), clear_.end(),
        [](const ClearTriangle& a, const ClearTriangle& b) { return a.depth < b.depth; });
    for (std::size_t i = 0; i < clear_.size(); ++i) {
        if (i == 0 || clear_[i].style != clear_[i - 1].style) {
            Batch batch = styles_[clear_[i].style];
            batch.first = static_cast<std::uint32_t>(list_.indices.size());
            batch.count = 0;
            list_.clear.push_back(batch);
        }
        list_.indices.insert(list_.indices.end(), clear_[i].corners.begin(),
                             clear_[i].corners.end());
        list_.clear.back().count += 3;
    }
}

// The box of all drawn points in the basis `axes` (rows), stage units.
Box box_along(const DrawList& list, const geometry::Mat3& axes, bool only_casters)
{
    std::vector<Box> parts;
    for (const auto* batches : {&list.opaque, &list.clear}) {
        for (const Batch& batch : *batches) {
            if (only_casters && !batch.shadow) continue;
            const std::size_t pieces = (batch.count + grain - 1) / grain;
            const std::size_t at = parts.size();
            parts.resize(at + pieces);
            geometry::parallel_for(pieces, 1, [&](std::size_t begin, std::size_t end) {
                for (std::size_t piece = begin; piece < end; ++piece) {
                    const std::size_t stop =
                        std::min<std::size_t>(batch.count, (piece + 1) * grain);
                    Box box;
                    for (std::size_t i = piece * grain; i < stop; ++i) {
                        const auto& v = list.vertices[list.indices[batch.first + i]];
                        const Vec3 q = list.units(Vec3f(v.position.data()).cast<double>());
                        const Vec3 p = axes * q;
                        if (batch.shape == Batch::Shape::balls) {
                            const Vec3 r = Vec3::Constant(v.value * list.units.scale);
                            box.add(Vec3(p - r));
                            box.add(Vec3(p + r));
                        } else {
                            box.add(p);
                        }
                    }
                    parts[at + piece] = box;
                }
            });
        }
    }
    Box box;
    for (const Box& part : parts) {
        if (!part.empty()) box.add(part);
    }
    return box;
}

// Grows `box` about its centre, an axis at a time, by steps of a quarter until it holds `inside`:
// what moves inside a step changes nothing, so that a shadow does not crawl from frame to frame.
Box grown_to_hold(Box box, const Box& inside)
{
    if (inside.empty()) return box;
    for (int k = 0; k < 3; ++k) {
        const double middle = 0.5 * (box.lo[k] + box.hi[k]);
        double half = std::max(0.5 * (box.hi[k] - box.lo[k]), 1e-3);
        const double needed = std::max(inside.hi[k] - middle, middle - inside.lo[k]);
        while (half < needed) half *= 1.25;
        box.lo[k] = middle - half;
        box.hi[k] = middle + half;
    }
    return box;
}

geometry::Mat3 light_axes(const Vec3& to_light)
{
    const Vec3 side =
        std::abs(to_light.y()) > 0.999 ? Vec3(1, 0, 0) : Vec3(0, 1, 0).cross(to_light).normalized();
    geometry::Mat3 axes;
    axes.row(0) = side;
    axes.row(1) = to_light.cross(side);
    axes.row(2) = -to_light;
    return axes;
}

// The part of the floor at `height` that lies behind `casters`, a box along the light's axes. The
// floor is cut off where it has faded away.
std::vector<Vec3f> shadowed_floor(const geometry::Mat3& axes, const Box& casters, double height)
{
    std::vector<Vec3f> corners;
    for (int k = 0; k < 4; ++k) {
        const Vec3 p = axes.transpose() * Vec3(k & 1 ? casters.hi.x() : casters.lo.x(),
                                               k & 2 ? casters.hi.y() : casters.lo.y(), 0);
        const Vec3 along = axes.row(2);
        Vec3 at = p + (height - p.y()) / along.y() * along;
        for (const int i : {0, 2}) at[i] = std::clamp(at[i], -1.0 * floor_reach, 1.0 * floor_reach);
        corners.push_back(at.cast<float>());
    }
    return corners;
}

ShadowMap shadow_map(DrawList& list, const Vec3& to_light, const Box& stage, ShadowQuality quality)
{
    ShadowMap map;
    if (quality == ShadowQuality::off) return map;
    const geometry::Mat3 axes = light_axes(to_light);
    const Box casters = box_along(list, axes, true);
    if (casters.empty()) return map;

    Box box;
    for (int k = 0; k < 8; ++k) {
        box.add(Vec3(axes * list.units(corner_of(stage, k))));
    }
    box = grown_to_hold(box, casters);

    // Square texels, as many as the quality affords however long and thin the box is.
    const int side = quality == ShadowQuality::low      ? 512
                     : quality == ShadowQuality::medium ? 1024
                                                        : 2048;
    const double rim = 6;  // texels left free, for the filter
    const Vec3 size = box.size().cwiseMax(Vec3::Constant(1e-2));
    const double limit = 4.0 * side;
    const double texel = std::max(std::sqrt(size.x() * size.y()) / side,
                                  std::max(size.x(), size.y()) / (limit - 2 * rim));
    map.width = static_cast<int>(std::ceil(size.x() / texel + 2 * rim));
    map.height = static_cast<int>(std::ceil(size.y() / texel + 2 * rim));
    map.texel = static_cast<float>(texel);

    const Vec3 centre = box.centre();
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    const Vec3 scale(1 / (texel * map.width), 1 / (texel * map.height), 0.98 / size.z());
    for (int k = 0; k < 3; ++k) {
        m.block<1, 3>(k, 0) = scale[k] * axes.row(k);
        m(k, 3) = 0.5 - scale[k] * centre[k];
    }
    map.from_stage = m.cast<float>();
    if (list.ground && to_light.y() > 0.01) {
        const Vec3 rim_size(rim * texel, rim * texel, 0);
        list.shadowed_floor =
            shadowed_floor(axes, {casters.lo - rim_size, casters.hi + rim_size}, *list.ground);
    }
    return map;
}

View view_of(const Camera& camera, const DrawList& list, const Look& look)
{
    const Vec3 eye = list.units(camera.eye), target = list.units(camera.target);
    const Vec3 ahead = target - eye;
    if (!eye.allFinite() || !ahead.allFinite() || ahead.norm() == 0) {
        throw std::invalid_argument(
            "the camera must stand at a finite place other than its target");
    }
    const double fov = camera.field_of_view;
    if (!(fov > 1e-3 && fov < 3.1)) {
        throw std::invalid_argument("the camera's field of view must lie between 0.06 and 177 "
                                    "degrees, got " +
                                    std::to_string(fov * 180 / 3.141592653589793));
    }
    const geometry::Mat3 axes = camera_axes(camera);
    const Vec3 right = axes.row(0), up = axes.row(1), forward = axes.row(2);
    const Box box = box_along(list, axes, false);
    const double eye_depth = forward.dot(eye);
    double far = box.empty() ? 2 : 1.01 * (box.hi.z() - eye_depth) + 1e-3;
    far = std::max(far, 1e-3);
    double near = box.empty() ? 1 : 0.99 * (box.lo.z() - eye_depth) - 1e-3;
    for (const Vec3f& corner : list.floor) {
        far = std::max(far, 1.01 * (forward.dot(corner.cast<double>()) - eye_depth));
        near = std::min(near, 0.01);
    }
    near = std::max(near, 1e-4 * far);

    const double tan_y = std::tan(fov / 2), tan_x = tan_y * look.width / look.height;
    // Depth runs from 1 at `near` to 0 at `far`: floating-point depths are then even in error.
    Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
    clip(0, 0) = 1 / tan_x;
    clip(1, 1) = -1 / tan_y;  // pictures have their first row on top
    clip(2, 2) = -near / (far - near);
    clip(2, 3) = near * far / (far - near);
    clip(3, 2) = 1;
    Eigen::Matrix4d turn = Eigen::Matrix4d::Identity();
    turn.topLeftCorner<3, 3>() = axes;
    turn.topRightCorner<3, 1>() = -(axes * eye);

    View view;
    view.clip_from_stage = (clip * turn).cast<float>();
    view.eye = eye.cast<float>();
    view.corner = (forward - tan_x * right + tan_y * up).cast<float>();
    view.across = (2 * tan_x / look.width * right).cast<float>();
    view.down = (-2 * tan_y / look.height * up).cast<float>();
    view.near = static_cast<float>(near);
    view.far = static_cast<float>(far);
    return view;
}

void check(const Scene& scene, const Look& look)
{
    if (look.width < 1 || look.height < 1 || look.width > 8192 || look.height > 8192) {
        throw std::invalid_argument("a picture must be 1 to 8192 pixels wide and high, got " +
                                    std::to_string(look.width) + " x " +
                                    std::to_string(look.height));
    }
    for (const Surface& s : scene.surfaces) {
        if (!s.mesh) throw std::invalid_argument("a surface to be drawn has no mesh");
    }
}

}  // namespace

Vec2f octahedral(const Vec3f& unit)
{
    const float sum = unit.cwiseAbs().sum();
    Vec2f at = unit.head<2>() / sum;
    if (unit.z() < 0) {
        const Vec2f folded(1 - std::abs(at.y()), 1 - std::abs(at.x()));
        at = Vec2f(std::copysign(folded.x(), at.x()), std::copysign(folded.y(), at.y()));
    }
    return at;
}

DrawList draw_list(const Scene& scene, const Camera& camera, const Look& look)
{
    check(scene, look);
    DrawList list;
    Box stage = scene.stage.empty() ? bounds(scene) : scene.stage;
    if (stage.empty()) stage.add(Vec3(Vec3::Zero()));
    if (!(stage.diagonal() > 1e-12 * std::max(1.0, stage.centre().cwiseAbs().maxCoeff()))) {
        stage.lo.array() -= 0.5;
        stage.hi.array() += 0.5;
    }
    if (!std::isfinite(stage.diagonal())) {
        throw std::invalid_argument("the stage to be drawn is not finite");
    }
    list.units = {stage.centre(), 2 / stage.diagonal()};

    Gatherer gatherer(list, camera.eye - camera.target);
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i) gatherer.add(scene.surfaces[i], i);
    for (const Lines& lines : scene.lines) gatherer.add(lines);
    for (const Balls& balls : scene.balls) gatherer.add(balls);
    gatherer.finish();

    const Vec3 to_light = direction(look.light_azimuth, look.light_elevation);
    list.to_light = to_light.cast<float>();
    // From below the floor one looks through it.
    const double eye_height = list.units(camera.eye).y();
    if (scene.ground && list.units(Vec3(0, *scene.ground, 0)).y() < eye_height) {
        list.ground = static_cast<float>(list.units(Vec3(0, *scene.ground, 0)).y());
        // Fine lines a tenth of the spacing apart, by what the picture holds at its target: they
        // stay as they are while the camera does, whatever flies about.
        const double height = 2 * std::tan(0.5 * camera.field_of_view) *
                              std::max((camera.eye - camera.target).norm(), 1e-9);
        const double spacing = std::pow(10, std::floor(std::log10(0.27 * height)));
        list.grid_spacing = static_cast<float>(spacing * list.units.scale);
        for (int k = 0; k < 4; ++k) {
            list.floor.emplace_back(k & 1 ? floor_reach : -floor_reach, *list.ground,
                                    k & 2 ? floor_reach : -floor_reach);
        }
    }
    list.shadow = shadow_map(list, to_light, stage, look.shadow);
    list.view = view_of(camera, list, look);
    return list;
}

}  // namespace render
