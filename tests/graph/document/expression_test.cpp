#include "graph/document/expression.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <thread>

namespace {

using graph::Expression;
using graph::Grammar;

double at(const std::string& text, int frame = 1, double time = 0)
{
    return Grammar().compile(text).value(frame, time);
}

TEST(Expression, HasTheFunctionsOfTheDocumentation)
{
    EXPECT_EQ(at("1 + 2 * 3 - 4 / 2"), 5);
    EXPECT_EQ(at("2 ^ 3 ^ 2"), 512);  // from the right
    EXPECT_EQ(at("-2 ^ 2"), -4);
    EXPECT_EQ(at("3 > 2 && 1 < 0 ? 10 : 20"), 20);
    EXPECT_EQ(at("sin(pi / 6)"), std::sin(std::numbers::pi / 6));
    EXPECT_EQ(at("atan2(1, -1)"), std::atan2(1.0, -1.0));
    EXPECT_EQ(at("log(exp(2))"), 2);
    EXPECT_EQ(at("sqrt(2) * cbrt(27)"), std::sqrt(2.0) * 3);
    EXPECT_EQ(at("min(3, 1, 2) + max(3, 1, 2)"), 4);
    EXPECT_EQ(at("mod(-1, 3)"), 2);  // the sign of the second
    EXPECT_EQ(at("fract(-0.25)"), 0.75);
    EXPECT_EQ(at("sign(-3) + sign(0)"), -1);
    EXPECT_EQ(at("clamp(5, 0, 1) + clamp(-5, 0, 1)"), 1);
    EXPECT_EQ(at("mix(10, 20, 0.25)"), 12.5);
    EXPECT_EQ(at("smoothstep(0, 2, 1)"), 0.5);
    EXPECT_EQ(at("smoothstep(1, 1, 2)"), 1);  // a step, not NaN
    EXPECT_EQ(at("step(1, 0.9) + step(1, 1)"), 1);
    EXPECT_EQ(at("floor(-0.5) + ceil(0.5) + round(2.5)"), 3);
    EXPECT_NEAR(at("degrees(radians(30)) + hypot(3, 4) + pow(2, 10)"), 30 + 5 + 1024, 1e-12);
}

TEST(Expression, SeesFrameAndTime)
{
    const Expression e = Grammar().compile("frame * 100 + time");
    EXPECT_FALSE(e.constant);
    EXPECT_EQ(e.value(7, 0.25), 700.25);
}

TEST(Expression, TakesEveryNumberButZeroAsTrue)
{
    Grammar grammar;
    grammar.define("half", 0.5);
    const std::vector<double> row{0.25};
    for (const char* const half : {"0.5", "half", "(half + 0 * time)", "time"}) {
        const auto value = [&](const std::string& text) {
            return grammar.compile(half + text).value(1, 0.5);
        };
        EXPECT_EQ(value(" && 1"), 1) << half;
        EXPECT_EQ(value(" && 0"), 0) << half;
        EXPECT_EQ(value(" || 0"), 1) << half;
        EXPECT_EQ(value(" && 0.25 ? 3 : 4"), 3) << half;
    }
    EXPECT_EQ(at("0 || 0"), 0);
    EXPECT_EQ(at("-0.5 || 0"), 1);
    EXPECT_EQ(grammar.compile_of("0.5 && 1 ? x : 2", {"x"})(row), 0.25);
    EXPECT_EQ(grammar.compile_of("x && 0.5", {"x"})(row), 1);
}

TEST(Expression, WithoutThemIsAConstant)
{
    Grammar grammar;
    grammar.define("scale", 0.5);
    const Expression e = grammar.compile("scale * 4");
    ASSERT_TRUE(e.constant);
    EXPECT_EQ(*e.constant, 2);
    EXPECT_EQ(e.value(99, 4.0), 2);
}

TEST(Expression, RefusesWhatIsNoFormula)
{
    const Grammar grammar;
    const std::string all[] = {"",
                               " ",
                               "1 +",
                               "(1",
                               "1)",
                               "1 2",
                               "sin",
                               "sin()",
                               "sin(1, 2)",
                               "frame = 3",
                               "frame == 3 = 4",
                               "1, 2",
                               "nobody",
                               "nobody(1)",
                               "\"text\"",
                               "1 ? 2",
                               "?:",
                               "min()",
                               "rnd()",
                               "_pi",
                               "a.b",
                               "#",
                               std::string(5000, '('),
                               std::string("1\0+1", 4)};
    for (const std::string& text : all) {
        EXPECT_THROW(static_cast<void>(grammar.compile(text)), graph::ExpressionError) << text;
    }
}

TEST(Expression, NamesThePlaceAndTheNearestName)
{
    Grammar grammar;
    grammar.define("scale", 1);
    try {
        static_cast<void>(grammar.compile("1 + sacle"));
        FAIL();
    } catch (const graph::ExpressionError& e) {
        EXPECT_EQ(e.position, 4u);
        EXPECT_STREQ(e.what(), "unknown name 'sacle'");
        EXPECT_EQ(e.suggestion, "did you mean 'scale'?");
    }
}

TEST(Expression, NamesAFunctionThatThereIsNot)
{
    const Grammar grammar;
    const auto told = [&](const std::string& text) {
        try {
            static_cast<void>(grammar.compile(text));
        } catch (const graph::ExpressionError& e) {
            return std::string(e.what()) + "; " + e.suggestion + " at " +
                   std::to_string(e.position);
        }
        return std::string();
    };
    const std::string foo = told("2.5*foo (frame)");
    EXPECT_EQ(foo.find("there is no function 'foo'; the functions are 'sin', 'cos', "), 0u) << foo;
    EXPECT_NE(foo.find("'min' and 'max' at 4"), std::string::npos) << foo;
    EXPECT_EQ(told("1 + squrt(4)"), "there is no function 'squrt'; did you mean 'sqrt'? at 4");
    EXPECT_EQ(told("sin(frame(2))"),
              "there is no function 'frame'; the functions are" +
                  foo.substr(foo.find(" 'sin'"), foo.find(" at ") - foo.find(" 'sin'")) + " at 4");
}

TEST(Expression, GivesNaNAndInfinityWhereMathematicsDoes)
{
    EXPECT_TRUE(std::isinf(at("1 / (frame - 1)")));
    EXPECT_TRUE(std::isnan(at("sqrt(-frame)")));
}

TEST(Expression, IsSafeFromSeveralThreads)
{
    const Expression e = Grammar().compile("frame * 1000 + time * 2");
    std::vector<std::thread> threads;
    std::vector<int> wrong(4, 0);
    for (int t = 0; t < 4; ++t) {
        threads.emplace_back([&, t] {
            for (int i = 0; i < 2000; ++i) {
                if (e.value(t, i) != t * 1000 + i * 2) ++wrong[static_cast<std::size_t>(t)];
            }
        });
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

TEST(Noise, IsZeroAtWholeNumbersContinuousAndWithinOne)
{
    double largest = 0;
    for (int i = -5000; i <= 5000; ++i) {
        const double x = i / 10.0, y = graph::noise(x);
        if (i % 10 == 0) {
            EXPECT_EQ(y, 0);
        }
        largest = std::max(largest, std::fabs(y));
        // |slope| < 2 * (1 + 15/8) from the product rule; 1e-6 apart the change is below 6e-6.
        EXPECT_NEAR(graph::noise(x + 1e-6), y, 6e-6);
    }
    EXPECT_LE(largest, 1);
    EXPECT_GT(largest, 0.5);  // it is no dull noise: a thousand bumps hold a high one
    EXPECT_EQ(graph::noise(NAN), 0);
    EXPECT_EQ(graph::noise(INFINITY), 0);
}

TEST(Variable, NamesAreIdentifiersThatNothingElseHas)
{
    for (const char* name : {"a", "_a", "wind_speed", "A1"}) EXPECT_TRUE(Grammar::free_name(name));
    for (const char* name : {"", "1a", "a-b", "a.b", "sin", "frame", "time", "fps", "pi", "ä"}) {
        EXPECT_FALSE(Grammar::free_name(name)) << name;
    }
}

}  // namespace
