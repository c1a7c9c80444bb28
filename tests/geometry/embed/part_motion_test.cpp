#include "geometry/embed/part_motion.hpp"

#include "geometry/base/random.hpp"
#include "geometry/cubes/plane.hpp"
#include "tests/geometry/embed/torn_blocks.hpp"

#include <gtest/gtest.h>

using namespace geometry;
using namespace torn_blocks;

namespace {

// How each octant of each cube moves.
struct Octants {
    const Cubes& cubes;
    std::vector<std::array<CubePolynomial, 8>> motion;

    Octants(const Cubes& of, const std::vector<Vec3>& x, const std::vector<std::uint32_t>& broken)
        : cubes(of), motion(of.count())
    {
        const auto parted = find_parted(cubes, broken);
        const auto torn = marked(cubes, parted);
        const PartMotion parts = motion_of_parts(cubes, x, broken, parted, torn);
        const int flat = flat_axis(cubes);
        const auto normals = flat < 0 ? std::vector<Vec3>{} : plane_normals(cubes, x, torn);
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            std::array<Vec3, 8> u;
            for (unsigned a = 0; a < 8; ++a) {
                const std::uint32_t k = cubes.corners[c][a];
                u[a] = x[k] - cubes.corner_position(k);
                if (flat >= 0 && (a >> flat & 1u)) {
                    u[a] += cubes.size * (normals[k] - Vec3::Unit(flat));
                }
            }
            motion[c].fill(polynomial_of(u));
        }
        for (std::size_t p = 0; p < parted.size(); ++p) {
            for (std::size_t a = 0; a < 8; ++a) {
                motion[parted[p].cube][a] = parts.polynomials[parts.first[p] + parted[p].part[a]];
            }
        }
    }
};

// How far two cubes side by side, the second next to the first along d, are from moving alike on
// their common face, by the octants of each corner that they share.
float most_apart(const Octants& octants, std::size_t one, std::size_t two, unsigned d)
{
    float most = 0;
    for (unsigned a = 0; a < 8; ++a) {
        if (!(a >> d & 1u)) continue;
        for (const float s : {0.0f, 0.3f, 1.0f}) {
            for (const float t : {0.0f, 0.6f, 1.0f}) {
                Vec3f p(s, s, s);
                p[(d + 1) % 3] = t;
                p[d] = 1;
                const Vec3f first = affine_at(octants.motion[one][a], p, Vec3f::Zero());
                p[d] = 0;
                const auto b = a ^ 1u << d;
                const Vec3f second = affine_at(octants.motion[two][b], p, Vec3f::Zero());
                most = std::max(most, (first - second).norm());
            }
        }
    }
    return most;
}

void expect_no_gaps(const Cubes& cubes, std::uint64_t seed, double share)
{
    const Random random(seed);
    std::uint64_t count = 0;
    const auto broken = links_between(
        cubes, [&](const Vec3i&, const Vec3i&) { return random.unit(count++) < share; });
    ASSERT_FALSE(find_parted(cubes, broken).empty());
    std::vector<Vec3> x = corner_positions(cubes);
    for (Vec3& p : x) {
        for (int d = 0; d < 3; ++d) p[d] += 0.3 * cubes.size * (random.unit(count++) - 0.5);
    }
    const Octants octants(cubes, x, broken);
    for (std::size_t one = 0; one < cubes.count(); ++one) {
        for (std::size_t two = 0; two < cubes.count(); ++two) {
            const Vec3i apart = cubes.cell[two] - cubes.cell[one];
            for (unsigned d = 0; d < 3; ++d) {
                if (apart != Vec3i::Unit(int(d))) continue;
                ASSERT_LT(most_apart(octants, one, two, d), 1e-6 * cubes.size)
                    << seed << ' ' << share << ": " << one << ' ' << two;
            }
        }
    }
}

// Whatever links are gone: nothing opens between cubes but where links are broken. Displacements
// are some 0.1, in single precision.
TEST(PartMotion, IsContinuousAcrossTheFacesOfCubes)
{
    const Cubes solid = block({3, 2, 3}, 0.5, Vec3(-0.5, 0, 1));
    const Cubes plane = plane_cubes(rectangle_cells(4, 3), {1, 0.5, Vec3::Zero()}, 0.01);
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        for (const double share : {0.2, 0.5, 0.8}) {
            expect_no_gaps(solid, seed, share);
            expect_no_gaps(plane, seed, share);
        }
    }
}

// The corner of a block hangs on its three links inwards no more: its octant in the outermost cube
// is a part of its own, whose corners on no face of another cube are virtual.
TEST(PartMotion, ExtrapolatesWhatNoNeighbourHas)
{
    const Cubes cubes = block({1, 1, 1}, 1, Vec3::Zero());
    const auto broken = links_between(cubes, [](const Vec3i& a, const Vec3i& b) {
        return a == Vec3i::Zero() || b == Vec3i::Zero();
    });
    std::vector<Vec3> x = corner_positions(cubes);
    for (std::size_t k = 0; k < x.size(); ++k) {
        if (cubes.corner[k].isZero()) x[k] += Vec3(-1, -2, -3);
    }
    const Octants octants(cubes, x, broken);
    const Vec3f p(0.25f, 0.5f, 0.75f);
    const Vec3f loose = affine_at(octants.motion[0][0], p, Vec3f::Zero());
    EXPECT_NEAR((loose - Vec3f(-1, -2, -3)).norm(), 0, 1e-6);
    const Vec3f rest = affine_at(octants.motion[0][7], p, Vec3f::Zero());
    EXPECT_NEAR(rest.norm(), 0, 1e-6);
}

}  // namespace
