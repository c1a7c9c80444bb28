#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "geometry/embed/embed_kernels.cpp"
#include <hwy/foreach_target.h>  // compiles the rest of this file once for each instruction set

#include "geometry/embed/embed_kernels.hpp"

#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace geometry::HWY_NAMESPACE {
// A vector in each four lanes: of two vertices, or of one where nothing wider than four is sure to
// be there. The compiler's own vectors: what Highway has for such machines is one lane.
constexpr std::size_t at_once = HWY_TARGET == HWY_SCALAR ? 1 : 2;
using V = float __attribute__((vector_size(16 * at_once)));
using Quad = float __attribute__((vector_size(16)));

HWY_INLINE V join(const float* a, const float* b)
{
#if HWY_TARGET == HWY_SCALAR
    V all;
    std::memcpy(&all, a, sizeof all);
    (void)b;
    return all;
#else
    Quad low, high;
    std::memcpy(&low, a, sizeof low);
    std::memcpy(&high, b, sizeof high);
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#endif
}

// Lanes i, j, k, l of each vector.
template <int i, int j, int k, int l> HWY_INLINE V lanes(V a)
{
#if HWY_TARGET == HWY_SCALAR
    return __builtin_shufflevector(a, a, i, j, k, l);
#else
    return __builtin_shufflevector(a, a, i, j, k, l, 4 + i, 4 + j, 4 + k, 4 + l);
#endif
}
template <int i> HWY_INLINE V spread(V a)
{
    return lanes<i, i, i, i>(a);
}
HWY_INLINE V yzx(V a)
{
    return lanes<1, 2, 0, 3>(a);
}

HWY_INLINE V join(const Eigen::Array4f& a, const Eigen::Array4f& b)
{
    return join(a.data(), b.data());
}

// A vector of an array as four lanes. Reads the number behind it, but not behind the array.
class Wide {
public:
    Wide(std::span<const Vec3f> all, std::size_t i)
    {
        at_ = all[i].data();
        if (i + 1 < all.size()) return;
        std::memcpy(last_, at_, sizeof(Vec3f));
        at_ = last_;
    }
    Wide(const Wide&) = delete;
    Wide& operator=(const Wide&) = delete;
    const float* data() const { return at_; }

private:
    const float* at_;
    float last_[4] = {};
};

HWY_INLINE V join(std::span<const Vec3f> all, std::size_t a, std::size_t b)
{
    const Wide wide_a(all, a), wide_b(all, b);
    return join(wide_a.data(), wide_b.data());
}

// Puts the vectors of `v` at to[i], to[i + 1] .. before `end`, in order: the fourth lane of each
// falls on the place of the next, which comes after it.
HWY_INLINE void put(V v, std::span<Vec3f> to, std::size_t i, std::size_t end)
{
    const bool inside = i + at_once < end;
    for (std::size_t k = 0; k < at_once && i + k < end; ++k) {
        const char* const from = reinterpret_cast<const char*>(&v) + k * sizeof(Quad);
        if (inside) {
            std::memcpy(to[i + k].data(), from, sizeof(Quad));
        } else {
            std::memcpy(to[i + k].data(), from, sizeof(Vec3f));
        }
    }
}

// Places in cubes, and du/dx there.
struct Here {
    HWY_INLINE Here(const CarriedPlaces& places, std::size_t v, std::size_t w)
        : a(places.polynomials[places.cube[v]]), b(places.polynomials[places.cube[w]])
    {
        const V p = join(places.local, v, w);
        x = spread<0>(p), y = spread<1>(p), z = spread<2>(p);
        cxy = join(a.cxy, b.cxy), czx = join(a.czx, b.czx), cyz = join(a.cyz, b.cyz);
        cxyz = join(a.cxyz, b.cxyz);
        dx = (join(a.cx, b.cx) + cxy * y) + z * (czx + cxyz * y);
    }
    const CubePolynomial &a, &b;
    V x, y, z, cxy, czx, cyz, cxyz, dx;
};

HWY_INLINE V moved(const Here& h)
{
    return (join(h.a.c0, h.b.c0) + h.x * h.dx) + h.y * (join(h.a.cy, h.b.cy) + h.cyz * h.z) +
           h.z * join(h.a.cz, h.b.cz);
}

