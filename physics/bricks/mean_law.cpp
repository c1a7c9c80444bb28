#include "physics/bricks/mean_law.hpp"

#include "geometry/base/no_index.hpp"
#include "physics/bricks/neo_hookean.hpp"

#include <Eigen/LU>

#include <cmath>

namespace physics {
namespace {

using geometry::Mat3;
using geometry::no_index;
using geometry::Vec3;

constexpr std::size_t gradient_numbers = 9, triangle_rows = 45;

// Of corner a along axis j.
double sign_of(std::size_t a, std::size_t j)
{
    return (a >> j & 1) != 0 ? 1 : -1;
}

// Of one lane: its slots stand block_lanes apart.
Mat3 mean_gradient(const std::uint32_t* slots, const double* x, double h)
{
    Mat3 out = Mat3::Zero();
    for (std::size_t a = 0; a < 8; ++a) {
        const Eigen::Map<const Vec3> at(x + 4 * std::size_t{slots[a * block_lanes]});
        for (std::size_t j = 0; j < 3; ++j) {
            out.col(static_cast<Eigen::Index>(j)) += sign_of(a, j) * at;
        }
    }
    return out / (4 * h);
}

// Of the corotated law, by F.
struct Corotated {
    Mat3 r, t;  // R and the stress in its axes, Pa
    double energy = 0;
    Lame material{};

    Corotated(const Mat3& f, const Mat3& rotation, Lame of) : r(rotation), material(of)
    {
        const Mat3 s = r.transpose() * f;
        const Mat3 e = 0.5 * (s + s.transpose()) - Mat3::Identity();
        t = 2 * of.mu * e + of.lambda * e.trace() * Mat3::Identity();
        energy = 0.5 * t.cwiseProduct(e).sum();
    }

