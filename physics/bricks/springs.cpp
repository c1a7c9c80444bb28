#include "physics/bricks/springs.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/cubes/plane.hpp"
#include "physics/body/inverted_cubes.hpp"
#include "physics/body/shapes_on_demand.hpp"
#include "physics/bricks/time_step.hpp"
#include "physics/state/measure.hpp"
#include "physics/state/report_texts.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>

// Map: which corners of a cube springs join; bending springs; forces and their derivative
// (SpringElasticity); making a body; stepping it.

namespace physics {
namespace {

// Corners from which corner a of a cube is seen along an edge or a face's diagonal, each pair once.
struct CubePair {
    unsigned a, b;
    bool edge;
};
std::vector<CubePair> cube_pairs()
{
    std::vector<CubePair> out;
    for (unsigned a = 0; a < 8; ++a) {
        for (unsigned b = a + 1; b < 8; ++b) {
            const unsigned apart = a ^ b;
            const int axes = int(apart & 1) + int(apart >> 1 & 1) + int(apart >> 2 & 1);
            if (axes < 3) out.push_back({a, b, axes == 1});
        }
    }
    return out;
}

// Springs between the same corners become one. They stand in the order of their corners.
void merge(std::vector<Spring>& springs, std::size_t corners)
{
    constexpr std::size_t corners_a_task = 4096;
    geometry::StopCheck check;
    std::vector<std::size_t> first(corners + 1, 0);  // by the lower corner
    for (const Spring& s : springs) check(), ++first[s.a + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<Spring> sorted(springs.size());
    auto next = first;
    for (const Spring& s : springs) check(), sorted[next[s.a]++] = s;
    springs = {};  // which holds several times what is kept
    geometry::parallel_for(corners, corners_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            std::sort(&sorted[0] + first[k], &sorted[0] + first[k + 1],
                      [](const Spring& p, const Spring& q) { return p.b < q.b; });
        }
    });
    std::size_t kept = 0;
    for (const Spring& s : sorted) {
        check();
        if (kept > 0 && sorted[kept - 1].a == s.a && sorted[kept - 1].b == s.b) {
            sorted[kept - 1].stiffness += s.stiffness;
            sorted[kept - 1].damping += s.damping;
        } else {
            sorted[kept++] = s;
        }
    }
    springs.assign(sorted.begin(), sorted.begin() + std::ptrdiff_t(kept));
}

// Edges along one axis, by the corner that they start from.
struct EdgesUp {
    std::vector<std::uint32_t> from;        // of each, E
    std::vector<std::uint32_t> to, spring;  // of each in the order of `from`
    std::vector<std::uint32_t> first;       // of each corner, and the end
};

std::array<EdgesUp, 3> edges_up(const geometry::Cubes& cubes, const std::vector<Spring>& springs)
{
    std::array<EdgesUp, 3> out;
    geometry::StopCheck check;
    for (std::uint32_t s = 0; s < springs.size(); ++s) {
        check();
        const auto along = cubes.corner[springs[s].b] - cubes.corner[springs[s].a];
        if (along.cwiseAbs().sum() != 1) continue;
        Eigen::Index axis = 0;
        along.cwiseAbs().maxCoeff(&axis);
        const bool forward = along[axis] > 0;
        EdgesUp& edges = out[static_cast<std::size_t>(axis)];
        edges.from.push_back(forward ? springs[s].a : springs[s].b);
        edges.to.push_back(forward ? springs[s].b : springs[s].a);
        edges.spring.push_back(s);
    }
    for (EdgesUp& edges : out) {
        edges.first.assign(cubes.corner_count() + 1, 0);
        for (const auto k : edges.from) ++edges.first[k + 1];
        std::partial_sum(edges.first.begin(), edges.first.end(), edges.first.begin());
        auto next = edges.first;
        const auto to = edges.to, spring = edges.spring;
        for (std::size_t e = 0; e < to.size(); ++e) {
            check();
            const auto at = next[edges.from[e]]++;
            edges.to[at] = to[e];
            edges.spring[at] = spring[e];
        }
    }
    return out;
}

// Springs over two edges in a row, along x, y and z; what they carry is taken off the edges, so
// that a stretch of both meets the force it met before: (k - share/2) d + share/4 (2 d) = k d.
void move_to_bending(const geometry::Cubes& cubes, double share, std::vector<Spring>& springs)
{
    const auto up = edges_up(cubes, springs);
    const std::size_t edges = springs.size();
    geometry::StopCheck check;
    std::vector<double> stiffness(edges), damping(edges);
    for (std::size_t s = 0; s < edges; ++s) {
        stiffness[s] = springs[s].stiffness;
        damping[s] = springs[s].damping;
    }
    for (const EdgesUp& axis : up) {
        for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
            check();
            for (auto e = axis.first[k]; e < axis.first[k + 1]; ++e) {
                const auto middle = axis.to[e], one = axis.spring[e];
                for (auto f = axis.first[middle]; f < axis.first[middle + 1]; ++f) {
                    const auto far = axis.to[f], two = axis.spring[f];
                    const double moved = share * std::min(stiffness[one], stiffness[two]);
                    const double slowed = share * std::min(damping[one], damping[two]);
                    springs.push_back({std::min(k, far), std::max(k, far),
                                       springs[one].length + springs[two].length, moved / 4,
                                       slowed / 4});
                    for (const auto s : {one, two}) {
                        springs[s].stiffness -= moved / 2;
                        springs[s].damping -= slowed / 2;
                    }
                }
            }
        }
    }
}

