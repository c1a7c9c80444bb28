// Parts that are glued wherever their cubes touch.

#include "physics/bricks/bricks.hpp"
#include "physics/bricks/settle.hpp"
#include "physics/state/part_joint.hpp"
#include "physics/state/state_models.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace physics {
namespace {

using geometry::Cubes;
using geometry::Vec3i;
using SomeCubes = std::vector<std::shared_ptr<const Cubes>>;

std::shared_ptr<const Cubes> shared(Cubes cubes, const Vec3& origin = Vec3::Zero())
{
    cubes.origin = origin;
    return std::make_shared<const Cubes>(std::move(cubes));
}

// What is simulated: models, the glue between them and gravity.
struct GluedScene {
    SomeCubes cubes;
    std::vector<StateModel> models;
    Loads loads;
    BricksBody body;
    State state;

    explicit GluedScene(SomeCubes of, std::vector<std::uint8_t> rigid = {}, double reach = 0)
        : cubes(std::move(of)), models(number_models(cubes))
    {
        std::vector<BodyModel> all;
        for (const auto& some : cubes) all.push_back({some.get()});
        body = make_bricks(BodyModels(all), {.contact = {.on = true}, .rigid = std::move(rigid)});
        state = rest_state(body);
        for (std::size_t i = 1; i < cubes.size(); ++i) {
            const SomeCubes two = {cubes[i - 1], cubes[i]};
            const auto points = points_of_all(
                make_joint(two, {.kind = PartJointKind::glue, .reach = reach}), cubes, models);
            loads.joints.insert(loads.joints.end(), points.begin(), points.end());
        }
    }
    std::size_t first_corner(std::size_t model) const
    {
        return models.empty() ? 0 : models[model].corner;
    }
    // Corners of a model with x at most this.
    void pin_below(std::size_t model, double x)
    {
        for (std::uint32_t k = 0; k < cubes[model]->corner_count(); ++k) {
            const Vec3 at = cubes[model]->corner_position(k);
            if (at.x() > x + 1e-9) continue;
            loads.pins.corner.push_back(std::uint32_t(first_corner(model)) + k);
            loads.pins.target.push_back(at);
        }
    }
    // Mean fall of the last model's corners with the largest x, m.
    double sag()
    {
        loads.forces.assign(1, {});
        state = settle(body, std::move(state), loads, {});
        const Cubes& last = *cubes.back();
        double end = -1e9, sum = 0, count = 0;
        for (std::size_t k = 0; k < last.corner_count(); ++k) {
            end = std::max(end, last.corner_position(k).x());
        }
        for (std::size_t k = 0; k < last.corner_count(); ++k) {
            if (last.corner_position(k).x() < end - 1e-9) continue;
            const Vec3& x = state.x[first_corner(cubes.size() - 1) + k];
            sum += last.corner_position(k).y() - x.y(), ++count;
        }
        return sum / count;
    }
    double widest_gap() const { return fixtures::widest_gap(loads.joints, state); }  // m
};

constexpr fixtures::Stuff rubber{.density = 1000, .young = 1e6, .poisson = 0.3};

// A wall of 2 x 3 x 3 cubes with its face at x = 0, in whose middle bars end.
Cubes wall()
{
    return fixtures::box(2, 3, 3, 0.1, rubber);
}
const Vec3 wall_at{-0.2, -0.1, -0.1};

TEST(Glue, ABarOfEqualCubesBendsAsOneThatIsOfOnePieceWithItsWall)
{
    std::vector<Vec3i> cells;
    for (int x = -2; x < 6; ++x) {
        for (int y = -1; y < 2; ++y) {
            for (int z = -1; z < 2; ++z) {
                if (x < 0 || (y == 0 && z == 0)) cells.push_back({x, y, z});
            }
        }
    }
    GluedScene one({shared(fixtures::cubes_on(cells, 0.1, rubber))});
    one.pin_below(0, -0.2);
    const double right = one.sag();
    ASSERT_GT(right, 0.02);

    GluedScene glued({shared(wall(), wall_at), shared(fixtures::box(6, 1, 1, 0.1, rubber))});
    EXPECT_EQ(glued.loads.joints.size(), 4u);  // at the corners of the bar's end
    glued.pin_below(0, -0.2);
    EXPECT_NEAR(glued.sag(), right, 0.03 * right);
}

// What the bar of finer cubes is glued to holds still: it sags as one whose end is pinned.
TEST(Glue, ABarOfFinerCubesBendsAsACantilever)
{
    const auto bar = shared(fixtures::box(16, 4, 4, 0.025, rubber), {0, 0, 0});
    GluedScene pinned({bar});
    pinned.pin_below(0, 0);
    const double right = pinned.sag();
    for (const bool bar_first : {false, true}) {
        const auto block = shared(wall(), wall_at);
        GluedScene glued(bar_first ? SomeCubes{bar, block} : SomeCubes{block, bar});
        EXPECT_EQ(glued.loads.joints.size(), 25u);
        if (bar_first) continue;
        glued.pin_below(0, 0);
        EXPECT_NEAR(glued.sag(), right, 0.02 * right);
    }
}

TEST(Glue, HoldsAnElasticBarAtARigidBlockAndRigidBlocksAtEachOther)
{
    const auto block = shared(fixtures::box(2, 2, 2, 0.1), {-0.2, -0.05, -0.05});
    for (const bool rigid_bar : {false, true}) {
        GluedScene scene({block, shared(fixtures::box(4, 1, 1, 0.1, rubber))},
                         {1, std::uint8_t(rigid_bar)});
        for (std::size_t k = 0; k < scene.state.x.size(); ++k) {  // spun and thrown
            scene.state.v[k] = Vec3(0.5, 1, 0) + Vec3(0, 3, 4).cross(scene.state.x[k]);
        }
        const auto before = fixtures::brick_motion(scene.cubes, scene.state);
        for (int frame = 0; frame < 24; ++frame) {
            scene.state = advance(scene.body, std::move(scene.state), scene.loads, 1.0 / 24);
            ASSERT_TRUE(scene.state.report.warnings.empty()) << scene.state.report.warnings[0];
            EXPECT_LT(scene.widest_gap(), rigid_bar ? 5e-4 : 5e-3) << frame;
        }
        const auto after = fixtures::brick_motion(scene.cubes, scene.state);
        EXPECT_LT((after.linear - before.linear).norm(), 1e-3 * before.linear.norm()) << rigid_bar;
        EXPECT_LT((after.angular - before.angular).norm(), 2e-2 * before.angular.norm())
            << rigid_bar;
    }
}

TEST(Glue, JoinsAllPartsOfOneModelThatTouchAndCountsTheOthers)
{
    // Rows of two cubes along y at x = 0, 1 and 3, as parts with corners of their own.
    Cubes all;
    for (const int x : {0, 1, 3}) {
        const Cubes row = fixtures::cubes_on({{x, 0, 0}, {x, 1, 0}}, 0.1, rubber);
        const auto first = std::uint32_t(all.corner_count());
        if (x == 0) {
            all = row;
            continue;
        }
        for (auto eight : row.corners) {
            for (auto& k : eight) k += first;
            all.corners.push_back(eight);
        }
        all.corner.insert(all.corner.end(), row.corner.begin(), row.corner.end());
        all.cell.insert(all.cell.end(), row.cell.begin(), row.cell.end());
        all.young.insert(all.young.end(), row.young.begin(), row.young.end());
    }
    // By (z, y, x), as cubes are sorted.
    std::vector<std::size_t> order = {0, 2, 4, 1, 3, 5};
    Cubes sorted = all;
    for (std::size_t i = 0; i < order.size(); ++i) {
        sorted.cell[i] = all.cell[order[i]], sorted.corners[i] = all.corners[order[i]];
    }
    JointDoubts doubts;
    const PartJoint joint =
        make_joint(SomeCubes{shared(sorted)}, {.kind = PartJointKind::glue}, &doubts);
    EXPECT_EQ(joint.points.size(), 6u);  // the corners of the face between the first two
    EXPECT_EQ(doubts.parts, 3u);
    EXPECT_EQ(doubts.loose, 1u);
    make_joint(SomeCubes{shared(sorted)}, {.kind = PartJointKind::glue, .reach = 0.11}, &doubts);
    EXPECT_EQ(doubts.loose, 0u);
    for (const JointPoint& p : joint.points) {
        Vec3 gap = Vec3::Zero();
        double sum = 0;
        for (std::size_t i = 0; i < 16; ++i) {
            gap += p.weight[i] * sorted.corner_position(p.corner[i]), sum += p.weight[i];
        }
        EXPECT_NEAR(gap.norm(), 0, 1e-12);
        EXPECT_NEAR(sum, 0, 1e-12);
    }
}

TEST(Glue, OfPartsThatAreApartNamesTheReachThatTheyNeed)
{
    const auto told = [](double gap, double reach = 0) -> std::string {
        try {
            make_joint(SomeCubes{shared(wall(), wall_at),
                                 shared(fixtures::box(4, 1, 1, 0.1, rubber), {gap, 0, 0})},
                       {.kind = PartJointKind::glue, .reach = reach});
        } catch (const std::invalid_argument& e) {
            return e.what();
        }
        return "";
    };
    EXPECT_EQ(told(0.02), "");
    EXPECT_NE(told(0.09).find("set reach = 0.1,"), std::string::npos) << told(0.09);
    EXPECT_NE(told(9).find("move the parts together"), std::string::npos) << told(9);
    EXPECT_EQ(told(0.19, 0.2), "");
    EXPECT_NE(told(0.02, 1000).find("at most 0.2 m"), std::string::npos) << told(0.02, 1000);
}

}  // namespace
}  // namespace physics
