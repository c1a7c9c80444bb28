#include "physics/lattice/match_shapes.hpp"

#include "physics/lattice/match_slots.hpp"
#include "physics/lattice/plastic_flow.hpp"
#include "physics/lattice/region_volume.hpp"
#include "physics/math/rotation.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <cmath>

namespace physics {

namespace {

constexpr std::size_t batch = 64;  // regions whose rotations are found together

// How far a plane's region is bent like a saddle, as far as it may stay so, into s[3]: (1 -
// phi) / B P. s is its sums. Returns a of its psi.
template <class T> T keep_twist(const StepState<T>& step, std::size_t slot, Quad<T>* s)
{
    const auto& [b, c, loose] = step.twist[slot];
    const T inverse = s[0][3] > 0 ? 1 / s[0][3] : T(0);
    const auto about_middle = [&](int q) -> Quad<T> { return s[q] - s[q][3] * inverse * s[0]; };
    const Quad<T> bent = about_middle(3) - b * about_middle(1) - c * about_middle(2);
    const T a = inverse * (s[3][3] - b * s[1][3] - c * s[2][3]);
    s[3] = loose * bent;
    s[3][3] = T(0);
    return a;
}

// Adds what keep_twist() left in s[3] to what is spread, times the slot's weight.
template <class T> void add_twist(const StepState<T>& step, std::size_t slot, T a, Quad<T>* s)
{
    s[3] *= step.weight[slot];
    s[0] -= a * s[3];
    s[1] -= step.twist[slot].b * s[3];
    s[2] -= step.twist[slot].c * s[3];
}

// A_r of a slot, with the columns of rest axes; s is its sums.
template <class T> Eigen::Matrix<T, 3, 3> moment_matrix(const FrameState& step, const Quad<T>* s)
{
    using Mat = Eigen::Matrix<T, 3, 3>;
    const LatticeRegions& regions = step.matched->regions;
    const T inverse = s[0][3] > 0 ? 1 / s[0][3] : T(0);
    Mat m = Mat::Zero();
    for (std::size_t d = 1; d <= regions.sides(); ++d) {
        m.col(regions.axes[d - 1]) =
            (s[d] - (s[d][3] * inverse) * s[0]).template head<3>().matrix();
    }
    return m;
}

// A flat region has no extent along one axis: its normal, as long as its sides, stands in.
template <class T> void complete(const FrameState& step, Eigen::Matrix<T, 3, 3>& m)
{
    using Vec = Eigen::Matrix<T, 3, 1>;
    const int n = step.body.flat_axis;
    const Vec a = m.col((n + 1) % 3), b = m.col((n + 2) % 3);
    const Vec normal = a.cross(b);
    const T length = normal.norm();
    m.col(n) = length > 0 ? (normal * (std::sqrt(length) / length)).eval() : normal;
}

// match_shapes() where nothing flows and sums are single, many regions at a time.
template <class T> void match_rigid(StepState<T>& step, std::size_t first, std::span<Quad<T>> slots)
{
    if constexpr (std::is_same_v<T, float>) {
        MatchedSlots some{slots.size() / 4, slots.data()->data(), step.weight.data() + first,
                          step.state.rotation.data() + 4 * first};
        some.axes = step.matched->regions.axes;
        some.h = float(step.body.base.h);
        if (step.flat) some.twist = &step.twist[first].b;
        if (step.volume) {
            some.volume = step.volume[first].root.data();
            some.volume_share = step.volume_share.data() + first;
            if (!step.stretch_share.empty()) {
                some.stretch_share = step.stretch_share.data() + first;
            }
        }
        match_slots(some);
    }
}

// From sums over regions to their rigid motions, with weights. At most a batch.
template <class T>
void match_shapes(StepState<T>& step, std::size_t begin, std::span<Quad<T>> slots)
{
    using Vec = Eigen::Matrix<T, 3, 1>;
    using Mat = Eigen::Matrix<T, 3, 3>;
    const LatticeRegions& regions = step.matched->regions;
    const std::size_t count = slots.size() / 4;
    alignas(64) T a[9 * batch], q[4 * batch];
    float* const rotation = step.state.rotation.data();
    for (std::size_t k = 0; k < count; ++k) {
        Mat m = moment_matrix(step, &slots[4 * k]);
        if (step.plastic) m = (m * rest_shape<T>(step, begin + k)).eval();
        if (step.flat) complete(step, m);
        for (int i = 0; i < 9; ++i) a[std::size_t(i) * batch + k] = m(i / 3, i % 3);
        for (std::size_t c = 0; c < 4; ++c) q[c * batch + k] = T(rotation[4 * (begin + k) + c]);
    }
    extract_rotations(count, a, batch, q, batch);
    const T h = T(step.body.base.h);
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t slot = begin + k;
        Quad<T>* const s = &slots[4 * k];
        const Eigen::Quaternion<T> turn(q[k], q[batch + k], q[2 * batch + k], q[3 * batch + k]);
        for (std::size_t c = 0; c < 4; ++c) rotation[4 * slot + c] = float(q[c * batch + k]);
        Mat r = turn.toRotationMatrix();
        if (step.plastic) {
            flow<T>(step, slot, moment_matrix(step, s), r);
            r = (r * rest_shape<T>(step, slot)).eval();
        }
        if (step.volume) {
            const T size = step.plastic ? r.determinant() : T(1);
            const Mat moments = moment_matrix(step, s);
            if (!step.stretch_share.empty()) {
                r += step.stretch_share[slot] * (r - linear_map(step.volume[slot], moments, h));
            }
            r += step.volume_share[slot] * pull_to_volume(step.volume[slot], moments, h, size);
        }
        const T weight = step.weight[slot], inverse = s[0][3] > 0 ? 1 / s[0][3] : T(0);
        const Vec centre = inverse * s[0].template head<3>().matrix();
        Vec moved = centre;
        const T twisted = step.flat ? keep_twist(step, slot, s) : T(0);
        for (std::size_t d = 1; d <= regions.sides(); ++d) {
            const Vec column = h * r.col(regions.axes[d - 1]);
            moved -= (s[d][3] * inverse) * column;  // C_r - X_r, lattice steps
            s[d] = Quad<T>(weight * column[0], weight * column[1], weight * column[2], T(0));
        }
        moved *= weight;
        s[0] = Quad<T>(moved[0], moved[1], moved[2], T(0));
        if (step.flat) add_twist(step, slot, twisted, s);
    }
}

// The same in two dimensions: rotations have a closed form.
template <class T>
void match_in_plane(StepState<T>& step, std::size_t begin, std::span<Quad<T>> slots)
{
    using Vec = Eigen::Matrix<T, 3, 1>;
    using Mat = Eigen::Matrix<T, 3, 3>;
    const LatticeRegions& regions = step.matched->regions;
    const int u = regions.axes[0], v = regions.axes[1];
    const std::size_t count = slots.size() / 4;
    alignas(64) T a[4 * batch], turn[2 * batch];
    float* const rotation = step.state.rotation.data();
    for (std::size_t k = 0; k < count; ++k) {
        Mat m = moment_matrix(step, &slots[4 * k]);
        if (step.plastic) m = (m * rest_shape<T>(step, begin + k)).eval();
        a[k] = m(u, u);
        a[batch + k] = m(u, v);
        a[2 * batch + k] = m(v, u);
        a[3 * batch + k] = m(v, v);
        for (std::size_t c = 0; c < 2; ++c) {
            turn[c * batch + k] = T(rotation[4 * (begin + k) + c]);
        }
    }
    extract_rotations_2d(count, a, batch, turn, batch);
    const T h = T(step.body.base.h);
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t slot = begin + k;
        Quad<T>* const s = &slots[4 * k];
        const T cosine = turn[k], sine = turn[batch + k];
        rotation[4 * slot] = float(cosine);
        rotation[4 * slot + 1] = float(sine);
        Mat r = Mat::Identity();
        r(u, u) = r(v, v) = cosine;
        r(u, v) = -sine;
        r(v, u) = sine;
        if (step.plastic) {
            flow<T>(step, slot, moment_matrix(step, s), r);
            r = (r * rest_shape<T>(step, slot)).eval();
        }
        const T weight = step.weight[slot], inverse = s[0][3] > 0 ? 1 / s[0][3] : T(0);
        Vec moved = inverse * s[0].template head<3>().matrix();
        for (std::size_t d = 1; d < 3; ++d) {
            const Vec column = h * r.col(regions.axes[d - 1]);
            moved -= (s[d][3] * inverse) * column;
            s[d] = Quad<T>(weight * column[0], weight * column[1], weight * column[2], T(0));
        }
        s[0] = Quad<T>(weight * moved[0], weight * moved[1], weight * moved[2], T(0));
        s[3].setZero();
    }
}

}  // namespace

template <class T> void find_goals(StepState<T>& step)
{
    const auto& mass = step.with_pins.empty() ? step.matched->mass : step.with_pins;
    auto& f = step.sums.particles;
    geometry::parallel_for(step.n, particles_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const T m = T(mass[i]);
            const Vec3 p = step.state.x[i] - step.origin;
            f[i] = Quad<T>(m * T(p[0]), m * T(p[1]), m * T(p[2]), m);
        }
    });
    collect_and_spread<T>(
        step.matched->regions, step.sums, [&](std::size_t first, std::span<Quad<T>> slots) {
            if (std::is_same_v<T, float> && !step.plastic && !step.in_plane) {
                match_rigid(step, first, slots);
                return;
            }
            for (std::size_t s = 0; 4 * s < slots.size(); s += batch) {
                const auto some = slots.subspan(4 * s, std::min(4 * batch, slots.size() - 4 * s));
                if (step.in_plane) {
                    match_in_plane(step, first + s, some);
                } else {
                    match_shapes(step, first + s, some);
                }
            }
        });
}

template void find_goals(StepState<float>&);
template void find_goals(StepState<double>&);

}  // namespace physics
