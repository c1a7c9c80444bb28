// Units in documents: which number is to be written instead.

#include "graph/document/units.hpp"
#include "tests/graph/toys.hpp"

#include <gtest/gtest.h>

namespace {

using graph::number_in;

TEST(Units, AreConvertedToThoseOfTheParameter)
{
    struct Case {
        const char *text, *unit;
        double is;
    };
    for (const Case& c : {
             Case{"2cm", "m", 0.02},
             {"2 cm", "m", 0.02},
             {"1000 kg/m3", "kg/m^3", 1000},
             {"1 g/cm^3", "kg/m^3", 1000},
             {"1.2 g/cm³", "kg/m^3", 1200},
             {"-9.81 m/s2", "m/s^2", -9.81},
             {"36 km/h", "m/s", 10},
             {"2 N/mm²", "Pa", 2e6},
             {"3 MPa", "Pa", 3e6},
             {"1.5 kg m/s^2", "N", 1.5},
             {"90°", "deg", 90},
             {"3 µm", "m", 3e-6},
             {"50 Hz", "1/s", 50},
             {"4 1/s", "1/s", 4},
             {"2 N·m", "N m", 2},
             {"7 N*s/m", "N s/m", 7},
             {"50%", "", 0.5},
         }) {
        const auto x = number_in(c.text, c.unit);
        ASSERT_TRUE(x) << c.text;
        EXPECT_NEAR(*x, c.is, 1e-12 * std::abs(c.is)) << c.text;
    }
}

TEST(Units, OfAnotherKindOrUnknownAreNot)
{
    for (const auto& [text, unit] :
         std::initializer_list<std::pair<const char*, const char*>>{{"2 kg", "m"},
                                                                    {"3 mPa", "Pa"},
                                                                    {"2 kg/m^2", "kg/m^3"},
                                                                    {"5", "m"},
                                                                    {"5 ", "m"},
                                                                    {"cm", "m"},
                                                                    {"5 /", "m"},
                                                                    {"5 m//s", "m/s"},
                                                                    {"5 m^9", "m"},
                                                                    {"5 kgm", "kg m"},
                                                                    {"1e400 m", "m"},
                                                                    {"50%", "m"},
                                                                    {"3 apples", ""},
                                                                    {"4 \xc2", "m"}}) {
        EXPECT_FALSE(number_in(text, unit)) << text;
    }
}

TEST(Units, InAVectorAreToldInItsPlace)
{
    const std::string told = toys::told(toys::load(R"({ "aspic": 1, "nodes": {
"m": { "type": "Mill@1", "params": { "place": [0, "2 cm", "3 kg"] } } } })"));
    EXPECT_EQ(told, "toy.json:2:51: error: node 'm', parameter 'place': expected three numbers "
                    "[x, y, z] in m, found \"2 cm\"; write 0.02, as this is in m\n"
                    "toy.json:2:59: error: node 'm', parameter 'place': expected three numbers "
                    "[x, y, z] in m, found \"3 kg\"\n");
}

}  // namespace