Vec3 place_of(const double* field, std::uint32_t k)
{
    return Eigen::Map<const Vec3>(field + 4 * std::size_t{k});
}

class SpringElasticity final : public Elasticity {
public:
    explicit SpringElasticity(const SpringsBody& body)
        : body_(body), direction_(body.springs.size()), across_(body.springs.size()),
          pull_(body.springs.size()), matrix_(body.springs.size()), matrix_low_(body.springs.size())
    {}

    std::size_t room() const override { return body_.base.numbers; }

    void forces(const double* x, double* f) override
    {
        for_each(body_.springs.size(), [&](std::size_t s) {
            const Spring& spring = body_.springs[s];
            Vec3 along = place_of(x, spring.b) - place_of(x, spring.a);
            const double length = along.norm();
            // Ends in one place are driven apart the way they lie at rest.
            const bool collapsed = length < 1e-9 * spring.length;
            if (collapsed) {
                along = place_of(body_.base.rest.data(), spring.b) -
                        place_of(body_.base.rest.data(), spring.a);
            }
            direction_[s] = along.normalized();
            across_[s] = collapsed ? 0 : std::max(0.0, 1 - spring.length / length);
            pull_[s] = spring.stiffness * (length - spring.length) * direction_[s];
        });
        for_each_corner([&](std::uint32_t k, auto ends) {
            Vec3 sum = Vec3::Zero();
            for (const auto e : ends) sum += e & 1 ? Vec3(-pull_[e / 2]) : pull_[e / 2];
            for (std::size_t i = 0; i < 3; ++i) f[4 * k + i] = sum[static_cast<Eigen::Index>(i)];
        });
    }

    double energy(const double* x) override
    {
        return sum_over_springs([&](const Spring& s) {
            const double stretch = (place_of(x, s.b) - place_of(x, s.a)).norm() - s.length;
            return 0.5 * s.stiffness * stretch * stretch;
        });
    }

    double largest_rate(const double* w) const override
    {
        double most_sq = 0;
        for (const Spring& s : body_.springs) {
            const double edge = body_.base.edge_at(s.a);
            most_sq = std::max(most_sq,
                               (place_of(w, s.b) - place_of(w, s.a)).squaredNorm() / (edge * edge));
        }
        return std::sqrt(most_sq);
    }

    void weigh(double stiffness, double damping) override
    {
        for_each(body_.springs.size(), [&](std::size_t s) {
            const Spring& spring = body_.springs[s];
            const Vec3& n = direction_[s];
            const double a = stiffness * spring.stiffness * across_[s];
            const double b = stiffness * spring.stiffness + damping * spring.damping - a;
            matrix_[s] = {a + b * n.x() * n.x(), b * n.x() * n.y(), b * n.x() * n.z(),
                          a + b * n.y() * n.y(), b * n.y() * n.z(), a + b * n.z() * n.z()};
            for (std::size_t i = 0; i < 6; ++i) {
                matrix_low_[s][i] = static_cast<float>(matrix_[s][i]);
            }
        });
    }

    void multiply(const float* p, float* y) const override { multiply_any(matrix_low_, p, y); }
    void multiply(const double* p, double* y) const override { multiply_any(matrix_, p, y); }

    void add_diagonal(double* d) const override
    {
        for_each_corner([&](std::uint32_t k, auto ends) {
            for (const auto e : ends) {
                d[4 * k] += matrix_[e / 2][0];
                d[4 * k + 1] += matrix_[e / 2][3];
                d[4 * k + 2] += matrix_[e / 2][5];
            }
        });
    }

private:
    template <class Term> double sum_over_springs(const Term& term) const
    {
        const auto& springs = body_.springs;
        return geometry::ordered_sum(springs.size(), 8192, 0.0,
                                     [&](std::size_t begin, std::size_t end) {
                                         double sum = 0;
                                         for (std::size_t i = begin; i < end; ++i) {
                                             sum += term(springs[i]);
                                         }
                                         return sum;
                                     });
    }