    // With the turning of R, `inverse` = (tr(S) I - S)^-1, or 0 for that of a held R.
    Mat9 hessian(const Mat3& f, const Mat3& inverse) const
    {
        Mat9 out;
        const Mat3 s = r.transpose() * f;
        for (Eigen::Index n = 0; n < 9; ++n) {
            Mat3 df = Mat3::Zero();
            df(n % 3, n / 3) = 1;
            const Mat3 dy = r.transpose() * df;
            const Vec3 turn(dy(2, 1) - dy(1, 2), dy(0, 2) - dy(2, 0), dy(1, 0) - dy(0, 1));
            const Vec3 w = inverse * turn;
            Mat3 cross;
            cross << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
            const Mat3 ds = dy - cross * s;
            const Mat3 dt = material.mu * (ds + ds.transpose()) +
                            material.lambda * ds.trace() * Mat3::Identity();
            const Mat3 dp = r * (cross * t + dt);
            out.col(n) = Eigen::Map<const Eigen::Matrix<double, 9, 1>>(dp.data());
        }
        return 0.5 * (out + out.transpose());
    }
};

Mat3 rotation_of(const double* rows)
{
    Mat3 r;
    for (Eigen::Index k = 0; k < 9; ++k) {
        r(k / 3, k % 3) = rows[static_cast<std::size_t>(k) * block_lanes];
    }
    return r;
}

// Of strained_rows, for F in place of C.
Mat3 inverse_of(const double* strained, double h)
{
    constexpr std::size_t first = 21;  // xx xy xz yy yz zz
    constexpr std::size_t at[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    Mat3 out;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            out(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
                4 * h * strained[(first + at[i][j]) * block_lanes];
        }
    }
    return out;
}

// Von Mises, of the stress by the area of now; a cube that has no volume left has that by the area
// at rest.
float von_mises(const Mat3& p, const Mat3& f)
{
    constexpr double least = 0.05;
    const double j = std::abs(f.determinant());
    Mat3 sigma = p * f.transpose();
    if (j > least) sigma /= j;
    sigma.diagonal().array() -= sigma.trace() / 3;
    return static_cast<float>(std::sqrt(1.5 * sigma.squaredNorm()));
}

void add_force(const std::uint32_t* slots, const Mat3& p, double h, double* force)
{
    for (std::size_t a = 0; a < 8; ++a) {
        const Vec3 at(sign_of(a, 0), sign_of(a, 1), sign_of(a, 2));
        Eigen::Map<Vec3>(force + 4 * std::size_t{slots[a * block_lanes]}) -= p * at / (4 * h);
    }
}

template <class T>
void add_difference(const BrickLayout& layout, const T* matrices, const std::vector<double>& edge,
                    T stiffness, std::size_t begin, std::size_t end, const T* p, T* y)
{
    using Row = T[block_lanes];
    for (std::size_t block = begin; block < end; ++block) {
        Row in[gradient_numbers] = {}, out[gradient_numbers] = {};
        const std::uint32_t* from = &layout.gather[block * 8 * block_lanes];
        const std::uint32_t* to = &layout.scatter[block * 8 * block_lanes];
        const T scale = T(1 / (4 * edge[block]));
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t lane = 0; lane < block_lanes; ++lane) {
                const T* at = p + 4 * std::size_t{from[a * block_lanes + lane]};
                for (std::size_t j = 0; j < 3; ++j) {
                    for (std::size_t i = 0; i < 3; ++i) {
                        in[3 * j + i][lane] += T(sign_of(a, j)) * at[i];
                    }
                }
            }
        }
        const T* entry = matrices + block * triangle_rows * block_lanes;
        for (std::size_t i = 0; i < gradient_numbers; ++i) {
            for (std::size_t j = 0; j <= i; ++j, entry += block_lanes) {
                for (std::size_t lane = 0; lane < block_lanes; ++lane) {
                    out[i][lane] += entry[lane] * in[j][lane];
                    if (j < i) out[j][lane] += entry[lane] * in[i][lane];
                }
            }
        }
        const T factor = stiffness * scale * scale;
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t lane = 0; lane < block_lanes; ++lane) {
                T* at = y + 4 * std::size_t{to[a * block_lanes + lane]};
                for (std::size_t i = 0; i < 3; ++i) {
                    T sum = 0;
                    for (std::size_t j = 0; j < 3; ++j) {
                        sum += T(sign_of(a, j)) * out[3 * j + i][lane];
                    }
                    at[i] += factor * sum;
                }
            }
        }
    }
}

}  // namespace

MeanLaw::MeanLaw(const BricksBody& body) : body_(body)
{
    if (!on()) return;
    positive_.high.assign(body.layout.blocks() * triangle_rows * block_lanes, 0);
    positive_.low.assign(positive_.high.size(), 0);
}

void MeanLaw::keep_whole()
{
    if (!on() || !whole_.high.empty()) return;
    whole_ = positive_;
}

void MeanLaw::store(std::size_t lane, const Mat9& matrix, Matrices& to) const
{
    std::size_t at = lane / block_lanes * triangle_rows * block_lanes + lane % block_lanes;
    for (Eigen::Index k = 0; k < 9; ++k) {
        for (Eigen::Index l = 0; l <= k; ++l, at += block_lanes) {
            to.high[at] = matrix(k, l);
            to.low[at] = static_cast<float>(matrix(k, l));
        }
    }
}

