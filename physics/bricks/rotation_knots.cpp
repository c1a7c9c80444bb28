#include "physics/bricks/rotation_knots.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "geometry/base/union_find.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <tuple>

namespace physics {
namespace {

using geometry::no_index;
using Quaternion = Eigen::Vector4f;

// Half a turn and back goes by four cubes: two of them differ by a quarter of a turn at least,
// which is cos(45 degrees) between quaternions.
constexpr float least_in_knots = 0.7072f;

constexpr std::size_t cubes_a_run = 8192;

constexpr int reach = 2;   // faces from the sheet to the cubes that are held
constexpr int rounds = 8;  // of means

Quaternion quaternion_of(const std::vector<float>& rotation, std::size_t cube)
{
    return Eigen::Map<const Quaternion>(rotation.data() + 4 * cube);
}

// The rotation of a face of four pinned corners.
Eigen::Quaternionf turned_by(const geometry::Cubes& cubes, const Pins& pins,
                             const std::array<std::uint32_t, 4>& pin)
{
    using geometry::Mat3;
    using geometry::Vec3;
    Vec3 from = Vec3::Zero(), to = from;
    for (const auto p : pin) {
        from += cubes.corner_position(pins.corner[p]) / 4;
        to += pins.target[p] / 4;
    }
    Mat3 sum = Mat3::Zero();
    for (const auto p : pin) {
        sum += (pins.target[p] - to) * (cubes.corner_position(pins.corner[p]) - from).transpose();
    }
    const Eigen::JacobiSVD<Mat3> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const double way = (svd.matrixU() * svd.matrixV().transpose()).determinant();
    const Vec3 signs(1, 1, way < 0 ? -1 : 1);
    const Mat3 rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
    return Eigen::Quaternionf(Eigen::Quaterniond(rotation).cast<float>());
}

// A face of the surface that pins hold, and how they turn it: like a cube before it.
struct PinnedFace {
    std::uint32_t cube;
    std::size_t face;  // axis + 3 side, of the cube
    Quaternion turn;
};

// Whether a knot may lie between two cubes with such rotations.
bool far_apart(const Quaternion& a, const Quaternion& b)
{
    return std::abs(a.dot(b)) < least_in_knots;
}

// Which cubes have a neighbour towards -axis, bit axis, of those that are asked for.
std::vector<std::uint8_t> joined_below(const CubeNeighbours& neighbours,
                                       const std::vector<std::uint8_t>& asked)
{
    std::vector<std::uint8_t> out(neighbours.size(), 0);
    for (const auto& next : neighbours) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            if (next[axis] == no_index || asked[next[axis]] == 0) continue;
            out[next[axis]] = static_cast<std::uint8_t>(out[next[axis]] | 1u << axis);
        }
    }
    return out;
}

// 1: four corners or more are held.
std::vector<std::uint8_t> held_cubes(const geometry::Cubes& cubes,
                                     const std::vector<std::uint32_t>& pin_of)
{
    std::vector<std::uint8_t> out(cubes.count());
    geometry::parallel_for(cubes.count(), cubes_a_run, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            const auto held = std::count_if(cubes.corners[c].begin(), cubes.corners[c].end(),
                                            [&](auto k) { return pin_of[k] != no_index; });
            out[c] = held >= 4 ? 1 : 0;
        }
    });
    return out;
}

