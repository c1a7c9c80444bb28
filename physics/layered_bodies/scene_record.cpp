#include "physics/layered_bodies/scene_record.hpp"

#include "geometry/base/sealed_bytes.hpp"
#include "geometry/fields/skeleton_mesh.hpp"
#include "physics/layered_bodies/layered_moment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <stdexcept>
#include <type_traits>

namespace physics {

using geometry::no_index;
using geometry::Skeleton;
using geometry::SkeletonKind;

namespace {

constexpr const char* frame_kind = "aspic-scene";
constexpr const char* body_kind = "aspic-body";
constexpr int version = 1;

// Both ways through a file, so that what is read is what was written: the same pass_...() says in
// which order members stand.
class Writer {
public:
    static constexpr bool reads = false;
    void raw(const void* data, std::size_t size)
    {
        bytes.append(static_cast<const char*>(data), size);
    }
    template <class T> void number(const T& v) { raw(&v, sizeof v); }
    void choice(auto v, auto /*last*/, const char* /*what*/)
    {
        number(static_cast<std::uint8_t>(v));
    }
    void list(const auto& v)
    {
        count(v, 1);
        raw(v.data(), v.size() * sizeof(v[0]));
    }
    void count(const auto& v, std::size_t /*each*/)
    {
        number(static_cast<std::uint32_t>(v.size()));
    }
    std::string bytes;
};

// Every read is checked; throws std::runtime_error.
class Reader {
public:
    static constexpr bool reads = true;
    explicit Reader(std::string_view bytes) : left(bytes) {}
    void raw(void* data, std::size_t size)
    {
        if (size > left.size()) {
            throw std::runtime_error(
                fmt::format("expected {} more bytes, found {}", size, left.size()));
        }
        if (size > 0) std::memcpy(data, left.data(), size);
        left.remove_prefix(size);
    }
    template <class T> void number(T& v) { raw(&v, sizeof v); }
    template <class T> void choice(T& v, T last, const char* what)
    {
        std::uint8_t found = 0;
        number(found);
        v = chosen(found, last, what);
    }
    template <class T> static T chosen(std::uint8_t found, T last, const char* what)
    {
        if (found > static_cast<std::uint8_t>(last)) {
            throw std::runtime_error(fmt::format("expected {} from 0 to {}, found {}", what,
                                                 static_cast<int>(last), found));
        }
        return static_cast<T>(found);
    }
    void list(auto& v)
    {
        count(v, sizeof(v[0]));
        raw(static_cast<void*>(v.data()), v.size() * sizeof(v[0]));
    }
    // Sizes a list of things that take at least `each` bytes.
    void count(auto& v, std::size_t each)
    {
        std::uint32_t n = 0;
        number(n);
        if (n > left.size() / each) {
            throw std::runtime_error(
                fmt::format("expected a list of {}, found {} more bytes", n, left.size()));
        }
        v.resize(n);
    }
    void expect_end() const
    {
        if (left.empty()) return;
        throw std::runtime_error(
            fmt::format("expected the end of the file, found {} more bytes", left.size()));
    }
    std::string_view left;
};

// In files and in memory, whatever else Eigen declares: plain numbers without gaps.
static_assert(sizeof(Vec3) == 24 && sizeof(Eigen::Vector4d) == 32 && sizeof(geometry::Vec3f) == 12);
static_assert(sizeof(geometry::Contribution) == 32 && sizeof(geometry::Triangle) == 12);
static_assert(sizeof(geometry::BlendLink) == 16 && sizeof(BodyPress) == 16);

template <class File> void pass_place(File& file, auto& place)
{
    file.raw(place.data(), 16 * sizeof(double));
    if constexpr (File::reads) place.makeAffine();
}

void pass_mesh(Writer& file, const Skeleton& skeleton)
{
    file.list(skeleton.mesh->mesh.positions);
    file.list(skeleton.mesh->mesh.triangles());
}

void pass_mesh(Reader& file, Skeleton& skeleton)
{
    geometry::TriMesh mesh;
    auto topology = std::make_shared<geometry::MeshTopology>();
    file.list(mesh.positions);
    file.list(topology->triangles);
    for (const geometry::Triangle& t : topology->triangles) {
        if (std::max({t[0], t[1], t[2]}) < mesh.positions.size()) continue;
        throw std::runtime_error("a mesh has a triangle of vertices that are not there");
    }
    mesh.topology = std::move(topology);
    skeleton.mesh = std::make_shared<const geometry::SkeletonMesh>(std::move(mesh));
}

// A kind that is followed by a stretch has this beside it.
constexpr std::uint8_t stretched = 0x80;

void pass_kind(Writer& file, const Skeleton& skeleton)
{
    const auto kind = static_cast<std::uint8_t>(skeleton.kind);
    file.number(static_cast<std::uint8_t>(skeleton.stretches() ? kind | stretched : kind));
    if (skeleton.stretches()) file.raw(skeleton.stretch.data(), sizeof(Mat3));
}

void pass_kind(Reader& file, Skeleton& skeleton)
{
    std::uint8_t found = 0;
    file.number(found);
    const std::uint8_t kind = found & ~stretched;
    skeleton.kind = Reader::chosen(kind, SkeletonKind::sheet, "a kind of skeleton");
    if (kind != found) file.raw(skeleton.stretch.data(), sizeof(Mat3));
}

void pass_skeleton(auto& file, auto& skeleton)
{
    pass_kind(file, skeleton);
    if (geometry::has_points(skeleton.kind)) return file.list(skeleton.points);
    file.raw(skeleton.half_size.data(), sizeof(Vec3));
    pass_place(file, skeleton.place);
    if (skeleton.kind == SkeletonKind::mesh || skeleton.kind == SkeletonKind::sheet) {
        pass_mesh(file, skeleton);
    }
}

void pass_base(auto& file, auto& base)
{
    file.choice(base.kind, BaseKind::net, "a kind of base");
    if (base.kind != BaseKind::net) return;
    file.count(base.spans, sizeof(std::uint64_t));
    for (auto& span : base.spans) file.list(span.masses);
}

void pass_body(auto& file, auto& body)
{
    auto& layer = body.layer;
    auto& matter = body.matter;
    file.count(layer.skeletons, 29);  // the least: a point
    for (auto& skeleton : layer.skeletons) pass_skeleton(file, skeleton);
    file.number(layer.isovalue);
    file.list(layer.contributions);
    file.list(layer.frame);
    file.choice(layer.blend.rule, geometry::BlendRule::gradient, "a rule of blending");
    file.list(layer.blend.part);
    file.list(layer.blend.links);
    for (auto* number : {&matter.stiffness, &matter.friction, &matter.bulge_width,
                         &matter.bulge_height, &matter.grip, &matter.bounce}) {
        file.number(*number);
    }
    file.choice(matter.rigid, true, "0 or 1");
    file.choice(matter.self_contact, true, "0 or 1");
    pass_base(file, body.base);
    file.count(body.base.frames, 16 * sizeof(double));
    for (auto& frame : body.base.frames) pass_place(file, frame);
    file.number(body.sample_spacing);
}

// Where a body stands, besides the body itself.
void pass_moment(auto& file, auto& part, auto& state)
{
    file.raw(part.colour.data(), sizeof part.colour);
    file.number(state.time);
    file.list(state.position);
    file.list(state.rotation);
    file.list(state.translation);
    file.list(state.part);
    file.list(state.links);
}

std::vector<BodyPress> presses_of(const LayeredScene& scene)
{
    if (scene.presses) return *scene.presses;
    std::map<std::pair<std::uint32_t, std::uint32_t>, double> largest;
    const LayeredMoment moment(scene, 0, Drawn::controlled);
    for (const LayerContact& contact : moment.contacts.contacts) {
        double& most = largest[std::minmax(contact.body, contact.other)];
        most = std::max(most, contact.compression);
    }
    std::vector<BodyPress> out;
    for (const auto& [pair, most] : largest) out.push_back({pair.first, pair.second, most});
    return out;
}

bool all_zero(const std::vector<double>& v)
{
    return std::all_of(v.begin(), v.end(), [](double x) { return x == 0; });
}

// Without what is as the body says: no translations, parts or links.
LayeredState brief(const LayeredBody& body, const LayeredState& state)
{
    LayeredState out;
    out.time = state.time;
    out.position = state.position;
    out.rotation = state.rotation;
    if (!all_zero(state.translation)) out.translation = state.translation;
    if (state.part != body.layer.blend.part || state.links != body.layer.blend.links) {
        out.part = state.part;
        out.links = state.links;
    }
    return out;
}

// The opposite, in place.
void complete(const LayeredBody& body, LayeredState& state)
{
    const std::size_t frames = state.position.size(), skeletons = body.layer.skeletons.size();
    if (state.part.empty() && state.links.empty()) {
        state.part = body.layer.blend.part;
        state.links = body.layer.blend.links;
    }
    if (state.translation.empty()) state.translation.assign(skeletons, 0);
    state.velocity.assign(frames, Vec3::Zero());
    state.spin.assign(frames, Vec3::Zero());
}

// A body's samples, of which there are none.
void empty_samples(LayeredBody& body)
{
    body.samples.first.assign(body.layer.skeletons.size() + 1, 0);
    body.samples.core.assign(body.layer.skeletons.size(), 0);
    body.samples.frame = body.layer.frame;
    body.volume.assign(body.layer.skeletons.size(), 0);
}

std::shared_ptr<const LayeredBody> read_body(std::string_view bytes,
                                             const geometry::ContentHash& expected)
{
    const std::string_view content = geometry::unseal(body_kind, version, bytes);
    if (geometry::hash_of(content) != expected) {
        throw std::runtime_error(
            "it holds another body than its name says: copy or write it again");
    }
    Reader file(content);
    auto body = std::make_shared<LayeredBody>();
    pass_body(file, *body);
    file.expect_end();
    const double spacing = body->sample_spacing;
    if (!(spacing >= 0) || !std::isfinite(spacing)) {
        throw std::runtime_error(
            fmt::format("expected a spacing of seeds of 0 m or more, found {}", spacing));
    }
    empty_samples(*body);
    return body;
}

// Whether each span has as many masses as its skeleton has points, all of them there.
void check_spans(const LayeredBody& body, std::size_t b)
{
    const std::size_t spans = body.base.spans.size(), frames = body.base.frames.size();
    if (spans == 0) return;
    bool good = spans <= frames;
    std::vector<char> seen(spans, 0);
    for (std::size_t s = 0; good && s < body.layer.skeletons.size(); ++s) {
        const std::size_t f = body.layer.frame[s];
        if (f < frames - spans || f >= frames) continue;
        const auto& masses = body.base.spans[f - (frames - spans)].masses;
        const auto& points = body.layer.skeletons[s].points;
        good = masses.size() == points.size() && masses.size() >= 2 && masses.size() <= 3;
        seen[f - (frames - spans)] = 1;
        for (const std::uint32_t m : masses) good = good && m < frames - spans;
    }
    good = good && std::find(seen.begin(), seen.end(), 0) == seen.end();
    if (!good) throw std::runtime_error(fmt::format("the masses of body {} do not match", b));
}

// Whether fields can be made of the scene: what a drawing takes for granted.
void check(const LayeredScene& scene)
{
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        const LayeredBody& body = *scene.parts[b].body;
        const LayeredState& state = scene.states[b];
        const std::size_t frames = state.position.size(), skeletons = body.layer.skeletons.size();
        if (state.rotation.size() != frames || body.base.frames.size() != frames ||
            body.layer.frame.size() != skeletons ||
            (!state.part.empty() && state.part.size() != skeletons)) {
            throw std::runtime_error(fmt::format("the arrays of body {} do not match", b));
        }
        check_spans(body, b);
        if (body.layer.isovalue != scene.parts[0].body->layer.isovalue) {
            throw std::runtime_error(
                fmt::format("body {} has another isovalue than those before it", b));
        }
    }
    for (const BodyPress& press : *scene.presses) {
        if (std::max(press.body, press.other) >= scene.parts.size() ||
            !std::isfinite(press.compression)) {
            throw std::runtime_error("a contact is one of bodies that are not there");
        }
    }
    try {
        static_cast<void>(LayeredMoment(scene));
    } catch (const std::invalid_argument& wrong) {
        throw std::runtime_error(wrong.what());
    }
}

// The bodies of a frame: their folder, and what their files hold.
struct BodyFiles {
    std::string folder;
    std::vector<geometry::ContentHash> hash;

