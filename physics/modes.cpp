#include "physics/modes.hpp"

#include "geometry/plane.hpp"
#include "geometry/random.hpp"
#include "geometry/sets.hpp"

#include <Eigen/Sparse>
#include <Spectra/SymEigsSolver.h>
#include <fmt/format.h>

#include <map>
#include <numeric>

namespace physics {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using geometry::Cubes;
using SparseMatrix = Eigen::SparseMatrix<double>;

constexpr std::uint32_t none = ~0u;

// The free corners in the order in which they are eliminated.
struct Unknowns {
    std::vector<std::uint32_t> corner;  // n, of the cubes
    std::vector<std::uint32_t> at;      // K, into corner, or none where pinned
    std::size_t count() const { return corner.size(); }
};

// Orders corners for elimination so that factors stay sparse: George. Nested dissection of a
// regular finite element mesh. SIAM J. Numer. Anal. 1973. A layer of corners one lattice step thick
// parts the rest in two halves that share no cube, and comes last.
void dissect(const Cubes& cubes, std::span<std::uint32_t> set)
{
    if (set.size() <= 16) return;
    geometry::Vec3i lo = cubes.corner[set[0]], hi = lo;
    for (const auto i : set) {
        lo = lo.cwiseMin(cubes.corner[i]);
        hi = hi.cwiseMax(cubes.corner[i]);
    }
    int axis = 0;
    (hi - lo).maxCoeff(&axis);
    if (hi[axis] == lo[axis]) return;  // copies at one place
    const auto coordinate = [&](std::uint32_t i) { return cubes.corner[i][axis]; };
    const auto middle = set.begin() + std::ptrdiff_t(set.size() / 2);
    std::nth_element(set.begin(), middle, set.end(), [&](auto a, auto b) {
        return std::pair(coordinate(a), a) < std::pair(coordinate(b), b);
    });
    const int cut = coordinate(*middle);
    const auto below =
        std::stable_partition(set.begin(), set.end(), [&](auto i) { return coordinate(i) < cut; });
    const auto above =
        std::stable_partition(below, set.end(), [&](auto i) { return coordinate(i) > cut; });
    const auto part = [&](auto from, auto to) {
        return set.subspan(std::size_t(from - set.begin()), std::size_t(to - from));
    };
    dissect(cubes, part(set.begin(), below));
    dissect(cubes, part(below, above));
    // The layer itself is a plane: dissect it as one, as long as it is not all there is.
    if (above != set.begin()) dissect(cubes, part(above, set.end()));
}

Unknowns order_unknowns(const Cubes& cubes, const std::vector<std::uint32_t>& pinned)
{
    Unknowns u;
    u.at.assign(cubes.corner_count(), 0);
    for (const auto p : pinned) {
        if (p >= cubes.corner_count()) {
            throw std::invalid_argument(fmt::format(
                "expected pinned corners below {}, found {}: were the pins made from other cubes?",
                cubes.corner_count(), p));
        }
        u.at[p] = none;
    }
    for (std::uint32_t i = 0; i < u.at.size(); ++i) {
        if (u.at[i] != none) u.corner.push_back(i);
    }
    dissect(cubes, u.corner);
    for (std::uint32_t i = 0; i < u.count(); ++i) u.at[u.corner[i]] = i;
    return u;
}

// Stiffness matrices of the materials that occur.
class Elements {
public:
    Elements(const Cubes& cubes, const ModeSettings& settings) : cubes_(cubes), settings_(settings)
    {}

