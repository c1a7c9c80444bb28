#include "physics/layered_bodies/scene_record.hpp"

#include "geometry/base/random.hpp"
#include "geometry/base/sealed_bytes.hpp"
#include "geometry/fields/skeleton_mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/layered_bodies/layered_mesh.hpp"
#include "physics/layered_bodies/layered_moment.hpp"
#include "physics/layered_bodies/layered_step.hpp"
#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

namespace physics {

using namespace layered_fixtures;

namespace {

LayeredScene read_back(const SceneRecord& record)
{
    std::vector<std::string> bodies;
    for (const std::string& name : bodies_of_record(record.frame)) {
        bodies.push_back(record.bodies.at(name));
    }
    return read_record(record.frame, bodies);
}

// A body of one skeleton of each kind in a row, the last two of a mesh, under a ball that presses
// two of them and keeps its volume, on the floor.
LayeredScene every_kind()
{
    using geometry::SkeletonKind;
    std::vector<Skeleton> row{
        {.kind = SkeletonKind::point, .points = {Vec3::Zero()}},
        {.kind = SkeletonKind::segment, .points = {{0, 0, -0.1}, {0, 0, 0.1}}},
        {.kind = SkeletonKind::polyline, .points = {{0, 0, -0.1}, {0.02, 0, 0}, {0, 0, 0.1}}},
        {.kind = SkeletonKind::curve, .points = {{0, 0, -0.1}, {0.02, 0, 0}, {0, 0, 0.1}}},
        {.kind = SkeletonKind::triangle, .points = {{0, 0, -0.1}, {0, 0, 0.1}, {0.05, 0, 0}}}};
    row[1].stretch = Vec3(1, 1.2, 1).asDiagonal();
    row[4].stretch << 1.1, 0.1, 0, 0.1, 1.1, 0, 0, 0, 1;
    for (const SkeletonKind kind :
         {SkeletonKind::box, SkeletonKind::ellipsoid, SkeletonKind::torus, SkeletonKind::cylinder,
          SkeletonKind::cone, SkeletonKind::mesh, SkeletonKind::sheet}) {
        row.push_back({.kind = kind, .points = {}, .half_size = {0.1, 0.04, 0.06}});
        if (kind != SkeletonKind::mesh && kind != SkeletonKind::sheet) continue;
        row.back().mesh =
            std::make_shared<const geometry::SkeletonMesh>(geometry::icosphere(0.08, 1));
    }
    for (std::size_t s = 0; s < row.size(); ++s) {
        const Vec3 to(0.2 * static_cast<double>(s), 0, 0);
        for (Vec3& p : row[s].points) p += to;
        row[s].place.translate(to).rotate(Eigen::AngleAxisd(0.3, Vec3::UnitZ()));
    }
    ImplicitLayer layer = soft_layer(row);
    layer.blend.rule = geometry::BlendRule::smooth_groups;
    LayeredBody chain = make_layered_body(layer, BaseKind::rigid, 1000, 0.08);
    LayeredBody above = ball({0.1, 0.16, 0});
    for (LayeredBody* body : {&chain, &above}) {
        body->matter.bulge_width = 0.04;
        body->matter.bulge_height = 0.5;
        body->control.proportional = 10;
    }
    LayeredScene scene = scene_of({chain, above, floor_at(-0.08)});
    scene.parts[0].colour = {0.1f, 0.2f, 0.3f};
    for (int i = 0; i < 2; ++i) scene = advance(scene, scene.parts, {}, 1.0 / 24, 1);
    return scene;
}

}  // namespace

// Surfaces of what is read are those of what was written, bit for bit, and no samples are asked.
TEST(SceneRecord, GivesTheSameSurfacesBitForBit)
{
    const LayeredScene scene = every_kind();
    const SceneRecord record = physics::record(scene, "walk");
    ASSERT_EQ(record.bodies.size(), 3u);
    EXPECT_TRUE(record.bodies.begin()->first.starts_with("walk.bodies/"));
    const LayeredScene back = read_back(record);
    ASSERT_GT(back.presses.value().size(), 1u) << "the ball presses the chain, and the chain the "
                                                  "floor";
    EXPECT_EQ(back.parts[0].colour, scene.parts[0].colour);
    const geometry::TriMesh want = layered_mesh(scene, {.cell = 0.06});
    const geometry::TriMesh found = layered_mesh(back, {.cell = 0.06});
    ASSERT_GT(want.positions.size(), 500u);
    EXPECT_EQ(found.positions, want.positions);
    EXPECT_EQ(found.normals, want.normals);
    EXPECT_EQ(found.topology->triangles, want.topology->triangles);
    EXPECT_EQ(found.attributes[0].values, want.attributes[0].values);
    // What is read can be written: the same files.
    EXPECT_EQ(physics::record(back, "walk").frame, record.frame);
    EXPECT_EQ(physics::record(back, "walk").bodies, record.bodies);
    // Three bodies' frames, 13 skeletons, two contacts and three hashes: see the header.
    EXPECT_LT(record.frame.size(), 1000u);
}

// Samples made anew walk to the same surface: as many vertices, within the tolerance of a walk.
TEST(SceneRecord, IsPreviewedBySamplesMadeAnew)
{
    const LayeredScene scene = scene_of({ball({-0.08, 0, 0}), ball({0.08, 0, 0})});
    const LayeredMeshOptions preview{.surface = LayeredMeshOptions::Surface::samples};
    const geometry::TriMesh want = layered_mesh(scene, preview);
    const geometry::TriMesh found =
        layered_mesh(read_back(physics::record(scene, "scene")), preview);
    ASSERT_EQ(found.positions.size(), want.positions.size());
    for (std::size_t v = 0; v < want.positions.size(); ++v) {
        EXPECT_LT((found.positions[v] - want.positions[v]).norm(), 1e-6f);
    }
}

// A mesh that changes has a body of its own in each frame; the rest keeps its file.
TEST(SceneRecord, OnlyWhatChangesIsWrittenAgain)
{
    LayeredScene scene = scene_of({ball({0, 0, 0}), floor_at(-0.3)});
    const SceneRecord before = physics::record(scene, "scene");
    scene.states[0].position[0] += Vec3(0.1, 0, 0);
    EXPECT_EQ(physics::record(scene, "scene").bodies, before.bodies);
    LayeredBody other = *scene.parts[1].body;
    other.layer.contributions[0].thickness *= 1.5;
    scene.parts[1].body = std::make_shared<const LayeredBody>(other);
    const SceneRecord after = physics::record(scene, "scene");
    std::size_t kept = 0;
    for (const auto& [name, bytes] : after.bodies) kept += before.bodies.contains(name) ? 1 : 0;
    EXPECT_EQ(kept, 1u);
    EXPECT_EQ(after.bodies.size(), 2u);
}

// Every length and every changed byte of either file is told.
TEST(SceneRecord, DamageIsTold)
{
    const SceneRecord good = physics::record(scene_of({ball({0, 0, 0})}), "scene");
    const std::string body = good.bodies.begin()->second;
    const auto refused = [](const std::string& frame, const std::string& one) {
        try {
            static_cast<void>(bodies_of_record(frame));
            static_cast<void>(read_record(frame, std::span(&one, 1)));
        } catch (const std::runtime_error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_EQ(refused(good.frame, body), "");
    for (const bool of_body : {false, true}) {
        const std::string& whole = of_body ? body : good.frame;
        for (std::size_t n = 0; n < whole.size(); ++n) {
            std::string broken = whole.substr(0, n);
            EXPECT_NE(of_body ? refused(good.frame, broken) : refused(broken, body), "") << n;
            broken = whole;
            broken[n] = static_cast<char>(broken[n] ^ 4);
            EXPECT_NE(of_body ? refused(good.frame, broken) : refused(broken, body), "") << n;
        }
    }
    EXPECT_NE(refused("solid cube\n", body).find("begins with \"aspic-scene 1\", found \"solid"),
              std::string::npos);
    EXPECT_NE(refused(body, body).find("found \"aspic-body 1"), std::string::npos);
    std::string newer = good.frame;
    newer[newer.find('1')] = '7';
    EXPECT_NE(refused(newer, body).find("expected version 1 of aspic-scene, found version 7"),
              std::string::npos);
    EXPECT_NE(refused(good.frame.substr(0, 90), body).find("truncated"), std::string::npos);
}

// Files whose hashes are right, but not what they say: refused, or a scene that can be meshed.
static void expect_refused_or_harmless(const SceneRecord& good)
{
    std::vector<std::string> bodies;
    for (const std::string& name : bodies_of_record(good.frame)) {
        bodies.push_back(good.bodies.at(name));
    }
    const geometry::Random random(5);
    int refused = 0, read = 0;
    for (std::uint64_t i = 0; i < 1500; ++i) {
        std::string frame(geometry::unseal("aspic-scene", 1, good.frame));
        std::vector<std::string> now = bodies;
        const std::size_t f = i % 3;
        std::string body(geometry::unseal("aspic-body", 1, bodies[f % 2]));
        std::string& changed = f == 2 ? frame : body;
        for (std::uint64_t k = 0; k <= i % 4; ++k) {
            const auto at = static_cast<std::size_t>(random.unit(8 * i + 2 * k) *
                                                     static_cast<double>(changed.size()));
            changed[at] = static_cast<char>(static_cast<int>(256 * random.unit(8 * i + 2 * k + 1)));
        }
        if (i % 2 == 1) {  // a number that few expect
            constexpr double inf = std::numeric_limits<double>::infinity();
            constexpr double odd[] = {1e17, 1e231, -1e308, inf, -inf, -1, 0};
            const auto at = static_cast<std::size_t>(random.unit(20'000 + i) *
                                                     static_cast<double>(changed.size() - 8));
            std::memcpy(changed.data() + at, &odd[i / 2 % 7], sizeof(double));
        }
        if (f < 2) {  // and the frame names it
            const geometry::ContentHash hash = geometry::hash_of(body);
            std::memcpy(frame.data() + 4 + 8 + 4 + 16 * f, hash.data(), sizeof hash);
            now[f] = geometry::seal("aspic-body", 1, body);
        }
        try {
            const LayeredScene scene = read_record(geometry::seal("aspic-scene", 1, frame), now);
            ++read;
            static_cast<void>(LayeredMoment(scene));
        } catch (const std::runtime_error&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 200);
    EXPECT_GT(read, 200);
}

TEST(SceneRecord, LiesAreRefusedOrHarmless)
{
    expect_refused_or_harmless(
        physics::record(scene_of({ball({-0.08, 0, 0}), floor_at(-0.1)}), "a"));
    const std::vector<Skeleton> net{
        {.kind = SkeletonKind::segment, .points = {{0, 0, 0}, {0.3, 0, 0}}},
        {.kind = SkeletonKind::triangle, .points = {{0.3, 0, 0}, {0.5, 0, 0}, {0.4, 0, 0.2}}}};
    expect_refused_or_harmless(physics::record(
        scene_of({make_net_body(soft_layer(net), 1000, 0.05), floor_at(-0.2)}), "a"));
}

}  // namespace physics
