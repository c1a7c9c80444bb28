#include "geometry/cubes/pieces.hpp"

#include "geometry/base/random.hpp"
#include "geometry/cubes/components.hpp"
#include "geometry/cubes/cube_finder.hpp"
#include "geometry/cubes/voxelize.hpp"
#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <map>
#include <numeric>
#include <set>

namespace {

using geometry::Cubes;
using geometry::FaceMatter;
using geometry::HeldCells;
using geometry::Inside;
using geometry::NearPieces;
using geometry::SubCells;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3i;
using geometry::VoxelGrid;
using geometry::VoxelOptions;

const VoxelOptions apart{.pieces = NearPieces::apart};

TriMesh box_at(const Vec3& lo, const Vec3& hi)
{
    return meshes::moved(geometry::box(hi - lo, {1, 1, 1}), 0.5 * (lo + hi));
}

TriMesh merged_boxes(const std::vector<TriMesh>& meshes)
{
    std::vector<const TriMesh*> all;
    for (const TriMesh& mesh : meshes) all.push_back(&mesh);
    return geometry::merge(all);
}

VoxelGrid unit_grid()
{
    return {1, Vec3::Zero(), Vec3i::Zero()};
}

Cubes solid(const TriMesh& mesh, const VoxelGrid& grid, const VoxelOptions& options = apart)
{
    return voxelize_solid(mesh, {{}, {{}}, {}}, Inside::winding, 0, grid, options);
}

Cubes surface(const TriMesh& mesh, const VoxelGrid& grid, const VoxelOptions& options = apart,
              double thickness = 0.01)
{
    return voxelize_surface(mesh, {{}, {{}}, {}}, thickness, grid, options);
}

std::size_t components(const Cubes& cubes)
{
    return find_components(cubes, geometry::Connectivity::face).count();
}

void expect_same(const Cubes& a, const Cubes& b)
{
    EXPECT_EQ(a.cell, b.cell);
    EXPECT_EQ(a.corners, b.corners);
    EXPECT_EQ(a.corner, b.corner);
    EXPECT_EQ(a.mass, b.mass);
    EXPECT_EQ(a.fill, b.fill);
    EXPECT_EQ(a.young, b.young);
    EXPECT_EQ(a.matter, b.matter);
    EXPECT_EQ(a.part, b.part);
}

TEST(SubCells, StepsLandWhereTheirCoordinatesSay)
{
    for (const auto& forward : geometry::steps) {
        for (const auto& step : {forward, geometry::backwards(forward)}) {
            for (int bit = 0; bit < 64; ++bit) {
                const Vec3i to =
                    Vec3i(bit & 3, bit >> 2 & 3, bit >> 4) + Vec3i(step[0], step[1], step[2]);
                for (int n = 0; n < 27; ++n) {
                    const Vec3i over(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
                    const Vec3i in = to - 4 * over;
                    const bool there = in.minCoeff() >= 0 && in.maxCoeff() < 4;
                    const SubCells expected =
                        there ? SubCells{1} << geometry::sub_cell_bit(in.x(), in.y(), in.z()) : 0;
                    ASSERT_EQ(
                        geometry::landed(SubCells{1} << bit, step, {over.x(), over.y(), over.z()}),
                        expected);
                }
            }
        }
    }
}

// Cells that hold random quarters with random links.
HeldCells random_cells(std::uint64_t seed)
{
    const geometry::Random random(seed);
    std::uint64_t drawn = 0;
    const auto dense = [&] { return random.bits(drawn++); };
    const auto sparse = [&] {
        const SubCells some = dense();
        return some & dense();
    };
    HeldCells out;
    for (int i = 0; i < 27; ++i) {
        if (random.unit(1000 + static_cast<std::uint64_t>(i)) < 0.3) continue;
        out.cells.emplace_back(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
        const bool inside = random.unit(2000 + static_cast<std::uint64_t>(i)) < 0.15;
        out.held.push_back(inside ? geometry::all_sub_cells : sparse() | 1);
        out.links_of.push_back(inside ? geometry::no_index
                                      : static_cast<std::uint32_t>(out.links.size()));
        if (inside) continue;
        HeldCells::Links links{};
        for (SubCells& l : links) l = sparse() & dense();
        for (std::size_t d = 0; d < 3; ++d) links[d] = dense();
        out.links.push_back(links);
    }
    return out;
}

Vec3i corner_step(std::size_t corner)
{
    const auto a = static_cast<int>(corner);
    return {a & 1, a >> 1 & 1, a >> 2};
}

// Sets of numbers, joined by renaming all of one.
struct SlowSets {
    std::vector<std::size_t> name;
    explicit SlowSets(std::size_t n) : name(n) { std::iota(name.begin(), name.end(), 0u); }
    void join(std::size_t a, std::size_t b)
    {
        const std::size_t from = name[b], to = name[a];
        std::replace(name.begin(), name.end(), from, to);
    }
};

// The links of random cells, one by one, between quarters 64 cell + bit.
template <class Visit> void each_link(const HeldCells& cells, const Visit& visit)
{
    std::map<std::array<int, 3>, std::size_t> cell_at;
    for (std::size_t c = 0; c < cells.cells.size(); ++c) {
        const Vec3i& p = cells.cells[c];
        cell_at[{p.x(), p.y(), p.z()}] = c;
    }
    for (std::size_t c = 0; c < cells.cells.size(); ++c) {
        for (std::size_t bit = 0; bit < 64; ++bit) {
            if ((cells.held[c] >> bit & 1) == 0) continue;
            for (std::size_t d = 0; d < 13; ++d) {
                const std::uint32_t l = cells.links_of[c];
                if (l == geometry::no_index ? d >= 3 : (cells.links[l][d] >> bit & 1) == 0) {
                    continue;
                }
                const auto& step = geometry::steps[d];
                const auto b = static_cast<int>(bit);
                Vec3i to = 4 * cells.cells[c] + Vec3i(b & 3, b >> 2 & 3, b >> 4) +
                           Vec3i(step[0], step[1], step[2]);
                const Vec3i other = (to + Vec3i::Constant(400)) / 4 - Vec3i::Constant(100);
                const auto found = cell_at.find({other.x(), other.y(), other.z()});
                if (found == cell_at.end()) continue;
                to -= 4 * other;
                const unsigned end = geometry::sub_cell_bit(to.x(), to.y(), to.z());
                if ((cells.held[found->second] >> end & 1) == 0) continue;
                visit(64 * c + bit, 64 * found->second + end);
            }
        }
    }
}

TEST(Pieces, OfRandomQuartersAreThoseOfBruteForce)
{
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        const HeldCells cells = random_cells(seed);
        const Cubes cubes = geometry::cubes_of_pieces(cells, 1, Vec3::Zero());
        ASSERT_FALSE(cubes.part.empty());

        SlowSets pieces(64 * cells.cells.size());
        each_link(cells, [&](std::size_t a, std::size_t b) {
            if (a / 64 == b / 64) pieces.join(a, b);
        });
        std::map<std::pair<std::size_t, std::size_t>, SubCells> expected;  // cell, name
        for (std::size_t i = 0; i < pieces.name.size(); ++i) {
            if (cells.held[i / 64] >> (i % 64) & 1) {
                expected[{i / 64, pieces.name[i]}] |= SubCells{1} << i % 64;
            }
        }
        std::set<std::pair<std::array<int, 3>, SubCells>> wanted, found;
        for (const auto& [key, part] : expected) {
            const Vec3i& p = cells.cells[key.first];
            wanted.insert({{p.x(), p.y(), p.z()}, part});
        }
        std::vector<std::size_t> cube_of(64 * cells.cells.size());
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            const Vec3i& p = cubes.cell[c];
            found.insert({{p.x(), p.y(), p.z()}, cubes.part[c]});
            for (std::size_t i = 0; i < cube_of.size(); ++i) {
                if (cells.cells[i / 64] == p && (cubes.part[c] >> i % 64 & 1)) cube_of[i] = c;
            }
        }
        EXPECT_EQ(found, wanted);
        ASSERT_EQ(cubes.count(), wanted.size());

        // Corners are one where links between the cubes of neighbouring cells say so.
        SlowSets corners(8 * cubes.count());
        each_link(cells, [&](std::size_t i, std::size_t j) {
            const std::size_t a = cube_of[i], b = cube_of[j];
            if (a == b) return;
            for (std::size_t k = 0; k < 64; ++k) {
                const auto at = [&](std::size_t cube, std::size_t corner) {
                    return Vec3i(cubes.cell[cube] + corner_step(corner));
                };
                if (at(a, k / 8) == at(b, k % 8)) corners.join(8 * a + k / 8, 8 * b + k % 8);
            }
        });
        for (std::size_t i = 0; i < corners.name.size(); ++i) {
            for (std::size_t j = 0; j < i; ++j) {
                ASSERT_EQ(corners.name[i] == corners.name[j],
                          cubes.corners[i / 8][i % 8] == cubes.corners[j / 8][j % 8])
                    << seed << ": " << i << ", " << j;
            }
        }
    }
}

// A torus has cells that its rim cuts in two: material in two corners of one face.
TEST(Pieces, ConvexBodiesAndFlatSheetsHaveTheSameCubesAsMerged)
{
    const VoxelOptions merge;
    for (const auto& specimen : meshes::sound()) {
        if (specimen.name == "torus") continue;
        SCOPED_TRACE(specimen.name);
        for (const int resolution : {3, 8, 13, 20}) {
            const geometry::Box box = triangle_bounds(specimen.mesh);
            const VoxelGrid grid = fit_grid(box, size_for(box, resolution));
            if (specimen.closed) {
                expect_same(solid(specimen.mesh, grid), solid(specimen.mesh, grid, merge));
            } else {
                expect_same(surface(specimen.mesh, grid), surface(specimen.mesh, grid, merge));
            }
        }
    }
}

// Two blocks with a gap along x from x0 to x0 + gap, cubes of 1 m.
TriMesh two_blocks(double x0, double gap)
{
    return merged_boxes(
        {box_at({x0 - 1.5, 0, 0}, {x0, 2, 2}), box_at({x0 + gap, 0, 0}, {x0 + gap + 1.5, 2, 2})});
}

TEST(Pieces, BlocksHalfACubeApartAreTwoComponentsWhereverTheGapLies)
{
    for (const double x0 : {2.0, 2.1, 2.25, 2.5, 2.6, 2.75, 2.9}) {
        SCOPED_TRACE(x0);
        const TriMesh mesh = two_blocks(x0, 0.5);
        EXPECT_EQ(components(solid(mesh, unit_grid(), {})), 1u);
        for (const Cubes& cubes : {solid(mesh, unit_grid()), surface(mesh, unit_grid())}) {
            EXPECT_EQ(components(cubes), 2u);
            EXPECT_EQ(find_components(cubes, geometry::Connectivity::corner).count(), 2u);
        }
        // Each block as it would be alone.
        const TriMesh left = box_at({x0 - 1.5, 0, 0}, {x0, 2, 2});
        const TriMesh right = box_at({x0 + 0.5, 0, 0}, {x0 + 2, 2, 2});
        EXPECT_EQ(solid(mesh, unit_grid()).count(),
                  solid(left, unit_grid()).count() + solid(right, unit_grid()).count());
        EXPECT_EQ(surface(mesh, unit_grid()).count(),
                  surface(left, unit_grid()).count() + surface(right, unit_grid()).count());
        // The volume of two blocks of 1.5 x 2 x 2.
        VoxelOptions exact = apart;
        exact.min_fill = 0;
        EXPECT_NEAR(total_mass(solid(mesh, unit_grid(), exact)) / geometry::Matter{}.density, 12,
                    1e-5);
    }
}

TEST(Pieces, BlocksThatTouchAreOne)
{
    EXPECT_EQ(components(solid(two_blocks(2.25, 0), unit_grid())), 1u);
    EXPECT_EQ(components(solid(two_blocks(2.4, 0), unit_grid())), 1u);
    EXPECT_EQ(components(solid(two_blocks(2, 0), unit_grid())), 1u);
}

TEST(Pieces, AStatedGapJoinsThem)
{
    const auto parts = [](double x0, double gap, double join) {
        VoxelOptions options = apart;
        options.join = join;
        return components(solid(two_blocks(x0, gap), unit_grid(), options));
    };
    for (const double x0 : {2.0, 2.1, 2.25, 2.5, 2.6, 2.75, 2.9}) {
        EXPECT_EQ(parts(x0, 0.5, 0), 2u) << x0;
        EXPECT_EQ(parts(x0, 0.5, 0.5), 1u) << x0;
        EXPECT_EQ(parts(x0, 0.25, 0.25), 1u) << x0;
        EXPECT_EQ(parts(x0, 0.95, 0.4), 2u) << x0;
    }
    // With all that lies in a cell or next to it joined, the cubes are those of merge.
    VoxelOptions all = apart;
    all.join = 4;
    const TriMesh ring = geometry::torus(1, 0.3, 40, 16);
    const VoxelGrid grid = fit_grid(triangle_bounds(ring), 0.2);
    EXPECT_FALSE(solid(ring, grid).part.empty());
    expect_same(solid(ring, grid, all), solid(ring, grid, {}));
}

TEST(Pieces, AGapHalfACubeWideKeepsApartAtAnyAngle)
{
    for (int i = 0; i < 8; ++i) {
        TriMesh mesh = merged_boxes(
            {box_at({-3, -3, 0.25}, {3, 3, 1.5}), box_at({-3, -3, -1.5}, {3, 3, -0.25})});
        move(mesh, geometry::placement({0.1 * i, 0, 0.03 * i}, {17.0 * i, 45, 11.0 * i}, {1, 1, 1},
                                       {0, 0, 0}));
        EXPECT_EQ(components(solid(mesh, unit_grid())), 2u) << i;
        EXPECT_EQ(components(surface(mesh, unit_grid())), 2u) << i;
    }
}

TEST(Pieces, APlateThinnerThanAQuarterOnAPlaneBetweenQuartersIsOne)
{
    // Its faces lie in the quarters above and below z = 0.5, whose centres are outside.
    const TriMesh plate = box_at({0.1, 0.1, 0.42}, {7.9, 7.9, 0.58});
    const Cubes cubes = solid(plate, unit_grid());
    EXPECT_EQ(cubes.count(), 64u);
    expect_same(cubes, solid(plate, unit_grid(), {}));
}

TEST(Pieces, ASheetThroughTheEdgesOfCellsIsOne)
{
    TriMesh sheet = geometry::grid(6, 6, 1, 1);
    move(sheet, geometry::placement({3, 3, 3}, {0, 0, 45}, {1, 1, 1}, {0, 0, 0}));
    const Cubes cubes = surface(sheet, unit_grid());
    EXPECT_EQ(find_components(cubes, geometry::Connectivity::edge).count(), 1u);
    EXPECT_EQ(cubes.count(), surface(sheet, unit_grid(), {}).count());
}

TEST(Pieces, AreTheSameForAnyNumberOfThreads)
{
    std::vector<TriMesh> balls;
    for (int i = 0; i < 30; ++i) {
        const int row = i / 3 % 3, layer = i / 9;
        balls.push_back(
            meshes::moved(geometry::icosphere(1, 3), {2.3 * (i % 3), 2.2 * row, 2.25 * layer}));
    }
    const TriMesh mesh = merged_boxes(balls);
    const VoxelGrid grid = fit_grid(triangle_bounds(mesh), 0.5);
    const auto with = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return std::pair(solid(mesh, grid), surface(mesh, grid));
    };
    const auto one = with(1), four = with(4);
    EXPECT_EQ(components(one.first), 30u);
    expect_same(one.first, four.first);
    expect_same(one.second, four.second);
}

TEST(CubeFinder, GivesEachPlaceToTheNearestPiece)
{
    const Cubes cubes = solid(two_blocks(2, 0.5), unit_grid());
    const geometry::CubeFinder finder(cubes);
    const auto found = find_components(cubes, geometry::Connectivity::face);
    const auto block = [&](const Vec3& at) { return found.label[finder.find(at)]; };
    const std::uint32_t left = block({1, 1, 1}), right = block({3, 1, 1});
    EXPECT_NE(left, right);
    // The left block's face belongs to the cell of the right block, the left one's cube ends there.
    EXPECT_EQ(block({2, 1.3, 0.7}), left);
    EXPECT_EQ(block({2.0005, 1.3, 0.7}), left);
    EXPECT_EQ(block({2.5, 1.3, 0.7}), right);
    EXPECT_EQ(block({2.4, 1.3, 0.7}), right);
    EXPECT_EQ(finder.find({7, 7, 7}), geometry::no_index);
}

}  // namespace