    // Of cube c, and the factor on it.
    std::pair<const BrickMatrix&, double> of(std::size_t c)
    {
        // K is linear in E: one matrix for each Poisson ratio.
        auto& k = by_poisson_[cubes_.poisson[c]];
        if (!k) {
            k = std::make_unique<BrickMatrix>(
                brick_stiffness(cubes_.size, lame(1, cubes_.poisson[c]), settings_.element));
        }
        return {*k, cubes_.young[c] * stiffness_share(cubes_, c, settings_.weighting)};
    }

private:
    const Cubes& cubes_;
    const ModeSettings& settings_;
    std::map<double, std::unique_ptr<BrickMatrix>> by_poisson_;
};

// The lower triangle of M^-1/2 K M^-1/2, 3n x 3n.
SparseMatrix assemble(const Cubes& cubes, const Unknowns& unknowns, const VectorXd& root_mass,
                      const ModeSettings& settings)
{
    const auto n = unknowns.count();
    // Which pairs of corners share a cube: column in the high half, row in the low.
    std::vector<std::uint64_t> pairs;
    pairs.reserve(36 * cubes.count());
    for (const auto& corners : cubes.corners) {
        for (const auto a : corners) {
            for (const auto b : corners) {
                const std::uint64_t row = unknowns.at[a], column = unknowns.at[b];
                if (row != none && column != none && row >= column) {
                    pairs.push_back(column << 32 | row);
                }
            }
        }
    }
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    std::vector<std::size_t> first(n + 1, 0);
    for (const auto pair : pairs) ++first[(pair >> 32) + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());

    std::vector<geometry::Mat3> blocks(pairs.size(), geometry::Mat3::Zero());
    Elements elements(cubes, settings);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const auto [k, factor] = elements.of(c);
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t b = 0; b < 8; ++b) {
                const std::uint64_t row = unknowns.at[cubes.corners[c][a]];
                const std::uint64_t column = unknowns.at[cubes.corners[c][b]];
                if (row == none || column == none || row < column) continue;
                const auto begin = pairs.begin() + std::ptrdiff_t(first[column]);
                const auto end = pairs.begin() + std::ptrdiff_t(first[column + 1]);
                const auto found = std::lower_bound(begin, end, column << 32 | row);
                blocks[std::size_t(found - pairs.begin())] +=
                    factor * k.block<3, 3>(Index(3 * a), Index(3 * b));
            }
        }
    }

    SparseMatrix d(Index(3 * n), Index(3 * n));
    std::vector<int> entries(3 * n);
    for (std::size_t column = 0; column < n; ++column) {
        for (std::size_t j = 0; j < 3; ++j) {
            entries[3 * column + j] = int(3 * (first[column + 1] - first[column]) - j);
        }
    }
    d.reserve(entries);
    for (std::size_t column = 0; column < n; ++column) {
        for (Index j = 0; j < 3; ++j) {
            const Index to = Index(3 * column) + j;
            for (std::size_t p = first[column]; p < first[column + 1]; ++p) {
                const auto row = pairs[p] & 0xffffffffu;
                for (Index i = 0; i < 3; ++i) {
                    const Index from = Index(3 * row) + i;
                    if (from >= to) {
                        d.insert(from, to) = blocks[p](i, j) / (root_mass[from] * root_mass[to]);
                    }
                }
            }
        }
    }
    d.makeCompressed();
    return d;
}

// The rigid motions that pins leave to one connected piece: orthonormal columns over its unknowns.
struct RigidMotions {
    std::vector<std::uint32_t> unknown;  // corners of the piece, into Unknowns::corner
    MatrixXd motion;                     // 3 |unknown| x (0..6), in sqrt(mass) * displacement
};

std::vector<RigidMotions> rigid_motions(const Cubes& cubes, const Unknowns& unknowns,
                                        const VectorXd& root_mass)
{
    geometry::Sets sets(cubes.corner_count());
    for (const auto& corners : cubes.corners) {
        for (const auto a : corners) sets.join(a, corners[0]);
    }
    std::map<std::uint32_t, std::vector<std::uint32_t>> pieces;  // corners by smallest corner
    for (std::uint32_t i = 0; i < cubes.corner_count(); ++i) pieces[sets.root(i)].push_back(i);

    std::vector<RigidMotions> all;
    for (const auto& [smallest, corners] : pieces) {
        RigidMotions piece;
        Vec3 centre = Vec3::Zero();
        double reach = 0;
        for (const auto i : corners) centre += cubes.corner_position(i) / double(corners.size());
        for (const auto i : corners) {
            reach = std::max(reach, (cubes.corner_position(i) - centre).norm());
            if (unknowns.at[i] != none) piece.unknown.push_back(unknowns.at[i]);
        }
        // Displacement at a corner by the six unit motions, rotations about the centre.
        const auto motion_at = [&](std::uint32_t corner) {
            const Vec3 r = (cubes.corner_position(corner) - centre) / reach;
            Eigen::Matrix<double, 3, 6> m;
            m.leftCols<3>().setIdentity();
            for (int axis = 0; axis < 3; ++axis) m.col(3 + axis) = Vec3::Unit(axis).cross(r);
            return m;
        };
        MatrixXd held = MatrixXd::Zero(6, 6);  // of any size, to share the solver below
        for (const auto i : corners) {
            if (unknowns.at[i] == none) held += motion_at(i).transpose() * motion_at(i);
        }
        const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(held);
        const double h_over_reach = cubes.size / reach;
        Index free = 0;  // motions that leave every pin where it is
        while (free < 6 && eigen.eigenvalues()[free] < 1e-9 * h_over_reach * h_over_reach) ++free;
        if (free == 0 || piece.unknown.empty()) continue;
        MatrixXd m(Index(3 * piece.unknown.size()), free);
        for (std::size_t i = 0; i < piece.unknown.size(); ++i) {
            m.middleRows<3>(Index(3 * i)) = root_mass[Index(3 * piece.unknown[i])] *
                                            motion_at(unknowns.corner[piece.unknown[i]]) *
                                            eigen.eigenvectors().leftCols(free);
        }
        piece.motion =
            Eigen::HouseholderQR<MatrixXd>(m).householderQ() * MatrixXd::Identity(m.rows(), free);
        all.push_back(std::move(piece));
    }
    return all;
}

