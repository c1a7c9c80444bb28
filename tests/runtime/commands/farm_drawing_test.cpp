#include "runtime/commands/farm_drawing.hpp"

#include <gtest/gtest.h>

#include <algorithm>

using namespace runtime;

namespace {

FarmTask task(const std::string& name, Stage stage, std::vector<int> frames, double seconds,
              std::vector<std::uint32_t> after = {})
{
    return {name,
            stage,
            0,
            stage == Stage::last ? std::vector<std::string>{} : std::vector{name},
            std::move(frames),
            std::move(after),
            seconds};
}

// A simulation of 10 s, `count` tasks of 5 s that follow it side by side, and the last of 1 s.
Cut fan(int count)
{
    Cut cut;
    cut.shots.push_back({"shot", "shot.json", {"a.b=<1>"}, {}, "/out", 40, 10, true});
    cut.tasks.push_back(task("shot.chain-sim", Stage::chain, {1, 2, 3, 4}, 10));
    std::vector<std::uint32_t> all;
    for (int i = 0; i < count; ++i) {
        FarmTask t = task("shot.frames-" + std::to_string(i + 1), Stage::frames, {i + 1}, 5, {0});
        t.nodes = {"files"};
        all.push_back(static_cast<std::uint32_t>(cut.tasks.size()));
        cut.tasks.push_back(std::move(t));
    }
    cut.tasks.push_back(task("shot.last", Stage::last, {1, 2, 3, 4}, 1, all));
    return cut;
}

std::size_t count_of(const std::string& text, const std::string& part)
{
    std::size_t count = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
        ++count;
    }
    return count;
}

// The number after `before`, behind the first place where `where` stands.
double number(const std::string& text, const std::string& where, const std::string& before)
{
    const std::size_t at = text.find(before, text.find(where));
    return at == std::string::npos ? -1 : std::stod(text.substr(at + before.size()));
}

}  // namespace

TEST(FarmDrawing, BoxesAreAsLongAsTheirTasksAndStandWhenTheyBegin)
{
    // 750 px are 16 s: 10 s of the simulation, 5 s of the frames, 1 s of the last task.
    const std::string svg = plan_svg(fan(3));
    const double second = 750 / 16.0, near = 0.06;  // px; they are written with one decimal
    const double x = number(svg, "<title>shot.chain-sim", "<rect x=\"");
    EXPECT_NEAR(number(svg, "<title>shot.chain-sim", "width=\""), 10 * second, near);
    EXPECT_NEAR(number(svg, "<title>shot.frames-2", "<rect x=\""), x + 10 * second, 2 * near);
    EXPECT_NEAR(number(svg, "<title>shot.frames-2", "width=\""), 5 * second, near);
    EXPECT_NEAR(number(svg, "<title>shot.last", "<rect x=\""), x + 15 * second, 2 * near);
}

TEST(FarmDrawing, TheLongestPathIsMarkedAndTheCacheIsTold)
{
    const std::string svg = plan_svg(fan(3));
    // The simulation, one of the three, the last: three boxes and the two lines between them.
    EXPECT_EQ(count_of(svg, "stroke=\"#c8201c\" stroke-width=\"2\""), 5u);
    EXPECT_EQ(count_of(svg, "<path "), 6u) << "three tasks wait, and are waited for";
    EXPECT_EQ(count_of(svg, "10 of 40 cached"), 1u);
    EXPECT_EQ(count_of(svg, "longest path: 16 s: shot.chain-sim, shot.frames-1, shot.last"), 1u);
    // 10 + 3 x 5 + 1 s on one machine.
    EXPECT_EQ(count_of(svg, ">26 s<"), 1u);
}

TEST(FarmDrawing, OfManyAlikeTasksAFewAreDrawnAndAStackStandsForTheOthers)
{
    const std::string svg = plan_svg(fan(10000));
    EXPECT_LT(svg.size(), 20000u);
    EXPECT_EQ(count_of(svg, ">9996 more, 9996 frames, up to 5.0 s each, 13 h 53 min in all<"), 1u);
    EXPECT_EQ(count_of(svg, "<title>"), 7u) << "the simulation, four, the stack, the last";
}

TEST(FarmDrawing, OfManyShotsTheFirstAndThoseOfTheLongestPathAreDrawn)
{
    Cut cut;
    for (std::uint32_t s = 0; s < 100; ++s) {
        const std::string name = "shot" + std::to_string(s);
        cut.shots.push_back({name, name + ".json", {}, {}, "/out", 1, 0, true});
        cut.tasks.push_back(task(name + ".last", Stage::last, {1}, s == 70 ? 9 : 3));
        cut.tasks.back().shot = s;
    }
    const std::string svg = plan_svg(cut);
    EXPECT_EQ(count_of(svg, "<title>shot"), 21u);
    EXPECT_EQ(count_of(svg, "<title>shot70.last"), 1u);
    EXPECT_EQ(count_of(svg, "and 79 more shots"), 1u);
}

TEST(FarmDrawing, IsWellFormedWhateverNamesHold)
{
    Cut cut = fan(2);
    cut.shots[0].name = "R&D \"<take>\"\x01";
    cut.tasks[0].name = "a<b";
    const std::string svg = plan_svg(cut);
    EXPECT_EQ(count_of(svg, "a.b=&lt;1&gt;"), 1u);
    EXPECT_EQ(count_of(svg, "R&amp;D &quot;&lt;take&gt;&quot;<"), 1u);
    EXPECT_EQ(count_of(svg, "a<b"), 0u);
    cut.shots[0].name = "cut\xff short\xef\xbf\xbe\xc3";
    EXPECT_EQ(count_of(plan_svg(cut), ">cut\xef\xbf\xbd short?\xef\xbf\xbd<"), 1u);
    EXPECT_EQ(count_of(svg, "<g>"), count_of(svg, "</g>"));
}

TEST(FarmDrawing, APlanWithNothingLeftIsDrawnToo)
{
    Cut cut;
    cut.shots.push_back({"shot", "shot.json", {}, {}, "/out", 4, 4, true});
    cut.tasks.push_back(task("shot.last", Stage::last, {1, 2}, 0));
    for (const std::string& svg : {plan_svg(cut), plan_svg(Cut{})}) {
        EXPECT_EQ(count_of(svg, "nan"), 0u) << svg;
        EXPECT_EQ(count_of(svg, "inf"), 0u) << svg;
        EXPECT_TRUE(svg.ends_with("</svg>\n"));
    }
}