// Sorted by cube.
std::vector<PinnedFace> pinned_faces(const geometry::Cubes& cubes, const Pins& pins,
                                     const CubeNeighbours& neighbours,
                                     const std::vector<float>& rotation)
{
    std::vector<PinnedFace> out;
    if (pins.corner.empty()) return out;
    std::vector<std::uint32_t> pin_of(cubes.corner_count(), no_index);
    for (std::uint32_t p = 0; p < pins.corner.size(); ++p) {
        if (held_axes(pins, p) == all_axes) pin_of[pins.corner[p]] = p;
    }
    const std::vector<std::uint8_t> held = held_cubes(cubes, pin_of);
    if (std::find(held.begin(), held.end(), 1) == held.end()) return out;
    const std::vector<std::uint8_t> below = joined_below(neighbours, held);
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        if (held[c] == 0) continue;
        for (std::size_t face = 0; face < 6; ++face) {
            const std::size_t axis = face % 3, side = face / 3;
            if (side == 0 ? (below[c] >> axis & 1) != 0 : neighbours[c][axis] != no_index) continue;
            std::array<std::uint32_t, 4> pin{};
            std::size_t count = 0;
            for (std::size_t a = 0; a < 8; ++a) {
                if ((a >> axis & 1) == side) pin[count++] = pin_of[cubes.corners[c][a]];
            }
            if (std::find(pin.begin(), pin.end(), no_index) != pin.end()) continue;
            const Eigen::Quaternionf q = turned_by(cubes, pins, pin);
            // Of half a turn in this frame, the way round is not known.
            constexpr float least = 0.1f;
            const Quaternion turn(q.w(), q.x(), q.y(), q.z());
            if (std::abs(turn.dot(quaternion_of(rotation, c))) < least) continue;
            out.push_back({c, face, turn});
        }
    }
    return out;
}

// Calls f(face, next) for faces side by side: next is that of the neighbour along an axis.
template <class F>
void for_neighbour_faces(const std::vector<PinnedFace>& faces, const CubeNeighbours& neighbours,
                         const F& f)
{
    const auto before = [](const PinnedFace& a, const PinnedFace& b) {
        return std::tie(a.cube, a.face) < std::tie(b.cube, b.face);
    };
    for (const PinnedFace& face : faces) {
        for (std::size_t along = 0; along < 3; ++along) {
            const std::uint32_t next = neighbours[face.cube][along];
            if (face.face % 3 == along || next == no_index) continue;
            const PinnedFace wanted{next, face.face, {}};
            const auto at = std::lower_bound(faces.begin(), faces.end(), wanted, before);
            if (at == faces.end() || at->cube != next || at->face != face.face) continue;
            f(face, *at, along);
        }
    }
}

// Adds a cube before each of these faces.
void add_faces(const std::vector<PinnedFace>& faces, CubeNeighbours& neighbours,
               std::vector<float>& rotation)
{
    const auto first = static_cast<std::uint32_t>(neighbours.size());
    neighbours.resize(first + faces.size(), {no_index, no_index, no_index});
    const auto number = [&](const PinnedFace& face) {
        return first + static_cast<std::uint32_t>(&face - faces.data());
    };
    for_neighbour_faces(faces, neighbours,
                        [&](const PinnedFace& face, const PinnedFace& next, std::size_t along) {
                            neighbours[number(face)][along] = number(next);
                        });
    for (const PinnedFace& face : faces) {
        const std::size_t axis = face.face % 3;
        if (face.face / 3 == 0) neighbours[number(face)][axis] = face.cube;
        if (face.face / 3 == 1) neighbours[face.cube][axis] = number(face);
        rotation.insert(rotation.end(), face.turn.data(), face.turn.data() + 4);
    }
}

bool may_hold_knots(const CubeNeighbours& neighbours, const std::vector<float>& rotation,
                    const std::vector<PinnedFace>& faces)
{
    std::atomic<bool> found = false;
    geometry::parallel_for(neighbours.size(), cubes_a_run, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            const Quaternion q = quaternion_of(rotation, c);
            for (const std::uint32_t n : neighbours[c]) {
                if (n != no_index && far_apart(q, quaternion_of(rotation, n))) found = true;
            }
        }
    });
    for (const PinnedFace& face : faces) {
        if (far_apart(face.turn, quaternion_of(rotation, face.cube))) found = true;
    }
    for_neighbour_faces(faces, neighbours,
                        [&](const PinnedFace& face, const PinnedFace& next, std::size_t) {
                            if (far_apart(face.turn, next.turn)) found = true;
                        });
    return found;
}