    template <class Each> static void for_each(std::size_t n, const Each& each)
    {
        geometry::parallel_for(n, 8192, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) each(i);
        });
    }

    // each(corner, its springs' ends)
    template <class Each> void for_each_corner(const Each& each) const
    {
        geometry::parallel_for(body_.base.corners, 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                each(static_cast<std::uint32_t>(k),
                     std::span(body_.end).subspan(body_.end_at[k],
                                                  body_.end_at[k + 1] - body_.end_at[k]));
            }
        });
    }

    template <class T>
    void multiply_any(const std::vector<std::array<T, 6>>& matrices, const T* p, T* y) const
    {
        for_each_corner([&](std::uint32_t k, auto ends) {
            T sum[3] = {0, 0, 0};
            const T* here = p + 4 * std::size_t{k};
            for (const auto e : ends) {
                const Spring& spring = body_.springs[e / 2];
                const T* there = p + 4 * std::size_t{e & 1 ? spring.a : spring.b};
                const T u[3] = {here[0] - there[0], here[1] - there[1], here[2] - there[2]};
                const auto& m = matrices[e / 2];
                sum[0] += m[0] * u[0] + m[1] * u[1] + m[2] * u[2];
                sum[1] += m[1] * u[0] + m[3] * u[1] + m[4] * u[2];
                sum[2] += m[2] * u[0] + m[4] * u[1] + m[5] * u[2];
            }
            for (std::size_t i = 0; i < 3; ++i) y[4 * std::size_t{k} + i] = sum[i];
        });
    }

    const SpringsBody& body_;
    std::vector<Vec3> direction_;  // from a to b
    std::vector<double> across_;   // max(0, 1 - L / l)
    std::vector<Vec3> pull_;       // N, on a
    std::vector<std::array<double, 6>> matrix_;
    std::vector<std::array<float, 6>> matrix_low_;
};

}  // namespace

SpringsBody make_springs(const geometry::Cubes& cubes, const SpringOptions& options,
                         const geometry::TriMesh* surface)
{
    return make_springs(BodyModels(cubes, surface), options);
}

SpringsBody make_springs(const BodyModels& models, const SpringOptions& options)
{
    const geometry::Cubes& cubes = models.all();
    geometry::need_thickness(cubes, "method springs");
    if (!(options.bending >= 0 && options.bending < 1)) {
        throw std::invalid_argument("springs: expected bending from 0 to below 1, found " +
                                    std::to_string(options.bending));
    }
    SpringsBody body;
    body.base = make_corner_body(models, {});
    give_shapes(models, options.contact, body.base);
    const auto pairs = cube_pairs();
    body.springs.reserve(pairs.size() * cubes.count());
    geometry::StopCheck check;
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        check();
        const double size = models.edge_of(c);
        const double k = 0.4 * cubes.young[c] * std::clamp(cubes.fill[c], 1e-3, 1.0) * size;
        for (const auto& [a, b, edge] : pairs) {
            const auto [low, high] = std::minmax(cubes.corners[c][a], cubes.corners[c][b]);
            const double share = edge ? k / 4 : k / 2;
            body.springs.push_back({low, high, size * (edge ? 1 : std::sqrt(2.0)), share,
                                    share * cubes.stiffness_damping[c]});
        }
    }
    for (const auto& corners : cubes.corners) body.cubes.push_back(corners);
    merge(body.springs, body.base.corners);
    if (options.bending > 0) {
        move_to_bending(cubes, options.bending, body.springs);
        merge(body.springs, body.base.corners);
    }
    body.end_at.assign(body.base.corners + 1, 0);
    for (const Spring& s : body.springs) {
        check();
        ++body.end_at[s.a + 1];
        ++body.end_at[s.b + 1];
    }
    std::partial_sum(body.end_at.begin(), body.end_at.end(), body.end_at.begin());
    body.end.resize(2 * body.springs.size());
    auto next = body.end_at;
    for (std::uint32_t s = 0; s < body.springs.size(); ++s) {
        check();
        body.end[next[body.springs[s].a]++] = 2 * s;
        body.end[next[body.springs[s].b]++] = 2 * s + 1;
    }
    return body;
}

std::size_t SpringsBody::bytes() const
{
    return sizeof *this - sizeof base + base.bytes() + springs.size() * sizeof springs[0] +
           (end_at.size() + end.size()) * sizeof end[0] + cubes.bytes();
}

State rest_state(const SpringsBody& body)
{
    return rest_state(body.base);
}

State advance(const SpringsBody& body, State state, const Loads& loads, double dt,
              const StepOptions& options)
{
    SpringElasticity elasticity(body);
    const double before = largest_speed(state);
    state = advance_implicitly(body.base, elasticity, std::move(state), loads, dt, options);
    if (state.report.slept) return state;
    const std::size_t inverted =
        count_inverted(body.base, body.cubes, by_slot(body.base, state.x).data());
    if (inverted > 0) {
        const double speed = std::max(before, largest_speed(state));
        state.report.warnings.push_back(told_of_inverted(
            inverted, body.cubes.size(), speed * dt / least_steps(options) > body.base.h));
    }
    return state;
}

std::vector<Vec3> spring_forces(const SpringsBody& body, const std::vector<Vec3>& x)
{
    SpringElasticity elasticity(body);
    Aligned<double> f(body.base.numbers, 0);
    elasticity.forces(by_slot(body.base, x).data(), f.data());
    std::vector<Vec3> out;
    for (std::uint32_t k = 0; k < body.base.corners; ++k) out.push_back(place_of(f.data(), k));
    return out;
}

}  // namespace physics
