#include "physics/modal/calibrate.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/base/union_find.hpp"
#include "geometry/cubes/coarser_cubes.hpp"
#include "geometry/cubes/trilinear.hpp"
#include "physics/body/stiffness.hpp"
#include "physics/bricks/direct_factor.hpp"
#include "physics/modal/fine_motions.hpp"
#include "physics/modal/modes.hpp"
#include "physics/state/cube_mass.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <span>
#include <stdexcept>

namespace physics {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using geometry::Cubes;
using geometry::no_index;
using geometry::Vec3;
using geometry::Vec3i;

// Fuller cubes keep their own stiffness.
constexpr double full = 0.999;

// A body that hangs together, and which of all cubes its own are.
struct Body {
    Cubes coarse, fine;
    std::vector<std::uint32_t> cube;       // of `coarse`, among all
    std::vector<std::uint32_t> first, in;  // the fine cubes of each: in[first[c]] ..
    int ratio = 4;

    std::span<const std::uint32_t> fine_of(std::size_t c) const
    {
        return std::span(in).subspan(first[c], first[c + 1] - first[c]);
    }
    Vec3i place_of(std::size_t c, std::uint32_t f) const
    {
        return fine.cell[f] - ratio * coarse.cell[c];
    }
};

bool is_partly(const Body& body, std::size_t c)
{
    return body.coarse.fill[c] < full && !body.fine_of(c).empty();
}

// The cube of `coarse` that each fine one lies in, or no_index: a face that lies on a border of
// cubes but for rounding may have fine cubes on either side.
std::vector<std::uint32_t> owners(const Cubes& coarse, const FineCubes& fine)
{
    std::vector<std::uint32_t> out = geometry::coarser_cubes(coarse, fine.cubes, fine.ratio);
    double outside = 0;
    for (std::size_t f = 0; f < out.size(); ++f) {
        if (out[f] == no_index) outside += fine.cubes.mass[f];
    }
    if (!(outside < 0.01 * total_mass(fine.cubes))) {
        throw std::invalid_argument(
            "expected the fine cubes in cubes of the model, found more than "
            "a hundredth of their mass outside");
    }
    return out;
}

std::vector<Body> bodies_of(const Cubes& coarse, const FineCubes& fine)
{
    const std::vector<std::uint32_t> owner = owners(coarse, fine);
    geometry::Sets sets(coarse.corner_count());
    for (const auto& corners : coarse.corners) {
        for (const auto k : corners) sets.join(k, corners[0]);
    }
    std::map<std::uint32_t, std::vector<std::uint32_t>> cubes;
    for (std::uint32_t c = 0; c < coarse.count(); ++c) {
        cubes[sets.root(coarse.corners[c][0])].push_back(c);
    }
    std::vector<Body> out;
    for (auto& [root, of] : cubes) {
        geometry::stop_if_asked();
        Body& body = out.emplace_back();
        body.ratio = fine.ratio;
        std::vector<std::uint8_t> keep(coarse.count(), 0);
        for (const auto c : of) keep[c] = 1;
        body.coarse = kept(coarse, keep);
        std::vector<std::uint8_t> keep_fine(owner.size());
        std::vector<std::uint32_t> own;
        std::vector<std::uint32_t> number(coarse.count(), 0);
        for (std::uint32_t i = 0; i < of.size(); ++i) number[of[i]] = i;
        for (std::size_t f = 0; f < owner.size(); ++f) {
            keep_fine[f] = owner[f] == no_index ? 0 : keep[owner[f]];
            if (keep_fine[f] != 0) own.push_back(number[owner[f]]);
        }
        body.fine = kept(fine.cubes, keep_fine);
        body.cube = std::move(of);
        body.first.assign(body.cube.size() + 1, 0);
        for (const auto c : own) ++body.first[c + 1];
        std::partial_sum(body.first.begin(), body.first.end(), body.first.begin());
        body.in.resize(own.size());
        std::vector<std::uint32_t> next(body.first.begin(), body.first.end() - 1);
        for (std::uint32_t f = 0; f < own.size(); ++f) body.in[next[own[f]]++] = f;
    }
    return out;
}

// How the corners of the fine cube at a place follow a cube's corners: 24 x 24.
class Places {
public:
    explicit Places(int ratio) : ratio_(ratio)
    {
        for (int z = 0; z <= ratio; ++z) {
            for (int y = 0; y <= ratio; ++y) {
                for (int x = 0; x <= ratio; ++x) {
                    weights_.push_back(geometry::trilinear_weights(Vec3(x, y, z) / ratio));
                }
            }
        }
    }