// x without its parts along `piece`'s motions.
void take_out(const RigidMotions& piece, Eigen::Ref<VectorXd> x)
{
    VectorXd part(piece.motion.rows());
    for (std::size_t i = 0; i < piece.unknown.size(); ++i) {
        part.segment<3>(Index(3 * i)) = x.segment<3>(Index(3 * piece.unknown[i]));
    }
    part = piece.motion * (piece.motion.transpose() * part);
    for (std::size_t i = 0; i < piece.unknown.size(); ++i) {
        x.segment<3>(Index(3 * piece.unknown[i])) -= part.segment<3>(Index(3 * i));
    }
}

// (D - shift I)^-1 on what is orthogonal to the rigid motions and to the modes found so far: the
// lowest modes of D become its largest eigenvalues.
class ShiftInverse {
public:
    using Scalar = double;

    ShiftInverse(const SparseMatrix& d, double shift, const std::vector<RigidMotions>& rigid)
        : rigid_(rigid), size_(d.rows())
    {
        factor_.setShift(-shift);
        factor_.compute(d);
    }
    bool factored() const { return factor_.info() == Eigen::Success; }
    Index rows() const { return size_; }
    Index cols() const { return size_; }
    void perform_op(const double* from, double* to) const
    {
        const Eigen::Map<const VectorXd> x(from, size_);
        Eigen::Map<VectorXd> y(to, size_);
        VectorXd work = x;
        project(work);
        y = factor_.solve(work);
        project(y);
        ++solves;
    }
    void project(Eigen::Ref<VectorXd> x) const
    {
        for (const auto& piece : rigid_) take_out(piece, x);
        if (found.cols() > 0) x -= found * (found.transpose() * x);
    }

    MatrixXd found;  // orthonormal modes that are known already
    mutable int solves = 0;

private:
    // Elimination in the order of dissect(): no other is needed.
    Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>> factor_;
    const std::vector<RigidMotions>& rigid_;
    Index size_;
};

struct Eigenpairs {
    std::vector<double> value;  // ascending
    MatrixXd vector;            // orthonormal columns
    bool converged = true;
    int solves = 0;
};

void sort_pairs(Eigenpairs& pairs)
{
    std::vector<Index> order(pairs.value.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) {
        return pairs.value[std::size_t(a)] < pairs.value[std::size_t(b)];
    });
    Eigenpairs sorted = pairs;
    for (std::size_t i = 0; i < order.size(); ++i) {
        sorted.value[i] = pairs.value[std::size_t(order[i])];
        sorted.vector.col(Index(i)) = pairs.vector.col(order[i]);
    }
    pairs = std::move(sorted);
}

// All of them, for small problems.
Eigenpairs dense_eigenpairs(const SparseMatrix& d, const std::vector<RigidMotions>& rigid,
                            Index count)
{
    MatrixXd full = MatrixXd(d).selfadjointView<Eigen::Lower>();
    // Rigid motions are moved out of the way, above everything else.
    const double top = 2 * full.cwiseAbs().rowwise().sum().maxCoeff();
    for (const auto& piece : rigid) {
        for (Index m = 0; m < piece.motion.cols(); ++m) {
            VectorXd motion = VectorXd::Zero(d.rows());
            for (std::size_t i = 0; i < piece.unknown.size(); ++i) {
                motion.segment<3>(Index(3 * piece.unknown[i])) =
                    piece.motion.col(m).segment<3>(Index(3 * i));
            }
            full += top * motion * motion.transpose();
        }
    }
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(full);
    Eigenpairs pairs;
    pairs.vector = eigen.eigenvectors().leftCols(count);
    pairs.value.assign(eigen.eigenvalues().data(), eigen.eigenvalues().data() + count);
    return pairs;
}

