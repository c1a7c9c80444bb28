#include "geometry/cut_torn.hpp"

#include "geometry/clip_to_cells.hpp"
#include "geometry/corner_frames.hpp"
#include "geometry/cut_caps.hpp"
#include "geometry/embed.hpp"
#include "geometry/embed_kernels.hpp"
#include "geometry/plane.hpp"
#include "geometry/torn_faces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace geometry {
namespace {

constexpr std::uint32_t whole = ~std::uint32_t{0};  // in no parted cube

bool is_broken(std::span<const std::uint32_t> broken, std::uint32_t corner, std::size_t axis)
{
    return std::binary_search(broken.begin(), broken.end(), 3 * corner + std::uint32_t(axis));
}

// Which corner each of its links leads to, 3 a corner.
std::vector<std::uint32_t> links_of(const Cubes& cubes)
{
    std::vector<std::uint32_t> after(3 * cubes.corner_count(), CornerFrames::none);
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

// How a part of a cube moves, from its corners and virtual ones. `normals` are those of a plane's
// corners.
CubePolynomial polynomial_of_part(const Cubes& cubes, std::span<const Vec3> x,
                                  const CornerFrames& frames, int flat,
                                  std::span<const Vec3> normals, const PartedCube& parted,
                                  std::size_t part)
{
    const auto& corners = cubes.corners[parted.cube];
    std::array<Vec3, 8> u;
    for (unsigned b = 0; b < 8; ++b) {
        int least = 4;
        for (unsigned a = 0; a < 8; ++a) {
            if (parted.part[a] == part) least = std::min(least, std::popcount(a ^ b));
        }
        Vec3 place = Vec3::Zero(), normal = Vec3::Zero();
        int count = 0;
        for (unsigned a = 0; a < 8; ++a) {
            if (parted.part[a] != part || std::popcount(a ^ b) != least) continue;
            Vec3 step = Vec3::Zero();
            for (unsigned d = 0; d < 3; ++d) {
                step[d] = double(b >> d & 1u) - double(a >> d & 1u);
            }
            place += x[corners[a]];
            if (!step.isZero(0)) place += frames.at(corners[a], x) * step;
            if (flat >= 0) normal += normals[corners[a]];
            ++count;
        }
        Vec3 rest = cubes.cell[parted.cube].cast<double>();
        for (unsigned d = 0; d < 3; ++d) rest[d] += double(b >> d & 1u);
        if (flat >= 0) rest[flat] = cubes.corner[corners[0]][flat];
        u[b] = place / count - (cubes.origin + cubes.size * rest);
        if (flat >= 0 && (b >> flat & 1u)) {
            u[b] += cubes.size * (normal.normalized() - Vec3::Unit(flat));
        }
    }
    return polynomial_of(u);
}

std::vector<Vec3i> cells_of(const Cubes& cubes, std::span<const PartedCube> parted)
{
    std::vector<Vec3i> cells;
    for (const PartedCube& p : parted) cells.push_back(cubes.cell[p.cube]);
    return cells;
}

// Cuts the faces of a mesh at rest, closes what is cut, and says which part each corner of that is
// of.
class Cutter {
public:
    struct Corner {
        std::uint32_t face;
        std::uint32_t part;           // 8 * parted cube + part, or whole
        Vec3 at;                      // lattice coordinates
        std::array<double, 3> share;  // of the face's corners
        // Of faces that close what is cut, unit, and `face` is the nearest one; of others zero.
        Vec3 outward = Vec3::Zero();

        bool closes() const { return !outward.isZero(0); }
    };

    // Closed where it is inside `solid`; null: nowhere.
    Cutter(const Binding& binding, const TriMesh& rest, const Cubes& cubes,
           std::span<const PartedCube> parted, const TriangleBvh* solid)
        : rest_(rest), cubes_(cubes), parted_(parted), around_(cubes, cells_of(cubes, parted)),
          alone_(binding, rest), flat_(flat_axis(cubes)),
          cut_(faces_through(rest, cubes, around_, alone_))
    {
        for (std::uint32_t f = 0; f < cut_.size(); ++f) {
            if (cut_[f]) cut_face(f);
        }
        if (solid && flat_ < 0) close(*solid);
    }

    const std::vector<std::uint8_t>& cut() const { return cut_; }  // F
    const std::vector<Corner>& corners() const { return corners_; }
    const std::vector<Triangle>& faces() const { return faces_; }  // new ones, into corners()

private:
    void cut_face(std::uint32_t f)
    {
        face_ = lattice_face(rest_, cubes_, f, flat_);
        const Vec3 a = face_.p[1] - face_.p[0], b = face_.p[2] - face_.p[0];
        if (!(a.cross(b).norm() > 1e-10 * a.norm() * b.norm())) return;  // a line: nothing to see
        // What lies beyond all parted cubes stays in large pieces.
        Polygon inside = face_, below, above;
        for (int d = 0; d < 3; ++d) {
            geometry::cut(inside, d, around_.box().lo[d], below, above);
            add(f, below, whole);
            geometry::cut(above, d, around_.box().hi[d], inside, below);
            add(f, below, whole);
        }
        clip_polygon_to_cells(inside, [&](const Vec3i& cell, const Polygon& piece) {
            const std::uint32_t parted = around_.find(cell, piece, alone_[f]);
            beyond_ = parted != CellsAround::none && around_.cells()[parted] != cell;
            if (parted == CellsAround::none) {
                add(f, piece, whole);
            } else {
                add_parts(f, piece, parted, 0, 0);
            }
        });
    }

    // By the planes between parts, an axis at a time: `octant` says which side along those before.
    void add_parts(std::uint32_t f, const Polygon& piece, std::uint32_t parted, unsigned axis,
                   unsigned octant)
    {
        const PartedCube& cube = parted_[parted];
        bool one = true, alike = true;  // of all octants left, of those beside each other
        for (unsigned o = octant; o < 8; o += 1u << axis) {
            one &= cube.part[o] == cube.part[octant];
            if (axis < 3) alike &= cube.part[o] == cube.part[o ^ 1u << axis];
        }
        if (one) return add(f, piece, 8 * parted + cube.part[octant]);
        if (alike) return add_parts(f, piece, parted, axis + 1, octant);
        Polygon below, above;
        geometry::cut(piece, int(axis), around_.cells()[parted][Eigen::Index(axis)] + 0.5, below,
                      above);
        if (!beyond_) add_edge(parted, int(axis), below);  // cubes are closed in themselves
        if (below.n > 2) add_parts(f, below, parted, axis + 1, octant);
        if (above.n > 2) add_parts(f, above, parted, axis + 1, octant | 1u << axis);
    }

    // Where what was cut meets the plane it was cut by, unless it lies in that. Points that are one
    // but for rounding may be several.
    void add_edge(std::uint32_t parted, int axis, const Polygon& below)
    {
        const double plane = around_.cells()[parted][axis] + 0.5;
        Polygon on;
        for (std::size_t k = 0; k < below.n; ++k) {
            if (below.p[k][axis] == plane) on.add(below.p[k]);
        }
        if (on.n < 2 || (on.n > 2 && on.n == below.n)) return;
        CutEdge longest{parted, axis, on.p[0], on.p[1]};
        for (std::size_t i = 0; i < on.n; ++i) {
            for (std::size_t j = i + 1; j < on.n; ++j) {
                const double length = (on.p[j] - on.p[i]).squaredNorm();
                if (length <= (longest.to - longest.from).squaredNorm()) continue;
                longest.from = on.p[i];
                longest.to = on.p[j];
            }
        }
        edges_.push_back(longest);
    }

    void close(const TriangleBvh& solid)
    {
        const std::vector<Cap> caps = find_caps(cubes_, parted_, std::move(edges_), solid);
        std::vector<Vec3> places;
        for (const Cap& cap : caps) {
            for (const Vec3& at : cap.corners) places.push_back(cubes_.origin + cubes_.size * at);
        }
        std::vector<TriangleBvh::Hit> nearest(places.size());
        solid.closest(places, std::numeric_limits<double>::infinity(), nearest);
        auto hit = nearest.begin();
        for (const Cap& cap : caps) {
            const auto first = std::uint32_t(corners_.size());
            for (const Vec3& at : cap.corners) {
                const Vec3& share = hit->barycentric;
                corners_.push_back(
                    {hit->triangle, cap.part, at, {share[0], share[1], share[2]}, cap.outward});
                ++hit;
            }
            for (std::uint32_t k = 2; k < cap.corners.size(); ++k)
                faces_.push_back({first, first + k - 1, first + k});
        }
    }

    void add(std::uint32_t f, const Polygon& piece, std::uint32_t part)
    {
        if (piece.n < 3 || !(piece.area() > 0)) return;
        const auto first = std::uint32_t(corners_.size());
        for (std::size_t k = 0; k < piece.n; ++k) {
            corners_.push_back({f, part, piece.p[k], shares(piece.p[k])});
        }
        for (std::uint32_t k = 2; k < piece.n; ++k)
            faces_.push_back({first, first + k - 1, first + k});
    }

    std::array<double, 3> shares(const Vec3& p) const
    {
        const Vec3 a = face_.p[1] - face_.p[0], b = face_.p[2] - face_.p[0], to = p - face_.p[0];
        const Vec3 n = a.cross(b);
        const double sq = n.squaredNorm();
        const double one = to.cross(b).dot(n) / sq, two = a.cross(to).dot(n) / sq;
        return {1 - one - two, one, two};
    }

    const TriMesh& rest_;
    const Cubes& cubes_;
    std::span<const PartedCube> parted_;
    CellsAround around_;  // the parted cubes
    FacesAlone alone_;
    int flat_;
    std::vector<std::uint8_t> cut_;
    Polygon face_;
    bool beyond_ = false;  // what is cut lies outside of all cubes
    std::vector<Corner> corners_;
    std::vector<Triangle> faces_;
    std::vector<CutEdge> edges_;
};

// The mean of some of `values` by the shares of a face's corners.
template <class Value>
Value mixed(const std::vector<Value>& values, const Triangle& at,
            const std::array<double, 3>& share)
{
    Value sum = float(share[0]) * values[at[0]];
    for (std::size_t k = 1; k < 3; ++k) sum += float(share[k]) * values[at[k]];
    return sum;
}

// Carries points and normals along with parts of cubes.
class PartMotion {
public:
    PartMotion(const Cubes& cubes, std::span<const Vec3> x, std::span<const std::uint32_t> broken,
               std::span<const PartedCube> parted, std::span<const std::uint8_t> torn)
        : cubes_(cubes), parted_(parted)
    {
        const CornerFrames frames(links_of(cubes), broken, cubes.size);
        const int flat = flat_axis(cubes);
        const std::vector<Vec3> normals = torn_plane_normals(cubes, x, frames, flat, torn);
        for (const PartedCube& p : parted) {
            first_.push_back(std::uint32_t(polynomials_.size()));
            for (std::size_t k = 0; k < p.parts; ++k) {
                polynomials_.push_back(polynomial_of_part(cubes, x, frames, flat, normals, p, k));
            }
        }
    }

    // The part that a vertex is in, as Cutter::Corner says. Of strays, that of their anchors.
    std::uint32_t part_of(const Binding& binding, std::uint32_t v) const
    {
        const std::uint32_t cube = binding.used[binding.cube[v]];
        const auto found =
            std::lower_bound(parted_.begin(), parted_.end(), cube,
                             [](const PartedCube& p, std::uint32_t c) { return p.cube < c; });
        if (found == parted_.end() || found->cube != cube) return whole;
        const Vec3f at = anchor(binding, v);
        unsigned octant = 0;
        for (int d = 0; d < 3; ++d) octant |= unsigned(at[d] >= 0.5f) << d;
        return std::uint32_t(8 * (found - parted_.begin())) + found->part[octant];
    }

    // `rest` goes with `part`, as a vertex bound like this; `to` is where it comes to be.
    void add_vertex(std::uint32_t part, const Vec3f& rest, const Binding& binding, std::uint32_t v)
    {
        add(part, rest, anchor(binding, v), binding.local[v], v);
    }
    // Likewise in its own cube.
    void add_place(std::uint32_t part, const Vec3f& rest, std::uint32_t to)
    {
        const Vec3 cell = cubes_.cell[parted_[part / 8].cube].cast<double>();
        const Vec3 at = (rest.cast<double>() - cubes_.origin) / cubes_.size - cell;
        const Vec3f local = at.cast<float>();
        add(part, rest, local.cwiseMax(0.0f).cwiseMin(1.0f), local, to);
    }
    // A normal of the place that was added last.
    void add_normal(const Vec3f& rest, std::uint32_t to)
    {
        normal_of_.push_back(std::uint32_t(places_.size() - 1));
        normals_.push_back(rest);
        normals_to_.push_back(to);
    }

    void carry(std::vector<Vec3f>& positions, std::vector<Vec3f>& normals)
    {
        for (std::size_t i = 0; i < places_.size(); ++i) {
            positions[places_to_[i]] =
                places_[i] + affine_at(polynomials_[cube_[i]], anchor_[i], local_[i] - anchor_[i]);
        }
        std::vector<Vec3f> turned(normals_.size());
        turn_normals({polynomials_, cube_, anchor_}, normal_of_, float(1 / cubes_.size), normals_,
                     0, normals_.size(), turned);
        for (std::size_t i = 0; i < turned.size(); ++i) normals[normals_to_[i]] = turned[i];
    }

private:
    static Vec3f anchor(const Binding& binding, std::uint32_t v)
    {
        const auto stray = std::lower_bound(
            binding.strays.begin(), binding.strays.end(), v,
            [](const Binding::Stray& s, std::uint32_t of) { return s.vertex < of; });
        const bool strays = stray != binding.strays.end() && stray->vertex == v;
        return strays ? stray->anchor : binding.local[v];
    }
    void add(std::uint32_t part, const Vec3f& rest, const Vec3f& anchor, const Vec3f& local,
             std::uint32_t to)
    {
        cube_.push_back(first_[part / 8] + part % 8);
        anchor_.push_back(anchor);
        local_.push_back(local);
        places_.push_back(rest);
        places_to_.push_back(to);
    }

    const Cubes& cubes_;
    std::span<const PartedCube> parted_;
    std::vector<CubePolynomial> polynomials_;
    std::vector<std::uint32_t> first_;  // of each parted cube
    std::vector<std::uint32_t> cube_, places_to_, normal_of_, normals_to_;
    std::vector<Vec3f> anchor_, local_, places_, normals_;
};

// Where the corners of new faces come to be: their places, and a normal each where there are any.
TriMesh carried_corners(const TriMesh& rest, const std::vector<Triangle>& normals_of,
                        const Cubes& cubes, std::span<const Vec3> x,
                        std::span<const std::uint8_t> torn, PartMotion motion, const Cutter& cutter)
{
    TriMesh points;
    for (const Cutter::Corner& c : cutter.corners()) {
        if (c.closes()) {
            points.positions.push_back((cubes.origin + cubes.size * c.at).cast<float>());
            if (!normals_of.empty()) points.normals.push_back(c.outward.cast<float>());
            continue;
        }
        points.positions.push_back(mixed(rest.positions, rest.triangles()[c.face], c.share));
        if (normals_of.empty()) continue;
        points.normals.push_back(mixed(rest.normals, normals_of[c.face], c.share).normalized());
    }
    // Joined, as the faces are: what lies outside of all cubes goes with what is near.
    MeshTopology joined;
    for (std::uint32_t i = 1; i < points.positions.size(); ++i)
        joined.triangles.push_back({i - 1, i, i});
    points.topology = std::make_shared<MeshTopology>(std::move(joined));
    const Binding binding = bind(points, cubes);
    TriMesh out = embed(binding, points, cubes, x, torn);
    for (std::uint32_t i = 0; i < cutter.corners().size(); ++i) {
        const std::uint32_t part = cutter.corners()[i].part, bound = motion.part_of(binding, i);
        if (part != whole) {
            motion.add_place(part, points.positions[i], i);
        } else if (bound != whole) {  // on its border, or outside and nearest to it
            motion.add_vertex(bound, points.positions[i], binding, i);
        } else {
            continue;
        }
        if (!normals_of.empty()) motion.add_normal(points.normals[i], i);
    }
    motion.carry(out.positions, out.normals);
    return out;
}

// Vertices in parted cubes go with the part that they are in. Those that uncut faces share lie on
// the border of their cube, where it makes a difference to their normals only.
void carry_old_vertices(const TriMesh& rest, const std::vector<Triangle>& normals_of,
                        const Binding& binding, PartMotion motion, TriMesh& carried)
{
    std::vector<std::uint32_t> part(rest.positions.size(), whole);
    for (std::uint32_t v = 0; v < part.size(); ++v) part[v] = motion.part_of(binding, v);
    std::map<std::uint32_t, std::vector<std::uint32_t>> normals_at;
    for (std::size_t f = 0; f < normals_of.size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t v = rest.triangles()[f][k];
            if (part[v] != whole) normals_at[v].push_back(normals_of[f][k]);
        }
    }
    for (std::uint32_t v = 0; v < part.size(); ++v) {
        if (part[v] == whole) continue;
        motion.add_vertex(part[v], rest.positions[v], binding, v);
        for (const std::uint32_t n : normals_at[v]) motion.add_normal(rest.normals[n], n);
    }
    motion.carry(carried.positions, carried.normals);
}

// The number of the group "inside"; without groups so far, all faces are of "outside".
std::uint16_t group_inside(MeshTopology& topology)
{
    auto& names = topology.groups;
    if (topology.group.empty()) {
        names.assign(1, "outside");
        topology.group.assign(topology.triangles.size(), 0);
    }
    const auto found = std::find(names.begin(), names.end(), "inside");
    if (found != names.end()) return std::uint16_t(found - names.begin());
    if (names.size() > 0xffff) return 0;
    names.emplace_back("inside");
    return std::uint16_t(names.size() - 1);
}

// The number of this material; without materials so far, all faces have the first or the default.
std::uint16_t number_of(MeshTopology& topology, const Material& material)
{
    auto& all = topology.materials;
    if (all.empty()) all.emplace_back();
    if (topology.material.empty()) topology.material.assign(topology.triangles.size(), 0);
    const auto found = std::find(all.begin(), all.end(), material);
    if (found != all.end()) return std::uint16_t(found - all.begin());
    if (all.size() > 0xffff) return 0;
    all.push_back(material);
    return std::uint16_t(all.size() - 1);
}

// Where a point lies along the plane across an axis.
Vec2f place_along(const Vec3& across, const Vec3& at)
{
    Eigen::Index axis = 0;
    across.cwiseAbs().maxCoeff(&axis);
    return Vec3f(at.cast<float>())({(axis + 1) % 3, (axis + 2) % 3});
}

}  // namespace