    const std::array<double, 8>& weights(const Vec3i& place, unsigned a) const
    {
        const int edge = ratio_ + 1;
        const Vec3i at = place + Vec3i(a & 1, a >> 1 & 1, a >> 2 & 1);
        return weights_[std::size_t((at.z() * edge + at.y()) * edge + at.x())];
    }

    BrickMatrix motion(const Vec3i& place) const
    {
        BrickMatrix n = BrickMatrix::Zero();
        for (unsigned a = 0; a < 8; ++a) {
            const auto& w = weights(place, a);
            for (unsigned b = 0; b < 8; ++b) {
                for (unsigned i = 0; i < 3; ++i) n(3 * a + i, 3 * b + i) = w[b];
            }
        }
        return n;
    }

private:
    int ratio_;
    std::vector<std::array<double, 8>> weights_;
};

using Fields = Eigen::Matrix<double, 24, Eigen::Dynamic>;

// Rows of the corners of a cube.
Fields at_corners(const MatrixXd& field, const std::array<std::uint32_t, 8>& corners)
{
    Fields out(24, field.cols());
    for (std::size_t a = 0; a < 8; ++a) {
        out.middleRows<3>(Index(3 * a)) = field.middleRows<3>(Index(3 * std::size_t{corners[a]}));
    }
    return out;
}

// q of each motion: 3 K x m, of the coarse corners.
MatrixXd followed(const Body& body, const Places& places, const MatrixXd& motions)
{
    constexpr double smooth = 1e-3;
    const Cubes& coarse = body.coarse;
    const BrickMatrix extend = smooth * brick_stiffness(1, lame(1, 0.3), BrickElement::trilinear);
    std::vector<BrickMatrix> matrices(coarse.count(), extend);
    MatrixXd sides = MatrixXd::Zero(Index(3 * coarse.corner_count()), motions.cols());
    const double volume = 1.0 / (body.ratio * body.ratio * body.ratio);
    for (std::size_t c = 0; c < coarse.count(); ++c) {
        for (const auto f : body.fine_of(c)) {
            const Vec3i place = body.place_of(c, f);
            const double share = volume * body.fine.fill[f] / 8;
            for (unsigned a = 0; a < 8; ++a) {
                const auto& w = places.weights(place, a);
                const auto moved =
                    motions.middleRows<3>(Index(3 * std::size_t{body.fine.corners[f][a]}));
                for (unsigned i = 0; i < 8; ++i) {
                    sides.middleRows<3>(Index(3 * std::size_t{coarse.corners[c][i]})) +=
                        share * w[i] * moved;
                    for (unsigned j = 0; j < 8; ++j) {
                        for (unsigned k = 0; k < 3; ++k) {
                            matrices[c](3 * i + k, 3 * j + k) += share * w[i] * w[j];
                        }
                    }
                }
            }
        }
    }
    const std::size_t n = coarse.corner_count();
    std::vector<std::uint32_t> slot(n);
    std::iota(slot.begin(), slot.end(), 0u);
    auto tree = std::make_shared<const Dissection>(
        dissect(coarse, {}, std::numeric_limits<double>::infinity()));
    const std::vector<double> nothing(4 * n, 0.0);
    auto factor = DirectFactor::make(std::move(tree), matrices, nothing, slot);
    if (!factor) throw std::logic_error("least squares without a solution");
    std::vector<double> b(4 * n), x(4 * n);
    MatrixXd out(sides.rows(), sides.cols());
    for (Index m = 0; m < sides.cols(); ++m) {
        for (std::size_t k = 0; k < n; ++k) {
            for (std::size_t i = 0; i < 3; ++i) b[4 * k + i] = sides(Index(3 * k + i), m);
        }
        factor->solve(b.data(), x.data());
        for (std::size_t k = 0; k < n; ++k) {
            for (std::size_t i = 0; i < 3; ++i) out(Index(3 * k + i), m) = x[4 * k + i];
        }
    }
    return out;
}

// Stiffness of the fine cubes: K for E = 1 and a full cube by Poisson's ratio.
class FineStiffness {
public:
    explicit FineStiffness(const Cubes& fine) : fine_(fine)
    {
        const BrickElement element = element_of(fine, BrickElement::incompatible);
        for (const double poisson : fine.poisson) {
            if (of_.count(poisson) > 0) continue;
            of_.emplace(poisson, brick_stiffness(fine.size, lame(1, poisson), element));
        }
    }
    const BrickMatrix& of(std::uint32_t f) const { return of_.at(fine_.poisson[f]); }
    double factor(std::uint32_t f) const
    {
        return fine_.young[f] * stiffness_share(fine_, f, Weighting::filled);
    }

private:
    const Cubes& fine_;
    std::map<double, BrickMatrix> of_;
};

// K, E and the mass matrix of one cube.
struct Energies {
    BrickMatrix quadrature = BrickMatrix::Zero();
    MatrixXd fine;
    CubeMass mass{};
};

// Adds what a fine cube of `mass` at a place adds to the mass matrix: 2 x 2 x 2 Gauss points.
void add_mass(const Vec3i& place, int ratio, double mass, CubeMass& sum)
{
    for (unsigned point = 0; point < 8; ++point) {
        Vec3 at = place.cast<double>();
        for (unsigned i = 0; i < 3; ++i) {
            at[i] += 0.5 + (point >> i & 1 ? 0.5 : -0.5) / std::sqrt(3.0);
        }
        const auto w = geometry::trilinear_weights(at / ratio);
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t b = 0; b < 8; ++b) sum[a][b] += mass / 8 * w[a] * w[b];
        }
    }
}