    std::string path(std::size_t i) const
    {
        return fmt::format("{}/{}.body", folder, geometry::name_of(hash[i]));
    }
};

BodyFiles read_names(Reader& file)
{
    BodyFiles files;
    file.list(files.folder);
    file.list(files.hash);
    const bool plain =
        !files.folder.empty() && files.folder[0] != '.' &&
        files.folder.find_first_of(std::string_view("/\\\0", 3)) == std::string::npos;
    if (!plain) throw std::runtime_error("expected the name of a folder beside the frame");
    // Each would be read again.
    std::vector<std::string> names;
    for (const auto& hash : files.hash) names.push_back(geometry::name_of(hash));
    std::sort(names.begin(), names.end());
    if (std::adjacent_find(names.begin(), names.end()) != names.end()) {
        throw std::runtime_error("expected each body once, found one twice");
    }
    return files;
}

}  // namespace

SceneRecord record(const LayeredScene& scene, std::string_view stem)
{
    std::map<geometry::ContentHash, std::uint32_t> number;
    BodyFiles files{fmt::format("{}.bodies", stem), {}};
    SceneRecord out;
    Writer moments;
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        const LayeredPart& part = scene.parts[b];
        Writer body;
        pass_body(body, *part.body);
        const geometry::ContentHash hash = geometry::hash_of(body.bytes);
        const auto [at, is_new] =
            number.emplace(hash, static_cast<std::uint32_t>(files.hash.size()));
        if (is_new) {
            files.hash.push_back(hash);
            out.bodies[files.path(at->second)] = geometry::seal(body_kind, version, body.bytes);
        }
        moments.number(at->second);
        const LayeredState state = brief(*part.body, scene.states[b]);
        pass_moment(moments, part, state);
    }
    Writer frame;
    frame.list(files.folder);
    frame.list(files.hash);
    frame.number(static_cast<std::uint32_t>(scene.parts.size()));
    frame.bytes += moments.bytes;
    frame.list(presses_of(scene));
    out.frame = geometry::seal(frame_kind, version, frame.bytes);
    return out;
}