double MeanLaw::evaluate(const Corotation& at, std::size_t begin, std::size_t end, const double* x)
{
    double sum = 0;
    for (std::size_t i = begin * block_lanes; i < end * block_lanes; ++i) {
        if (body_.layout.cube[i] == no_index) continue;
        const std::size_t block = i / block_lanes, lane = i % block_lanes;
        const double* material = &body_.material[block * 2 * block_lanes + lane];
        const Lame lame{material[block_lanes], material[0]};
        // stiffness is share mu h / 16
        const double share = body_.stiffness[block * 3 * block_lanes + lane] * 16 / at.h / lame.mu;
        const double volume = share * at.h * at.h * at.h;
        const Mat3 f = mean_gradient(&body_.layout.gather[block * 8 * block_lanes + lane], x, at.h);
        const Mat3 r = rotation_of(at.rotation + block * 9 * block_lanes + lane);
        const NeoHookean law(lame);
        const Corotated old(f, r, lame);
        const double more = volume * (law.energy(f) - old.energy);
        sum += more;
        if (at.energy) at.energy[i] += static_cast<float>(more);
        if (!at.force && !at.stress) continue;
        const Mat3 p = law.stress(f);
        if (at.stress) at.stress[i] = von_mises(p, f);
        if (!at.force) continue;
        add_force(&body_.layout.scatter[block * 8 * block_lanes + lane],
                  volume * (p - old.r * old.t), at.h, at.force);
        const Corotated unstrained(r, r, lame);
        store(i, volume * (law.hessian(f, true) - unstrained.hessian(r, Mat3::Zero())), positive_);
        if (!at.strained) continue;
        const Mat3 inverse =
            inverse_of(at.strained + block * strained_rows * block_lanes + lane, at.h);
        store(i, volume * (law.hessian(f, false) - old.hessian(f, inverse)), whole_);
    }
    return sum;
}

void MeanLaw::add_times(Part part, float stiffness, std::size_t begin, std::size_t end,
                        const float* p, float* y) const
{
    add_difference(body_.layout, of(part).low.data(), body_.block_edge, stiffness, begin, end, p,
                   y);
}

void MeanLaw::add_times(Part part, double stiffness, std::size_t begin, std::size_t end,
                        const double* p, double* y) const
{
    add_difference(body_.layout, of(part).high.data(), body_.block_edge, stiffness, begin, end, p,
                   y);
}

void MeanLaw::add_diagonal(Part part, double stiffness, double* d) const
{
    for (std::size_t i = 0; i < body_.layout.cube.size(); ++i) {
        if (body_.layout.cube[i] == no_index) continue;
        const std::size_t block = i / block_lanes, lane = i % block_lanes;
        const double* entry = &of(part).high[block * triangle_rows * block_lanes + lane];
        double squares = 0;  // Frobenius' norm is at least the largest eigenvalue
        for (std::size_t k = 0; k < gradient_numbers; ++k) {
            for (std::size_t l = 0; l <= k; ++l, entry += block_lanes) {
                squares += (l < k ? 2 : 1) * *entry * *entry;
            }
        }
        const double h = body_.block_edge[block];
        // |C / (4 h)|^2 is at most |u|^2 / (2 h^2).
        const double most = std::sqrt(squares) / (2 * h * h) / body_.largest_eigenvalue;
        for (std::size_t a = 0; a < 8; ++a) {
            const std::size_t at = body_.layout.gather[(block * 8 + a) * block_lanes + lane];
            for (std::size_t axis = 0; axis < 3; ++axis) d[4 * at + axis] += stiffness * most;
        }
    }
}

void MeanLaw::add_matrices(Part part, double stiffness, std::vector<BrickMatrix>& out) const
{
    for (std::size_t i = 0; i < body_.layout.cube.size(); ++i) {
        if (body_.layout.cube[i] == no_index) continue;
        const std::size_t block = i / block_lanes, lane = i % block_lanes;
        const double* entry = &of(part).high[block * triangle_rows * block_lanes + lane];
        Mat9 m;
        for (Eigen::Index k = 0; k < 9; ++k) {
            for (Eigen::Index l = 0; l <= k; ++l, entry += block_lanes) m(k, l) = m(l, k) = *entry;
        }
        Eigen::Matrix<double, 9, 24> gradient = Eigen::Matrix<double, 9, 24>::Zero();
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t j = 0; j < 3; ++j) {
                for (std::size_t k = 0; k < 3; ++k) {
                    gradient(static_cast<Eigen::Index>(3 * j + k),
                             static_cast<Eigen::Index>(3 * a + k)) =
                        sign_of(a, j) / (4 * body_.block_edge[block]);
                }
            }
        }
        out[body_.layout.cube[i]] += stiffness * gradient.transpose() * m * gradient;
    }
}

}  // namespace physics