Energies energies_of(const Body& body, const Places& places, const FineStiffness& stiffness,
                     const MatrixXd& motions, std::size_t c)
{
    Energies out;
    out.fine = MatrixXd::Zero(motions.cols(), motions.cols());
    for (const auto f : body.fine_of(c)) {
        const BrickMatrix n = places.motion(body.place_of(c, f));
        const double factor = stiffness.factor(f);
        const BrickMatrix& k = stiffness.of(f);
        out.quadrature += factor * (n.transpose() * (k * n));
        const Fields moved = at_corners(motions, body.fine.corners[f]);
        add_mass(body.place_of(c, f), body.ratio, body.fine.mass[f], out.mass);
        out.fine.noalias() += factor * (moved.transpose() * (k * moved));
    }
    return out;
}

// K' of a cube, Q its corners' motions.
BrickMatrix with_energy(const BrickMatrix& k, const MatrixXd& energy, const Fields& q)
{
    constexpr double least = 1e-3;  // of the largest: other motions are all but the same as these
    const MatrixXd in_k = q.transpose() * (k * q);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(in_k);
    const auto& value = eigen.eigenvalues();
    Index from = 0;
    while (from < value.size() && !(value[from] > least * value[value.size() - 1])) ++from;
    const Index rank = value.size() - from;
    if (rank == 0) return k;
    const MatrixXd t = eigen.eigenvectors().rightCols(rank) *
                       value.tail(rank).cwiseSqrt().cwiseInverse().asDiagonal();
    const Eigen::Matrix<double, 24, Eigen::Dynamic> y = k * (q * t);
    const MatrixXd inner = t.transpose() * (energy * t);
    return k + y * (inner - MatrixXd::Identity(rank, rank)) * y.transpose();
}

