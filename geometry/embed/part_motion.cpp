#include "geometry/embed/part_motion.hpp"

#include "geometry/cubes/plane.hpp"
#include "geometry/embed/corner_frames.hpp"
#include "geometry/embed/part_corners.hpp"

#include <algorithm>
#include <bit>

namespace geometry {
namespace {

// Which corner each corner's links lead to, 3 a corner.
std::vector<std::uint32_t> links_of(const Cubes& cubes)
{
    std::vector<std::uint32_t> after(3 * cubes.corner_count(), no_index);
    for (const auto& corners : cubes.corners) {
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t d = 0; d < 3; ++d) {
                const std::uint32_t i = corners[a], j = corners[a | std::size_t{1} << d];
                if (i != j) after[3 * i + d] = j;  // not the upper end, nor across a plane
            }
        }
    }
    return after;
}

// Normals of a plane's corners by the cells that are whole, and by their links where none is. Empty
// for cubes with thickness.
std::vector<Vec3> torn_plane_normals(const Cubes& cubes, std::span<const Vec3> x,
                                     const CornerFrames& frames, int flat,
                                     std::span<const std::uint8_t> torn)
{
    if (flat < 0) return {};
    std::vector<Vec3> normals = plane_normals(cubes, x, torn);
    std::vector<std::uint8_t> has_whole(cubes.corner_count(), 0);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        for (const auto k : cubes.corners[c]) has_whole[k] |= torn[c] == 0;
    }
    for (std::uint32_t k = 0; k < normals.size(); ++k) {
        if (!has_whole[k]) normals[k] = frames.at(k, x).col(flat).normalized();
    }
    return normals;
}

// Where the corners of parts come to be.
class CornerPlaces {
public:
    CornerPlaces(const Cubes& cubes, std::span<const Vec3> x, std::span<const Vec3> normals,
                 const PartCorners& corners)
        : cubes_(cubes), x_(x), normals_(normals), own_(corners.own), virtual_(own_.size())
    {}

    // Notes where a part's corners say that its corner b, of this number, is: its own that are the
    // nearest to b. Those of all parts that share the corner count.
    void note(const CornerFrames& frames, const PartedCube& parted, std::size_t part, unsigned b,
              std::uint32_t number)
    {
        if (own_[number] != no_index) return;
        int nearest = 4;
        for (unsigned a = 0; a < 8; ++a) {
            if (parted.part[a] == part) nearest = std::min(nearest, std::popcount(a ^ b));
        }
        Virtual& corner = virtual_[number];
        if (nearest > corner.links) return;
        if (nearest < corner.links) corner = {nearest};
        for (unsigned a = 0; a < 8; ++a) {
            if (parted.part[a] != part || std::popcount(a ^ b) != nearest) continue;
            Vec3 step;
            for (unsigned d = 0; d < 3; ++d) {
                step[d] = double(b >> d & 1u) - double(a >> d & 1u);
            }
            const std::uint32_t k = cubes_.corners[parted.cube][a];
            corner.place += x_[k] + frames.at(k, x_) * step;
            if (!normals_.empty()) corner.normal += normals_[k];
            ++corner.count;
        }
    }

    Vec3 place(std::uint32_t number) const
    {
        const Virtual& corner = virtual_[number];
        return own_[number] != no_index ? x_[own_[number]] : Vec3(corner.place / corner.count);
    }
    Vec3 normal(std::uint32_t number) const  // of a plane
    {
        return own_[number] != no_index ? normals_[own_[number]]
                                        : virtual_[number].normal.normalized();
    }

private:
    // Sums over the nearest corners, so many links away.
    struct Virtual {
        int links = 4;
        Vec3 place = Vec3::Zero(), normal = Vec3::Zero();
        int count = 0;
    };

    const Cubes& cubes_;
    std::span<const Vec3> x_, normals_;
    const std::vector<std::uint32_t>& own_;
    std::vector<Virtual> virtual_;
};

// Calls visit(cube, part, number) for each part of each parted cube; `number` counts them all.
template <class Visit> void for_parts(std::span<const PartedCube> parted, const Visit& visit)
{
    std::size_t number = 0;
    for (const PartedCube& p : parted) {
        for (std::size_t part = 0; part < p.parts; ++part) visit(p, part, number++);
    }
}

// How a part of a cube moves with its corners, of these numbers.
CubePolynomial polynomial_of_part(const Cubes& cubes, std::uint32_t cube, int flat,
                                  const CornerPlaces& places,
                                  const std::array<std::uint32_t, 8>& numbers)
{
    std::array<Vec3, 8> u;
    for (unsigned b = 0; b < 8; ++b) {
        u[b] = places.place(numbers[b]) - cubes.corner_position(cubes.corners[cube][b]);
        if (flat >= 0 && (b >> flat & 1u)) {
            u[b] += cubes.size * (places.normal(numbers[b]) - Vec3::Unit(flat));
        }
    }
    return polynomial_of(u);
}