std::vector<PartedCube> find_parted(const Cubes& cubes, std::span<const std::uint32_t> broken)
{
    if (broken.empty()) return {};
    std::vector<PartedCube> out;
    std::vector<std::uint8_t> has_lost(cubes.corner_count(), 0);
    for (const std::uint32_t link : broken) {
        if (link / 3 < has_lost.size()) has_lost[link / 3] = 1;
    }
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        if (c > 0 && cubes.cell[c] == cubes.cell[c - 1]) continue;
        const auto& corners = cubes.corners[c];
        if (std::none_of(corners.begin(), corners.end(),
                         [&](auto k) { return has_lost[k] != 0; })) {
            continue;
        }
        PartedCube cube{c, {0, 1, 2, 3, 4, 5, 6, 7}, 0};
        const auto join = [&](std::size_t a, std::size_t b) {
            const std::uint8_t low = std::min(cube.part[a], cube.part[b]);
            const std::uint8_t high = std::max(cube.part[a], cube.part[b]);
            std::replace(cube.part.begin(), cube.part.end(), high, low);
        };
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t d = 0; d < 3; ++d) {
                const std::size_t b = a | std::size_t{1} << d;
                if (a != b && (corners[a] == corners[b] || !is_broken(broken, corners[a], d))) {
                    join(a, b);
                }
            }
        }
        std::array<std::uint8_t, 8> number;
        for (std::size_t a = 0; a < 8; ++a) {
            if (cube.part[a] == a) number[a] = cube.parts++;
            cube.part[a] = number[cube.part[a]];
        }
        if (cube.parts > 1) out.push_back(cube);
    }
    return out;
}