// With f_d the columns of F,
//   cof(F) n = n_x f_y x f_z + n_y f_z x f_x + n_z f_x x f_y
//            = f_y x (n_x f_z - n_z f_x) + n_y f_z x f_x,   and (a x b) = yzx(a yzx(b) - yzx(a) b).
HWY_INLINE V turned(const Here& h, float per_metre, V n)
{
    static constexpr float unit[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    const V dy = (join(h.a.cy, h.b.cy) + h.cxy * h.x) + h.z * (h.cyz + h.cxyz * h.x);
    const V dz = (join(h.a.cz, h.b.cz) + h.czx * h.x) + h.y * (h.cyz + h.cxyz * h.x);
    const V fx = per_metre * h.dx + join(unit[0], unit[0]);
    const V fy = per_metre * dy + join(unit[1], unit[1]);
    const V fz = per_metre * dz + join(unit[2], unit[2]);
    const V g = spread<0>(n) * fz - spread<2>(n) * fx;
    const V m = yzx((fy * yzx(g) - yzx(fy) * g) + spread<1>(n) * (fz * yzx(fx) - yzx(fz) * fx));
    const V square = m * m;
    const V length_sq = spread<0>(square) + spread<1>(square) + spread<2>(square);
    V length = V{} + std::sqrt(length_sq[0]);
#if HWY_TARGET != HWY_SCALAR
    const V other = V{} + std::sqrt(length_sq[4]);
    length = __builtin_shufflevector(length, other, 0, 1, 2, 3, 12, 13, 14, 15);
#endif
    const auto some = (length_sq > 1e-24f) & (length_sq < std::numeric_limits<float>::infinity());
    return some ? m / length : n;
}

void CarryPositions(const CarriedPlaces& places, std::span<const Vec3f> rest, std::size_t begin,
                    std::size_t end, std::span<Vec3f> to)
{
    for (std::size_t v = begin; v < end; v += at_once) {
        const std::size_t w = std::min(v + at_once, end) - 1;
        put(join(rest, v, w) + moved(Here(places, v, w)), to, v, end);
    }
}

void TurnNormals(const CarriedPlaces& places, std::span<const std::uint32_t> vertex,
                 float per_metre, std::span<const Vec3f> rest, std::size_t begin, std::size_t end,
                 std::span<Vec3f> to)
{
    const std::size_t count = places.local.size();
    for (std::size_t n = begin; n < end; n += at_once) {
        const std::size_t m = std::min(n + at_once, end) - 1;
        const std::uint32_t v = vertex[n], w = vertex[m];
        const Here here(places, v < count ? v : 0, w < count ? w : 0);
        put(turned(here, per_metre, join(rest, n, m)), to, n, end);
        if (v >= count) to[n] = rest[n];
        if (w >= count) to[m] = rest[m];
    }
}

void CarryVertices(const CarriedPlaces& places, std::span<const Vec3f> rest,
                   std::span<const Vec3f> rest_normals, float per_metre, std::size_t begin,
                   std::size_t end, std::span<Vec3f> to, std::span<Vec3f> to_normals)
{
    for (std::size_t v = begin; v < end; v += at_once) {
        const std::size_t w = std::min(v + at_once, end) - 1;
        const Here here(places, v, w);
        put(join(rest, v, w) + moved(here), to, v, end);
        put(turned(here, per_metre, join(rest_normals, v, w)), to_normals, v, end);
    }
}

}  // namespace geometry::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace geometry {

HWY_EXPORT(CarryPositions);
HWY_EXPORT(TurnNormals);
HWY_EXPORT(CarryVertices);

void carry_positions(const CarriedPlaces& places, std::span<const Vec3f> rest, std::size_t begin,
                     std::size_t end, std::span<Vec3f> to)
{
    HWY_DYNAMIC_DISPATCH(CarryPositions)(places, rest, begin, end, to);
}

void turn_normals(const CarriedPlaces& places, std::span<const std::uint32_t> vertex,
                  float per_metre, std::span<const Vec3f> rest, std::size_t begin, std::size_t end,
                  std::span<Vec3f> to)
{
    HWY_DYNAMIC_DISPATCH(TurnNormals)(places, vertex, per_metre, rest, begin, end, to);
}

void carry_vertices(const CarriedPlaces& places, std::span<const Vec3f> rest,
                    std::span<const Vec3f> rest_normals, float per_metre, std::size_t begin,
                    std::size_t end, std::span<Vec3f> to, std::span<Vec3f> to_normals)
{
    HWY_DYNAMIC_DISPATCH(CarryVertices)
    (places, rest, rest_normals, per_metre, begin, end, to, to_normals);
}

CubePolynomial polynomial_of(const std::array<Vec3, 8>& u)
{
    const auto lanes = [](const Vec3& v) {
        return Eigen::Array4f(static_cast<float>(v.x()), static_cast<float>(v.y()),
                              static_cast<float>(v.z()), 0);
    };
    return {lanes(u[0]),
            lanes(u[1] - u[0]),
            lanes(u[2] - u[0]),
            lanes(u[4] - u[0]),
            lanes(u[3] - u[1] - u[2] + u[0]),
            lanes(u[6] - u[2] - u[4] + u[0]),
            lanes(u[5] - u[1] - u[4] + u[0]),
            lanes(u[7] - u[6] - u[5] - u[3] + u[1] + u[2] + u[4] - u[0])};
}

Vec3f affine_at(const CubePolynomial& u, const Vec3f& p, const Vec3f& by)
{
    using Lanes = Eigen::Array4f;
    const Lanes dx = (u.cx + u.cxy * p.y()) + p.z() * (u.czx + u.cxyz * p.y());
    const Lanes dy = (u.cy + u.cxy * p.x()) + p.z() * (u.cyz + u.cxyz * p.x());
    const Lanes dz = (u.cz + u.czx * p.x()) + p.y() * (u.cyz + u.cxyz * p.x());
    const Lanes at = (u.c0 + p.x() * dx) + p.y() * (u.cy + u.cyz * p.z()) + p.z() * u.cz;
    const Lanes moved = at + dx * by.x() + dy * by.y() + dz * by.z();
    return moved.head<3>().matrix();
}

}  // namespace geometry
#endif