std::vector<std::string> bodies_of_record(std::string_view frame)
{
    Reader file(geometry::unseal(frame_kind, version, frame));
    const BodyFiles files = read_names(file);
    std::vector<std::string> paths;
    for (std::size_t i = 0; i < files.hash.size(); ++i) paths.push_back(files.path(i));
    return paths;
}

LayeredScene read_record(std::string_view frame, std::span<const std::string> bodies)
{
    Reader file(geometry::unseal(frame_kind, version, frame));
    const BodyFiles files = read_names(file);
    if (bodies.size() != files.hash.size()) {
        throw std::runtime_error(
            fmt::format("expected {} bodies, found {}", files.hash.size(), bodies.size()));
    }
    std::vector<std::shared_ptr<const LayeredBody>> known;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        try {
            known.push_back(read_body(bodies[i], files.hash[i]));
        } catch (const std::runtime_error& wrong) {
            throw std::runtime_error(fmt::format("{}: {}", files.path(i), wrong.what()));
        }
    }
    LayeredScene scene;
    file.count(scene.parts, 44);  // the least that a part takes
    scene.states.resize(scene.parts.size());
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        std::uint32_t which = 0;
        file.number(which);
        if (which >= known.size()) {
            throw std::runtime_error(
                fmt::format("part {} is body {} of {}", b, which, known.size()));
        }
        scene.parts[b].body = known[which];
        pass_moment(file, scene.parts[b], scene.states[b]);
        complete(*scene.parts[b].body, scene.states[b]);
    }
    file.list(scene.presses.emplace());
    file.expect_end();
    check(scene);
    return scene;
}

LayeredScene with_samples(LayeredScene scene)
{
    for (LayeredPart& part : scene.parts) {
        if (!has_surface(*part.body)) continue;
        LayeredBody body = *part.body;
        body.samples = make_surface_samples(body.layer, body.sample_spacing);
        part.body = std::make_shared<const LayeredBody>(std::move(body));
    }
    scene.presses.reset();
    return scene;
}

}  // namespace physics