std::vector<std::uint8_t> marked(const Cubes& cubes, std::span<const PartedCube> parted)
{
    std::vector<std::uint8_t> out(cubes.count(), 0);
    for (const PartedCube& p : parted) out[p.cube] = 1;
    return out;
}

TriMesh cut_torn(const Binding& binding, const TriMesh& rest, TriMesh carried, const Cubes& cubes,
                 std::span<const Vec3> x, std::span<const std::uint32_t> broken,
                 std::span<const PartedCube> parted, const Closing& closing)
{
    if (parted.empty()) return carried;
    const MeshTopology& before = *rest.topology;
    const std::vector<Triangle>& triangles = before.triangles;
    const bool own_normals = before.normal_triangles.size() == triangles.size();
    const bool normals_listed = own_normals || rest.normals.size() == rest.positions.size();
    static const std::vector<Triangle> nothing;
    const auto& normals_of = rest.normals.empty() || !normals_listed ? nothing
                             : own_normals                           ? before.normal_triangles
                                                                     : triangles;
    const bool has_uvs = before.uv_triangles.size() == triangles.size();
    const std::vector<std::uint8_t> torn = marked(cubes, parted);
    const PartMotion motion(cubes, x, broken, parted, torn);
    carry_old_vertices(rest, normals_of, binding, motion, carried);
    const Cutter cutter(binding, rest, cubes, parted, closing.solid);
    if (cutter.faces().empty()) return carried;

    const TriMesh points = carried_corners(rest, normals_of, cubes, x, torn, motion, cutter);
    carried = without_faces(std::move(carried), cutter.cut());
    MeshTopology topology = *carried.topology;
    if (!normals_of.empty() && !own_normals) topology.normal_triangles = topology.triangles;

    // One vertex for all that meet at rest and still do.
    const auto near = float(1e-4 * cubes.size);
    std::map<std::array<std::int64_t, 3>, std::vector<std::uint32_t>> known;
    std::vector<Triangle> corner(cutter.corners().size());  // vertex, normal and uv of each
    for (std::size_t i = 0; i < corner.size(); ++i) {
        const Cutter::Corner& c = cutter.corners()[i];
        const Triangle& vertices = triangles[c.face];
        const auto meets = [&](std::uint32_t v) {
            return (carried.positions[v] - points.positions[i]).norm() < near;
        };
        const auto k =
            std::size_t(std::max_element(c.share.begin(), c.share.end()) - c.share.begin());
        if (!c.closes() && c.share[k] > 1 - 1e-9 &&
            meets(vertices[k])) {  // a corner of the face itself
            corner[i][0] = vertices[k];
            if (!normals_of.empty()) corner[i][1] = normals_of[c.face][k];
            if (has_uvs) corner[i][2] = before.uv_triangles[c.face][k];
            continue;
        }
        std::array<std::int64_t, 3> key;
        for (std::size_t d = 0; d < 3; ++d) {
            constexpr double fine = 1 << 20;
            key[d] = std::llround(std::clamp(c.at[Eigen::Index(d)], -1e12, 1e12) * fine);
        }
        auto& there = known[key];
        const auto same = std::find_if(there.begin(), there.end(), meets);
        corner[i][0] = same != there.end() ? *same : std::uint32_t(carried.positions.size());
        if (same == there.end()) {
            there.push_back(corner[i][0]);
            carried.positions.push_back(points.positions[i]);
            if (!carried.colours.empty()) {
                carried.colours.push_back(mixed(rest.colours, vertices, c.share));
            }
            for (Attribute& a : carried.attributes) {
                a.values.push_back(mixed(a.values, vertices, c.share));
            }
        }
        if (!normals_of.empty()) {
            corner[i][1] = std::uint32_t(carried.normals.size());
            carried.normals.push_back(points.normals[i]);
        }
        if (has_uvs) {
            corner[i][2] = std::uint32_t(topology.uvs.size());
            topology.uvs.push_back(c.closes() && closing.material
                                       ? place_along(c.outward, cubes.origin + cubes.size * c.at)
                                       : mixed(before.uvs, before.uv_triangles[c.face], c.share));
        }
    }
    const auto& corners = cutter.corners();
    const bool closes = !corners.empty() && corners.back().closes();
    const std::uint16_t inside = closes ? group_inside(topology) : 0;
    const bool own_material = closes && closing.material;
    const std::uint16_t material = own_material ? number_of(topology, *closing.material) : 0;
    for (const Triangle& face : cutter.faces()) {
        const std::uint32_t source = corners[face[0]].face;
        const auto entries = [&](std::size_t what) -> Triangle {
            return {corner[face[0]][what], corner[face[1]][what], corner[face[2]][what]};
        };
        topology.triangles.push_back(entries(0));
        if (!normals_of.empty()) topology.normal_triangles.push_back(entries(1));
        if (has_uvs) topology.uv_triangles.push_back(entries(2));
        const bool is_inside = corners[face[0]].closes();
        if (!topology.material.empty()) {
            const std::uint16_t outside =
                before.material.empty() ? std::uint16_t{0} : before.material[source];
            topology.material.push_back(is_inside && own_material ? material : outside);
        }
        if (!closes && before.group.empty()) continue;
        const std::uint16_t outside =
            before.group.empty() ? std::uint16_t{0} : before.group[source];
        topology.group.push_back(is_inside ? inside : outside);
    }
    carried.topology = std::make_shared<MeshTopology>(std::move(topology));
    return carried;
}

}  // namespace geometry