// For 1 kg, with a little of a whole cube's, so that no corner of a sliver is without mass.
std::array<float, 36> mass_of(const CubeMass& sum)
{
    constexpr double whole = 1e-3;
    const CubeMass usual = cube_mass_matrix();
    double total = 0;
    for (const auto& row : sum) total = std::accumulate(row.begin(), row.end(), total);
    std::array<float, 36> out{};
    std::size_t at = 0;
    for (std::size_t a = 0; a < 8; ++a) {
        for (std::size_t b = 0; b <= a; ++b) {
            const double own = total > 0 ? sum[a][b] / total : usual[a][b];
            out[at++] = static_cast<float>((1 - whole) * own + whole * usual[a][b]);
        }
    }
    return out;
}

// A partly filled cube: its K and K', with their floors, for E = 1 and a cube of 1 m, its mass, and
// its share of the energy of each motion.
struct OwnCube {
    std::uint32_t cube = 0;
    BrickMatrix usual = BrickMatrix::Zero(), own = BrickMatrix::Zero();
    std::array<float, 36> mass{};
    Eigen::VectorXd energy{};
};

std::vector<OwnCube> own_cubes(const Body& body, const FineMotions& motions)
{
    std::vector<OwnCube> out;
    for (std::uint32_t c = 0; c < body.cube.size(); ++c) {
        if (is_partly(body, c)) out.push_back({c});
    }
    const Places places(body.ratio);
    const MatrixXd q = followed(body, places, motions.of);
    const FineStiffness stiffness(body.fine);
    geometry::parallel_for(out.size(), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            geometry::stop_if_asked();
            const std::size_t c = out[i].cube;
            const Energies of = energies_of(body, places, stiffness, motions.of, c);
            // A little of the whole cube's, so that no corner of a sliver is without stiffness.
            constexpr double floor = 1e-4;
            const double young = body.coarse.young[c], edge = body.coarse.size;
            const BrickMatrix least = floor * body.coarse.fill[c] *
                                      brick_stiffness(edge, lame(young, body.coarse.poisson[c]),
                                                      BrickElement::incompatible);
            const BrickMatrix k = of.quadrature + least;
            out[i].usual = (least + k) / (young * edge);
            out[i].own = (least + with_energy(k, of.fine, at_corners(q, body.coarse.corners[c]))) /
                         (young * edge);
            out[i].mass = mass_of(of.mass);
            out[i].energy = of.fine.diagonal();
        }
    });
    return out;
}

// Gives the cubes of a body their elements: K' and a share of K.
void set_elements(const std::vector<OwnCube>& cubes, double share, Cubes& of)
{
    of.elements.clear();
    for (const OwnCube& c : cubes) {
        of.own[c.cube] = static_cast<std::uint32_t>(of.elements.size());
        of.elements.push_back({lower_triangle((1 - share) * c.own + share * c.usual), c.mass});
    }
}

// What K' is mixed with, and by how much each of the lowest modes is then too low: the logarithm of
// the ratio of the squares of frequencies.
struct Mixture {
    double share = 0;
    Eigen::VectorXd low;
};

// With K' alone the lowest modes of a body are below those of its fine cubes, as K' lets a cube
// follow other motions than phi more cheaply, and some may be much lower than others; a share of K
// makes those dear. Of a few shares the one with which the first six frequencies are off by the
// most equal ratio.
Mixture best_mixture(const std::vector<OwnCube>& own, const std::vector<double>& fine, Cubes& cubes)
{
    constexpr std::size_t few = 6;
    ModeSettings settings;
    settings.count = static_cast<int>(std::min(few, fine.size()));
    Mixture best;
    if (settings.count == 0 || cubes.count() < few) return best;
    double least = std::numeric_limits<double>::infinity();
    for (const double share : {0.0, 0.01, 0.02, 0.05, 0.1, 0.2}) {
        set_elements(own, share, cubes);
        const std::vector<double> coarse = lowest_modes(cubes, {}, settings).omega_sq;
        if (coarse.empty()) continue;
        Eigen::VectorXd low(Index(coarse.size()));
        for (std::size_t k = 0; k < coarse.size(); ++k)
            low[Index(k)] = std::log(fine[k] / coarse[k]);
        const double spread = (low.array() - low.mean()).square().sum() / double(low.size());
        if (!(spread < least)) continue;
        least = spread;
        best = {share, std::move(low)};
    }
    return best;
}