Vec3f anchor_of(const Binding& binding, std::uint32_t v)
{
    const Binding::Stray* const stray = find_stray(binding, v);
    return stray ? stray->anchor : binding.local[v];
}

void add(CarriedByParts& carried, const PartMotion& motion, std::uint32_t part, const Vec3f& rest,
         const Vec3f& anchor, const Vec3f& local, std::uint32_t to)
{
    carried.polynomial.push_back(motion.first[part / 8] + part % 8);
    carried.anchor.push_back(anchor);
    carried.local.push_back(local);
    carried.rest.push_back(rest);
    carried.to.push_back(to);
}

}  // namespace

PartMotion motion_of_parts(const Cubes& cubes, std::span<const Vec3> x,
                           std::span<const std::uint32_t> broken,
                           std::span<const PartedCube> parted, std::span<const std::uint8_t> torn)
{
    PartMotion motion{&cubes, parted, {}, {}};
    const CornerFrames frames(links_of(cubes), broken, cubes.size);
    const int flat = flat_axis(cubes);
    const std::vector<Vec3> normals = torn_plane_normals(cubes, x, frames, flat, torn);
    const PartCorners corners = corners_of_parts(cubes, parted);
    CornerPlaces places(cubes, x, normals, corners);
    for_parts(parted, [&](const PartedCube& p, std::size_t part, std::size_t number) {
        for (unsigned b = 0; b < 8; ++b) places.note(frames, p, part, b, corners.of[number][b]);
    });
    for_parts(parted, [&](const PartedCube& p, std::size_t part, std::size_t number) {
        if (part == 0) motion.first.push_back(std::uint32_t(number));
        motion.polynomials.push_back(
            polynomial_of_part(cubes, p.cube, flat, places, corners.of[number]));
    });
    return motion;
}

std::uint32_t part_of(const PartMotion& motion, const Binding& binding, std::uint32_t vertex)
{
    const std::uint32_t cube = binding.used[binding.cube[vertex]];
    const auto found =
        std::lower_bound(motion.parted.begin(), motion.parted.end(), cube,
                         [](const PartedCube& p, std::uint32_t c) { return p.cube < c; });
    if (found == motion.parted.end() || found->cube != cube) return no_index;
    const Vec3f at = anchor_of(binding, vertex);
    unsigned octant = 0;
    for (int d = 0; d < 3; ++d) octant |= unsigned(at[d] >= 0.5f) << d;
    return std::uint32_t(8 * (found - motion.parted.begin())) + found->part[octant];
}

void add_vertex(CarriedByParts& carried, const PartMotion& motion, std::uint32_t part,
                const Vec3f& rest, const Binding& binding, std::uint32_t v)
{
    add(carried, motion, part, rest, anchor_of(binding, v), binding.local[v], v);
}

void add_place(CarriedByParts& carried, const PartMotion& motion, std::uint32_t part,
               const Vec3f& rest, std::uint32_t to)
{
    const Cubes& cubes = *motion.cubes;
    const Vec3 cell = cubes.cell[motion.parted[part / 8].cube].cast<double>();
    const Vec3 at = (rest.cast<double>() - cubes.origin) / cubes.size - cell;
    const Vec3f local = at.cast<float>();
    add(carried, motion, part, rest, local.cwiseMax(0.0f).cwiseMin(1.0f), local, to);
}

void add_normal(CarriedByParts& carried, const Vec3f& rest, std::uint32_t to)
{
    carried.normal_of.push_back(std::uint32_t(carried.rest.size() - 1));
    carried.normal.push_back(rest);
    carried.normal_to.push_back(to);
}

void carry(const CarriedByParts& carried, const PartMotion& motion, std::vector<Vec3f>& positions,
           std::vector<Vec3f>& normals)
{
    for (std::size_t i = 0; i < carried.rest.size(); ++i) {
        const CubePolynomial& u = motion.polynomials[carried.polynomial[i]];
        positions[carried.to[i]] =
            carried.rest[i] + affine_at(u, carried.anchor[i], carried.local[i] - carried.anchor[i]);
    }
    std::vector<Vec3f> turned(carried.normal.size());
    turn_normals({motion.polynomials, carried.polynomial, carried.anchor}, carried.normal_of,
                 float(1 / motion.cubes->size), carried.normal, 0, turned.size(), turned);
    for (std::size_t i = 0; i < turned.size(); ++i) normals[carried.normal_to[i]] = turned[i];
}

}  // namespace geometry