// The lowest by restarted Lanczos. One start vector can miss copies of a repeated eigenvalue (the
// two bending directions of a square beam), so the search goes on, orthogonal to what was found,
// until nothing lower turns up.
Eigenpairs lanczos_eigenpairs(const SparseMatrix& d, const std::vector<RigidMotions>& rigid,
                              Index count)
{
    // Far below the lowest mode (a slender model has it at 1e-8 of the highest), and enough to keep
    // the matrix definite where pieces move freely.
    const double shift = -1e-12 * d.diagonal().maxCoeff();
    ShiftInverse inverse(d, shift, rigid);
    Eigenpairs pairs;
    pairs.vector.resize(d.rows(), 0);
    if (!inverse.factored()) {
        pairs.converged = false;
        return pairs;
    }
    Index wanted = count;
    for (std::uint64_t round = 0; round < 16; ++round) {
        const Index krylov = std::min<Index>(d.rows(), std::max<Index>(2 * wanted + 8, 20));
        Spectra::SymEigsSolver<ShiftInverse> solver(inverse, wanted, krylov);
        VectorXd start(d.rows());
        const geometry::Random random(round);
        for (Index i = 0; i < start.size(); ++i) start[i] = random.unit(std::uint64_t(i)) - 0.5;
        inverse.project(start);
        solver.init(start.data());
        const Index got = solver.compute(Spectra::SortRule::LargestAlge, 300, 1e-12);
        if (got < wanted) pairs.converged = false;
        const VectorXd values = solver.eigenvalues();
        const MatrixXd vectors = solver.eigenvectors();
        const double highest = pairs.value.empty() ? 0 : pairs.value.back();
        Index lower = 0;
        for (Index i = 0; i < got; ++i) {
            const double value = shift + 1 / values[i];
            if (round > 0 && value >= highest * (1 - 1e-9)) continue;
            pairs.vector.conservativeResize(Eigen::NoChange, pairs.vector.cols() + 1);
            VectorXd vector = vectors.col(i);
            inverse.project(vector);
            pairs.vector.rightCols<1>() = vector.normalized();
            pairs.value.push_back(value);
            ++lower;
        }
        sort_pairs(pairs);
        inverse.found = pairs.vector;
        if (round > 0 && lower == 0) break;
        wanted = std::min<Index>({2, count, d.rows() - pairs.vector.cols() - 1});
        if (wanted < 1) break;
    }
    const Index kept = std::min(count, pairs.vector.cols());
    pairs.value.resize(std::size_t(kept));
    pairs.vector.conservativeResize(Eigen::NoChange, kept);
    pairs.solves = inverse.solves;
    return pairs;
}

// phi^T C phi, C the sum of mass_damping * mass and stiffness_damping * stiffness of each cube.
double material_damping(const Cubes& cubes, const std::vector<Vec3>& phi, Elements& elements)
{
    double sum = 0;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        BrickVector u;
        for (std::size_t a = 0; a < 8; ++a) u.segment<3>(Index(3 * a)) = phi[cubes.corners[c][a]];
        const auto [k, factor] = elements.of(c);
        sum += cubes.mass_damping[c] * cubes.mass[c] / 8 * u.squaredNorm();
        if (cubes.stiffness_damping[c] > 0) {
            sum += cubes.stiffness_damping[c] * factor * u.dot(k * u);
        }
    }
    return sum;
}

}  // namespace