// Cubes whose signs are tied to each other.
class SignTree {
public:
    explicit SignTree(std::size_t n) : parent_(n), sizes_(n, 1), flips_(n, 0)
    {
        for (std::uint32_t i = 0; i < n; ++i) parent_[i] = i;
    }
    // The root of i, and whether its sign is the other one.
    std::pair<std::uint32_t, bool> root(std::uint32_t i) const
    {
        bool flips = false;
        while (parent_[i] != i) flips = flips != (flips_[i] != 0), i = parent_[i];
        return {i, flips};
    }
    // Ties a and b, or says false: they are already.
    bool tie(std::uint32_t a, std::uint32_t b, bool flips)
    {
        const auto [root_a, flips_a] = root(a);
        const auto [root_b, flips_b] = root(b);
        if (root_a == root_b) return false;
        const bool b_above = sizes_[root_b] > sizes_[root_a];
        const std::uint32_t above = b_above ? root_b : root_a, below = b_above ? root_a : root_b;
        parent_[below] = above;
        flips_[below] = flips != (flips_a != flips_b) ? 1 : 0;
        sizes_[above] += sizes_[below];
        return true;
    }

private:
    std::vector<std::uint32_t> parent_, sizes_;
    std::vector<std::uint8_t> flips_;
};

// The faces between cubes, 3 c + axis for that of cube c towards +axis.
struct Signed {
    std::vector<Quaternion> q;       // with signs chosen
    std::vector<std::uint8_t> torn;  // 1: a face whose cubes' signs do not fit
};

Signed choose_signs(const CubeNeighbours& neighbours, const std::vector<float>& rotation)
{
    const auto n = static_cast<std::uint32_t>(neighbours.size());
    std::vector<std::pair<float, std::uint32_t>> faces;  // the worst fit last
    for (std::uint32_t face = 0; face < 3 * n; ++face) {
        const std::uint32_t other = neighbours[face / 3][face % 3];
        if (other == no_index) continue;
        const float dot = quaternion_of(rotation, face / 3).dot(quaternion_of(rotation, other));
        faces.emplace_back(-std::abs(dot), face);
    }
    std::sort(faces.begin(), faces.end());
    SignTree tree(n);
    for (const auto& [fit, face] : faces) {
        const std::uint32_t a = face / 3, b = neighbours[a][face % 3];
        tree.tie(a, b, quaternion_of(rotation, a).dot(quaternion_of(rotation, b)) < 0);
    }
    Signed out;
    for (std::uint32_t c = 0; c < n; ++c) {
        const Quaternion q = quaternion_of(rotation, c);
        out.q.push_back(tree.root(c).second ? Quaternion(-q) : q);
    }
    out.torn.assign(3 * std::size_t{n}, 0);
    for (const auto& [fit, face] : faces) {
        const std::uint32_t a = face / 3, b = neighbours[a][face % 3];
        out.torn[face] = out.q[a].dot(out.q[b]) < 0 ? 1 : 0;
    }
    return out;
}

// Calls with the four faces around each lattice edge that has four cubes.
template <class Each> void for_each_ring(const CubeNeighbours& neighbours, const Each& each)
{
    for (std::uint32_t c = 0; c < neighbours.size(); ++c) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t j = (i + 1) % 3;
            const std::uint32_t along_i = neighbours[c][i], along_j = neighbours[c][j];
            if (along_i == no_index || along_j == no_index) continue;
            const std::uint32_t last = neighbours[along_i][j];
            if (last == no_index || neighbours[along_j][i] != last) continue;
            each(std::array{3 * c + i, 3 * along_i + j, 3 * along_j + i, 3 * c + j});
        }
    }
}

// 1 for the cubes at sheets of torn faces that end inside the body. A sheet that does not is a turn
// of the body about a hole, which is its own.
std::vector<std::uint8_t> cubes_at_knots(const CubeNeighbours& neighbours, const Signed& of)
{
    geometry::UnionFind sheets(of.torn.size());
    std::vector<std::uint32_t> ends;
    for_each_ring(neighbours, [&](const std::array<std::uint32_t, 4>& ring) {
        std::uint32_t first = no_index;
        bool odd = false;
        for (const std::uint32_t face : ring) {
            if (!of.torn[face]) continue;
            odd = !odd;
            if (first != no_index) sheets.join(first, face);
            first = face;
        }
        if (odd) ends.push_back(first);
    });
    std::vector<std::uint8_t> ending(of.torn.size(), 0), out(neighbours.size(), 0);
    for (const std::uint32_t face : ends) ending[sheets.root(face)] = 1;
    for (std::uint32_t face = 0; face < of.torn.size(); ++face) {
        if (!of.torn[face] || !ending[sheets.root(face)]) continue;
        out[face / 3] = out[neighbours[face / 3][face % 3]] = 1;
    }
    return out;
}