// Makes each cube stiffer by what the modes that it takes part in are too low by. A trunk that
// hardly moves while its leaves flutter keeps its own stiffness.
void stiffen(const std::vector<OwnCube>& own, const Eigen::VectorXd& low, Cubes& cubes)
{
    constexpr double most = 1.5;
    constexpr double little = 0.1;  // of a cube's mean share of the energy
    const Index few = low.size();
    if (few == 0) return;
    for (const OwnCube& c : own) {
        const auto energy = c.energy.head(few);
        const double sum = energy.sum(), part = sum * double(own.size()) / double(few) / little;
        if (!(sum > 0)) continue;
        const double sure = part * part / (1 + part * part);
        const double factor = std::clamp(std::exp(sure * energy.dot(low) / sum), 1 / most, most);
        for (float& k : cubes.elements[cubes.own[c.cube]].stiffness) k = float(factor * double(k));
    }
}

// The mass of each cube by its fine ones, of partly filled ones the fill too: cubes lighter than
// any may be were made heavier at the cost of all others.
void take_masses(Body& body, double share)
{
    for (std::size_t c = 0; c < body.cube.size(); ++c) {
        if (body.fine_of(c).empty()) continue;
        double mass = 0, fill = 0;
        for (const auto f : body.fine_of(c)) {
            mass += body.fine.mass[f];
            fill += body.fine.fill[f] / std::pow(body.ratio, 3);
        }
        body.coarse.mass[c] = share * mass;
        if (is_partly(body, c)) body.coarse.fill[c] = std::min(fill, std::nextafter(full, 0));
    }
}

// The masses of all bodies, together `total`.
void give_masses(std::span<const Body> bodies, double total, Cubes& all)
{
    double sum = 0;
    for (const Body& body : bodies) sum += total_mass(body.coarse);
    for (const Body& body : bodies) {
        for (std::size_t c = 0; c < body.cube.size(); ++c) {
            all.mass[body.cube[c]] = total / sum * body.coarse.mass[c];
        }
    }
}

void calibrate(Body& body, const CalibrationSettings& settings, Cubes& all, Report& report)
{
    std::size_t first = 0;
    while (first < body.cube.size() && !is_partly(body, first)) ++first;
    if (first == body.cube.size()) return;
    FineMotions motions = fine_motions(body.fine, settings.modes, report);
    if (motions.of.cols() == 0) {
        for (std::size_t c = 0; c < body.cube.size(); ++c) {
            body.coarse.mass[c] = all.mass[body.cube[c]];  // as its fill
        }
        return;
    }
    const std::vector<double> lowest(motions.energy.begin(),
                                     motions.energy.begin() + std::ptrdiff_t(motions.modes));
    for (Index m = 0; m < motions.of.cols(); ++m) {
        motions.of.col(m) /= std::sqrt(motions.energy[std::size_t(m)]);
    }
    const std::vector<OwnCube> own = own_cubes(body, motions);
    const Mixture mixture = best_mixture(own, lowest, body.coarse);
    set_elements(own, mixture.share, body.coarse);
    stiffen(own, mixture.low, body.coarse);
    for (const OwnCube& c : own) {
        all.own[body.cube[c.cube]] = static_cast<std::uint32_t>(all.elements.size());
        all.elements.push_back(body.coarse.elements[body.coarse.own[c.cube]]);
        all.fill[body.cube[c.cube]] = body.coarse.fill[c.cube];
    }
}

}  // namespace

Cubes calibrated(const Cubes& coarse, const FineCubes& fine, const CalibrationSettings& settings,
                 Report& report)
{
    Cubes out = coarse;
    out.own.assign(coarse.count(), no_index);
    out.elements.clear();
    report.converged = true;
    const double total = total_mass(coarse);
    std::vector<Body> bodies = bodies_of(coarse, fine);
    for (Body& body : bodies) {
        take_masses(body, total / total_mass(fine.cubes));
        body.coarse.own.assign(body.coarse.count(), no_index);
        calibrate(body, settings, out, report);
    }
    if (!out.elements.empty()) give_masses(bodies, total, out);
    if (out.elements.empty()) out.own.clear();
    return out;
}

}  // namespace physics
