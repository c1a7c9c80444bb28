// Which skeletons of a soft substance blend.

#include "physics/layered_bodies/substance_parts.hpp"

#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>

namespace physics {
namespace {

using namespace layered_fixtures;

// Particles in a row, `apart` m from each other, each a part of its own, that nothing moves.
LayeredScene row(std::size_t count, double apart, const std::vector<geometry::BlendLink>& links,
                 double fusion_threshold)
{
    std::vector<Skeleton> points;
    for (std::size_t i = 0; i < count; ++i) {
        points.push_back(point({apart * static_cast<double>(i), 0, 0}));
    }
    ImplicitLayer layer = soft_layer(std::move(points), true);
    layer.blend.rule = geometry::BlendRule::smooth_groups;
    layer.blend.links = links;
    LayeredBody body = make_layered_body(layer, BaseKind::particles, 1000, 0.04);
    body.base.substance.stiffness = body.base.substance.friction = 0;
    body.base.substance.fusion_threshold = fusion_threshold;
    body.base.substance.fusion_time = 0.1;
    body.matter.stiffness = 1e3;
    body.matter.self_contact = true;
    LayeredPart part{.body = std::make_shared<const LayeredBody>(body)};
    for (std::uint32_t f = 0; f < count; ++f) part.held.push_back({f});
    return start({part});
}

LayeredScene frames_later(LayeredScene scene, int frames)
{
    for (int i = 0; i < frames; ++i) {
        scene = advance(scene, scene.parts, weightless, 1.0 / 24, 1);
    }
    return scene;
}

}  // namespace

// Partial and full ones, written either way round, and those that say that two collide.
TEST(SubstanceParts, LinksOfTheDesignKeepTheirWeight)
{
    const std::vector<geometry::BlendLink> drawn{{1, 0, 0.3}, {1, 2, 1}, {2, 3, 0}};
    const LayeredScene scene = frames_later(row(4, 0.17, drawn, 1e30), 24);
    const LayeredState& state = scene.states[0];
    ASSERT_EQ(state.links.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(state.links[i].weight, drawn[i].weight) << i;
    EXPECT_EQ(piece_count(scene), 4u);
}

// Two centimetres of layer a side press by 1e3 x 10 x 0.02 Pa, twice the threshold.
TEST(SubstanceParts, PressureMakesLinksOfTheDesignGrowToo)
{
    const std::vector<geometry::BlendLink> collides{{0, 1, 0}};
    for (const auto& links : {collides, {}}) {
        EXPECT_EQ(piece_count(frames_later(row(2, 0.16, links, 100), 1)), 2u);
        EXPECT_EQ(piece_count(frames_later(row(2, 0.16, links, 100), 12)), 1u);
    }
}

}  // namespace physics