Modes lowest_modes(const Cubes& cubes, const std::vector<std::uint32_t>& pinned,
                   const ModeSettings& settings)
{
    geometry::need_thickness(cubes, "Modes");
    if (cubes.count() == 0) throw std::invalid_argument("expected at least one cube, found none");
    if (settings.count < 1) {
        throw std::invalid_argument(
            fmt::format("expected at least one mode, found {}", settings.count));
    }
    const Unknowns unknowns = order_unknowns(cubes, pinned);
    if (unknowns.count() == 0) {
        throw std::invalid_argument("expected some free corners, found all pinned");
    }
    const std::vector<double> mass = geometry::corner_masses(cubes);
    VectorXd root_mass(Index(3 * unknowns.count()));
    for (std::size_t i = 0; i < unknowns.count(); ++i) {
        const double m = mass[unknowns.corner[i]];
        if (!(m > 0) || !std::isfinite(m)) {
            throw std::invalid_argument(fmt::format(
                "expected every corner to have mass, found {} kg at corner {}: a modal model needs "
                "samples with mass in every cube",
                m, unknowns.corner[i]));
        }
        root_mass.segment<3>(Index(3 * i)).setConstant(std::sqrt(m));
    }
    const SparseMatrix d = assemble(cubes, unknowns, root_mass, settings);
    const auto rigid = rigid_motions(cubes, unknowns, root_mass);
    Index rigid_count = 0;
    for (const auto& piece : rigid) rigid_count += piece.motion.cols();

    Modes modes;
    modes.rigid = settings.keep_rigid ? int(std::min<Index>(rigid_count, settings.count)) : 0;
    modes.rigid_left_out = int(rigid_count) - modes.rigid;
    const Index elastic = settings.count - modes.rigid;
    if (elastic > d.rows() - rigid_count) {
        throw std::invalid_argument(fmt::format(
            "expected at most {} modes of {} free corners with {} rigid motions{}, found {}",
            d.rows() - rigid_count + (settings.keep_rigid ? rigid_count : 0), unknowns.count(),
            rigid_count, settings.keep_rigid ? "" : " left out", settings.count));
    }

    Eigenpairs pairs;
    pairs.vector.resize(d.rows(), 0);
    if (elastic > 0) {
        const bool small = d.rows() <= 240 || 3 * elastic + 30 > d.rows();
        pairs = small ? dense_eigenpairs(d, rigid, elastic) : lanczos_eigenpairs(d, rigid, elastic);
    }
    modes.report.converged = pairs.converged && Index(pairs.value.size()) == elastic;
    modes.report.iterations = pairs.solves;
    if (!modes.report.converged) {
        modes.report.warnings.push_back(
            fmt::format("only {} of {} modes converged", pairs.value.size(), elastic));
    }

    const auto add = [&](const VectorXd& vector, double omega_sq) {
        // Either sign would do: the largest component is positive.
        Index at = 0;
        vector.cwiseAbs().maxCoeff(&at);
        const double sign = vector[at] < 0 ? -1 : 1;
        std::vector<Vec3> shape(cubes.corner_count(), Vec3::Zero());
        for (std::size_t i = 0; i < unknowns.count(); ++i) {
            shape[unknowns.corner[i]] =
                sign / root_mass[Index(3 * i)] * vector.segment<3>(Index(3 * i));
        }
        modes.omega_sq.push_back(omega_sq);
        modes.shape.push_back(std::move(shape));
    };
    for (const auto& piece : rigid) {
        for (Index m = 0; m < piece.motion.cols() && int(modes.shape.size()) < modes.rigid; ++m) {
            VectorXd vector = VectorXd::Zero(d.rows());
            for (std::size_t i = 0; i < piece.unknown.size(); ++i) {
                vector.segment<3>(Index(3 * piece.unknown[i])) =
                    piece.motion.col(m).segment<3>(Index(3 * i));
            }
            add(vector, 0);
        }
    }
    // Cubes that touch along one edge or at one corner only are hinges: they turn at no cost.
    const double no_stiffness = 1e-13 * d.diagonal().maxCoeff();
    int hinges = 0;
    for (std::size_t i = 0; i < pairs.value.size(); ++i) {
        const VectorXd vector = pairs.vector.col(Index(i));
        const VectorXd force = d.selfadjointView<Eigen::Lower>() * vector;
        if (pairs.value[i] < no_stiffness) {
            ++hinges;
            continue;
        }
        modes.report.residual = std::max(modes.report.residual,
                                         (force - pairs.value[i] * vector).norm() / force.norm());
        add(vector, pairs.value[i]);
    }
    if (hinges > 0) {
        modes.report.warnings.push_back(fmt::format(
            "{} motions without stiffness left out: some cubes touch along an edge or at a corner "
            "only; connect them by faces, or keep one component",
            hinges));
    }
    Elements elements(cubes, settings);
    for (const auto& shape : modes.shape) {
        modes.damping.push_back(material_damping(cubes, shape, elements));
    }
    return modes;
}

}  // namespace physics
