#include "geometry/io/read_points.hpp"

#include "geometry/io/read_positions.hpp"
#include "tests/geometry/files.hpp"

#include <gtest/gtest.h>

namespace {

using namespace geometry;

std::vector<std::string> names_of(const ImportedMesh& mesh)
{
    std::vector<std::string> out;
    for (const ImportedAttribute& a : mesh.attributes) out.push_back(a.name);
    return out;
}

using Names = std::vector<std::string>;

TEST(ReadPoints, NamesAreApartByCommasOrElseBySpaces)
{
    const std::string line = "0 0 0 1.5 2.5\n";
    const auto names = [&](const std::string& header) {
        return names_of(read_points(header + "\n" + line).meshes.at(0));
    };
    EXPECT_EQ(names("x,y,z,heat flux,age"), (Names{"heat flux", "age"}));
    EXPECT_EQ(names("x; y; z; heat flux; age;\r"), (Names{"heat flux", "age"}));
    EXPECT_EQ(names("x y\tz heat age"), (Names{"heat", "age"}));
    EXPECT_EQ(names(R"("x","y","z","heat, mean",'age')"), (Names{"heat, mean", "age"}));
    EXPECT_EQ(names(R"(x y z "heat flux" age)"), (Names{"heat flux", "age"}));
    EXPECT_EQ(names("x,y,z,,age"), (Names{"column4", "age"}));
    EXPECT_EQ(names("x,y,z,heat"), (Names{"column4", "column5"}));  // a name too few
}

TEST(ReadPoints, ColoursAreWhereNamesSaySo)
{
    const std::string bytes = "0 0 0 255 0 51\n1 0 0 1 2 3\n";
    const auto mesh = [&](const std::string& header, const std::string& lines) {
        return read_points(header + "\n" + lines).meshes.at(0);
    };
    EXPECT_EQ(mesh("# none", bytes).colours.size(), 2u);
    const ImportedMesh other = mesh("x y z a b c", bytes);
    EXPECT_TRUE(other.colours.empty());
    EXPECT_EQ(names_of(other), (Names{"a", "b", "c"}));
    EXPECT_EQ(other.attributes[2].values, (std::vector<float>{51, 3}));

    const ImportedMesh last = mesh("X Y Z R G B", bytes);
    EXPECT_LT((last.colours.at(0) - Vec3f(1, 0, 0.2f)).norm(), 1e-6);
    EXPECT_EQ(names_of(last), Names{});

    const ImportedMesh first = mesh("x,y,z,Red,Green,Blue,age", "0,0,0,255,0,51,7\n");
    EXPECT_LT((first.colours.at(0) - Vec3f(1, 0, 0.2f)).norm(), 1e-6);
    EXPECT_EQ(names_of(first), Names{"age"});
    EXPECT_EQ(first.attributes[0].values, std::vector<float>{7});
}

TEST(ReadPoints, SixtyFourColumnsAreReadAndTheirNamesWhereThereAreMore)
{
    for (const std::size_t n : {20u, 64u, 70u}) {
        std::string header = "x,y,z", line = "0,0,0";
        for (std::size_t k = 3; k < n; ++k) {
            header += ",f" + std::to_string(k);
            line += "," + std::to_string(k);
        }
        const ImportedMesh mesh = read_points(header + "\n" + line + "\n").meshes.at(0);
        const std::size_t read = std::min<std::size_t>(n, 64);
        ASSERT_EQ(mesh.attributes.size(), read - 3) << n;
        EXPECT_EQ(mesh.attributes.back().name, "f" + std::to_string(read - 1));
        EXPECT_EQ(mesh.attributes.back().values, std::vector<float>{float(read - 1)});
    }
}

TEST(ReadPoints, NamedColoursOfZeroAndOneAreShares)
{
    const ImportedMesh mesh = read_points("x y z r g b\n0 0 0 1 0 0\n1 0 0 0 1 0\n").meshes.at(0);
    ASSERT_EQ(mesh.colours.size(), 2u);
    EXPECT_EQ(mesh.colours[0], Vec3f(1, 0, 0));
    EXPECT_EQ(mesh.colours[1], Vec3f(0, 1, 0));
}

TEST(ReadPoints, NumbersTooSmallForADoubleAreZero)
{
    const ImportedMesh mesh = read_points("1e-400 2 -1e-9999\n3 4 5\n").meshes.at(0);
    EXPECT_EQ(mesh.positions, (std::vector<Vec3f>{{0, 2, 0}, {3, 4, 5}}));
}

// As some programs begin a text in UTF-8.
TEST(ReadPoints, AByteOrderMarkHidesNoPoint)
{
    const std::vector<Vec3f> two{{1, 2, 3}, {4, 5, 6}};
    EXPECT_EQ(read_points("\xEF\xBB\xBF"
                          "1 2 3\n4 5 6\n")
                  .meshes.at(0)
                  .positions,
              two);
    const files::Folder folder;
    for (const auto& [name, text] :
         {std::pair{"a.xyz", "1 2 3\n4 5 6\n"},
          {"a.obj", "v 1 2 3\n v\t4 5 6 1\nf 1 2 2\n"},
          {"a.ply", "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                    "property float y\nproperty float z\nend_header\n1 2 3\n4 5 6\n"}}) {
        const auto path = folder.write(name, "\xEF\xBB\xBF" + std::string(text));
        EXPECT_EQ(read_positions(path, 1), two) << name;
    }
}

TEST(ReadPoints, ALineOfAnotherLengthIsNamed)
{
    const ImportedScene scene = read_points("x y z heat\n0 0 0 1\n\n1 0 0\n2 0 0 1 5\n");
    EXPECT_TRUE(scene.meshes.at(0).attributes.empty());
    EXPECT_EQ(scene.meshes[0].positions.size(), 3u);
    EXPECT_EQ(scene.warnings,
              Names{"line 4 has 3 numbers where those before have 4: what follows x, y and z is "
                    "left out. Give each line as many."});
    EXPECT_TRUE(read_points("0 0 0 1\n1 0 0 2\n").warnings.empty());
}

}  // namespace