void widen(const CubeNeighbours& neighbours, std::vector<std::uint8_t>& chosen)
{
    const std::vector<std::uint8_t> before = chosen;
    for (std::uint32_t c = 0; c < neighbours.size(); ++c) {
        for (const std::uint32_t n : neighbours[c]) {
            if (n == no_index) continue;
            if (before[c]) chosen[n] = 1;
            if (before[n]) chosen[c] = 1;
        }
    }
}

// The chosen cubes' quaternions become means of their own and those of their neighbours.
void smooth(const CubeNeighbours& neighbours, const std::vector<std::uint8_t>& chosen,
            std::vector<Quaternion>& q)
{
    const std::vector<Quaternion> own = q;
    for (int round = 0; round < rounds; ++round) {
        std::vector<Quaternion> sum = own;
        for (std::uint32_t c = 0; c < neighbours.size(); ++c) {
            for (const std::uint32_t n : neighbours[c]) {
                if (n == no_index) continue;
                sum[c] += q[n];
                sum[n] += q[c];
            }
        }
        for (std::uint32_t c = 0; c < q.size(); ++c) {
            const float size = sum[c].norm();
            if (chosen[c] && size > 1e-3f) q[c] = sum[c] / size;
        }
    }
}

}  // namespace

CubeNeighbours find_neighbours(const geometry::Cubes& cubes)
{
    // Cubes by their corner 0: the neighbour towards an axis has there what this one has next.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> by_first;
    for (std::uint32_t c = 0; c < cubes.count(); ++c) by_first.emplace_back(cubes.corners[c][0], c);
    std::sort(by_first.begin(), by_first.end());
    CubeNeighbours out(cubes.count(), {no_index, no_index, no_index});
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        const auto& own = cubes.corners[c];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t step = std::size_t{1} << axis;
            const std::pair<std::uint32_t, std::uint32_t> from{own[step], 0};
            for (auto at = std::lower_bound(by_first.begin(), by_first.end(), from);
                 at != by_first.end() && at->first == own[step]; ++at) {
                const auto& its = cubes.corners[at->second];
                bool shared = true;
                for (std::size_t a = 0; a < 8; ++a) {
                    if (!(a & step)) shared = shared && its[a] == own[a | step];
                }
                if (shared) out[c][axis] = at->second;
            }
        }
    }
    return out;
}

std::vector<HeldRotation> undo_knots(const geometry::Cubes& cubes,
                                     const CubeNeighbours& cube_neighbours,
                                     const std::vector<float>& cube_rotation, const Pins& pins)
{
    if (cube_rotation.size() != 4 * cubes.count()) return {};
    const auto faces = pinned_faces(cubes, pins, cube_neighbours, cube_rotation);
    if (!may_hold_knots(cube_neighbours, cube_rotation, faces)) return {};
    CubeNeighbours neighbours = cube_neighbours;
    std::vector<float> rotation = cube_rotation;
    add_faces(faces, neighbours, rotation);
    Signed at = choose_signs(neighbours, rotation);
    std::vector<std::uint8_t> chosen = cubes_at_knots(neighbours, at);
    if (std::none_of(chosen.begin(), chosen.end(), [](auto c) { return c != 0; })) return {};
    for (int i = 0; i < reach; ++i) widen(neighbours, chosen);
    std::fill(chosen.begin() + std::ptrdiff_t(cubes.count()), chosen.end(), std::uint8_t{0});
    smooth(neighbours, chosen, at.q);
    std::vector<HeldRotation> out;
    for (std::uint32_t c = 0; c < neighbours.size(); ++c) {
        if (chosen[c]) out.push_back({c, {at.q[c][0], at.q[c][1], at.q[c][2], at.q[c][3]}});
    }
    return out;
}

}  // namespace physics
