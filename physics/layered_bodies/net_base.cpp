#include "physics/layered_bodies/net_base.hpp"

#include "physics/layers/velocity_at.hpp"
#include "physics/math/cross_matrix.hpp"
#include "physics/math/polar.hpp"

#include <fmt/format.h>

#include <set>
#include <stdexcept>

namespace physics {
namespace {

using geometry::Skeleton;

// What of a carried frame's turning at rest it keeps when its masses fall together.
constexpr double least_turned = 0.01;

// Where mass i of frame f is drawn in it.
Vec3 drawn_in_frame(const Base& base, std::size_t f, std::uint32_t mass)
{
    return base.frames[mass].translation() - base.frames[f].translation();
}

// tr(S) I - S, undone. A segment's own axis has no turning.
Mat3 undone(const Mat3& U, const Vec3& stretch, double rest, bool segment)
{
    const double least = least_turned * rest;
    if (segment) {
        const double along = std::max(stretch[0], least);
        return (Mat3::Identity() - U.col(0) * U.col(0).transpose()) / along;
    }
    const Vec3 turned = (Vec3::Constant(stretch.sum()) - stretch).cwiseMax(least).cwiseInverse();
    return U * turned.asDiagonal() * U.transpose();
}

// A rotation that takes `from`, turned by `before`, to `to` by the shortest way.
Mat3 turned_along(const Mat3& before, const Vec3& from, const Vec3& to)
{
    if (!(to.squaredNorm() > 0)) return before;
    const Vec3 was = before * from;
    return Eigen::Quaterniond::FromTwoVectors(was, to).toRotationMatrix() * before;
}

// Stretches the samples of a segment or triangle. Side samples cross a share of its length, those
// of faces one of its area.
class StretchedSamples {
public:
    StretchedSamples(const Skeleton& rest, const Skeleton& now, SurfaceSamples& samples)
        : rest_(rest.points), now_(now.points), samples_(samples)
    {
        if (rest_.size() == 3) {
            const auto twice_area = [](const std::vector<Vec3>& p) {
                return (p[1] - p[0]).cross(p[2] - p[0]).norm();
            };
            area_ = twice_area(now_) / twice_area(rest_);
        }
    }

    void stretch(std::size_t i)
    {
        const Vec3 share = shares_at(rest_, samples_.origin[i]);
        Vec3 origin = Vec3::Zero();
        for (std::size_t k = 0; k < now_.size(); ++k) {
            origin += share[static_cast<Eigen::Index>(k)] * now_[k];
        }
        samples_.origin[i] = origin;
        samples_.a0[i] *= area_;
        if (!(samples_.a1[i] > 0)) return;
        // The side that it starts from: opposite the corner that has no share in it.
        Eigen::Index off = 2;
        if (now_.size() == 3) share.minCoeff(&off);
        const auto a = static_cast<std::size_t>((off + 1) % 3),
                   b = static_cast<std::size_t>((off + 2) % 3);
        const Vec3 was = rest_[b] - rest_[a], is = now_[b] - now_[a];
        samples_.a1[i] *= is.norm() / was.norm();
        if (now_.size() == 3 && is.squaredNorm() > 0) {
            Vec3& n = samples_.direction[i];
            n = turned_along(Mat3::Identity(), was, is) * n;
        }
    }

private:
    const std::vector<Vec3>&rest_, &now_;
    SurfaceSamples& samples_;
    double area_ = 1;
};

}  // namespace

std::span<const std::uint32_t> masses_of(const Base& base, std::size_t f)
{
    return base.spans[f - mass_count(base)].masses;
}

void add_spring_skeletons(Base& base, double stiffness, double damping)
{
    if (base.kind != BaseKind::net || base.spans.empty()) {
        throw std::invalid_argument(
            "springs along skeletons need a body with base = net that has segments or triangles");
    }
    std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (const NetSpan& span : base.spans) {
        for (std::size_t i = 0; i < span.masses.size(); ++i) {
            const std::uint32_t a = span.masses[i], b = span.masses[(i + 1) % span.masses.size()];
            pairs.insert({std::min(a, b), std::max(a, b)});
        }
    }
    for (const auto& [a, b] : pairs) {
        const double rest = (base.frames[a].translation() - base.frames[b].translation()).norm();
        base.springs.push_back({a, b, rest, stiffness, damping});
    }
}

NetHold net_hold(const Base& base, std::size_t f, std::span<const Vec3> position,
                 const Mat3& before)
{
    const std::span<const std::uint32_t> masses = masses_of(base, f);
    const bool segment = masses.size() == 2;
    const double each = 1 / static_cast<double>(masses.size());
    NetHold hold;
    for (const std::uint32_t m : masses) hold.middle += each * position[m];
    hold.by.assign(masses.size(), Eigen::Matrix<double, 6, 3>::Zero());
    Mat3 A = Mat3::Zero();
    double rest = 0;
    for (const std::uint32_t m : masses) {
        const Vec3 p = drawn_in_frame(base, f, m);
        A += (position[m] - hold.middle) * p.transpose();
        rest += p.squaredNorm();
    }
    hold.turn = before;
    if (!A.allFinite()) return hold;
    const Polar polar = polar_of(A);
    hold.turn = segment ? turned_along(before, drawn_in_frame(base, f, masses[1]),
                                       position[masses[1]] - position[masses[0]])
                        : polar.R;
    const Mat3 Q = undone(polar.U, polar.stretch, rest, segment);
    for (std::size_t i = 0; i < masses.size(); ++i) {
        hold.by[i].topRows<3>() = each * Mat3::Identity();
        hold.by[i].bottomRows<3>() =
            Q * cross_matrix(hold.turn * drawn_in_frame(base, f, masses[i]));
    }
    return hold;
}

void follow_masses(const LayeredBody& body, LayeredState& state)
{
    const Base& base = body.base;
    for (std::size_t f = mass_count(base); f < base.frames.size(); ++f) {
        const Mat3 before = Eigen::Quaterniond(state.rotation[f]).toRotationMatrix();
        const NetHold hold = net_hold(base, f, state.position, before);
        Vec6 twist = Vec6::Zero();
        for (std::size_t i = 0; i < hold.by.size(); ++i) {
            twist += hold.by[i] * state.velocity[masses_of(base, f)[i]];
        }
        state.position[f] = hold.middle;
        state.rotation[f] = Eigen::Quaterniond(hold.turn).normalized().coeffs();
        state.velocity[f] = twist.head<3>();
        state.spin[f] = twist.tail<3>();
    }
}

void stretch_net(const LayeredBody& body, const LayeredState& state, ImplicitLayer& layer,
                 SurfaceSamples& samples)
{
    const std::size_t masses = mass_count(body.base);
    for (std::size_t s = 0; s < layer.skeletons.size(); ++s) {
        const std::uint32_t f = layer.frame[s];
        if (f < masses) continue;
        const Mat3 back = Eigen::Quaterniond(state.rotation[f]).toRotationMatrix().transpose();
        const std::span<const std::uint32_t> on = masses_of(body.base, f);
        Skeleton& now = layer.skeletons[s];
        for (std::size_t i = 0; i < on.size(); ++i) {
            now.points[i] = back * (state.position[on[i]] - state.position[f]);
        }
        StretchedSamples stretched(body.layer.skeletons[s], now, samples);
        for (std::size_t i = samples.first[s]; i < samples.first[s + 1]; ++i) stretched.stretch(i);
    }
}

}  // namespace physics
