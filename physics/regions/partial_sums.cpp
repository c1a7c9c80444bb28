#include "physics/regions/partial_sums.hpp"

#include "geometry/base/parallel.hpp"

#include <array>

namespace physics {

namespace {

// Nodes or particles a task handles.
constexpr std::size_t nodes_a_task = 512;

template <class T> using Node = std::array<Quad<T>, 4>;

template <class T> Node<T> zero_node()
{
    return {Quad<T>::Zero(), Quad<T>::Zero(), Quad<T>::Zero(), Quad<T>::Zero()};
}

// S and its moments about a place `by` back, added to `to`. A plane's third moment is along both
// axes.
template <class T> void add_shifted(bool flat, const Vec3i& by, const Quad<T>* from, Quad<T>* to)
{
    to[0] += from[0];
    for (int d = 0; d < 3; ++d) to[1 + d] += from[1 + d] + T(by[d]) * from[0];
    if (flat) to[3] += T(by[0]) * from[2] + T(by[1]) * from[1] + T(by[0] * by[1]) * from[0];
}

// What spreads, an affine map with the product of both axes on a plane, as seen from a place `by`
// on.
template <class T> void add_moved(bool flat, const Vec3i& by, const Quad<T>* from, Quad<T>* to)
{
    to[0] += from[0] + T(by[0]) * from[1] + T(by[1]) * from[2];
    for (std::size_t c = 1; c < 4; ++c) to[c] += from[c];
    if (flat) {
        to[0] += T(by[0] * by[1]) * from[3];
        to[1] += T(by[1]) * from[3];
        to[2] += T(by[0]) * from[3];
    } else {
        to[0] += T(by[2]) * from[3];
    }
}

// Of the nodes low .. high from their children, which are nodes before.
template <class T>
void collect_nodes(const PartialRegions& e, bool flat, Quad<T>* nodes, std::size_t low,
                   std::size_t high)
{
    geometry::parallel_for(high - low, nodes_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = low + begin; n < low + end; ++n) {
            Node<T> total = zero_node<T>();
            for (std::uint32_t k = e.child_at[n]; k < e.child_at[n + 1]; ++k) {
                const std::size_t child = e.child[k];
                add_shifted<T>(flat, e.at[child] - e.at[n], nodes + 4 * child, total.data());
            }
            std::copy(total.begin(), total.end(), nodes + 4 * n);
        }
    });
}

// Of the nodes low .. high from their parents, which are nodes behind.
template <class T>
void spread_nodes(const PartialRegions& e, bool flat, Quad<T>* nodes, std::size_t low,
                  std::size_t high)
{
    geometry::parallel_for(high - low, nodes_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = low + begin; n < low + end; ++n) {
            Node<T> total = zero_node<T>();
            for (std::uint32_t k = e.parent_at[n]; k < e.parent_at[n + 1]; ++k) {
                const std::size_t parent = e.parent[k];
                add_moved<T>(flat, e.at[n] - e.at[parent], nodes + 4 * parent, total.data());
            }
            std::copy(total.begin(), total.end(), nodes + 4 * n);
        }
    });
}

}  // namespace

template <class T>
void collect_partial(const PartialRegions& e, bool flat, const Quad<T>* particles, Quad<T>* nodes)
{
    geometry::parallel_for(e.bars, nodes_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            Node<T> total = zero_node<T>();
            for (std::uint32_t k = e.child_at[n]; k < e.child_at[n + 1]; ++k) {
                const Quad<T>& f = particles[e.child[k]];
                total[0] += f;
                total[1] += T(k - e.child_at[n]) * f;  // unbroken, and about its first
            }
            std::copy(total.begin(), total.end(), nodes + 4 * n);
        }
    });
    const std::size_t first_region = e.bars + e.plates;
    collect_nodes(e, flat, nodes, e.bars, first_region);
    collect_nodes(e, flat, nodes, first_region, e.nodes());
}

template <class T>
void spread_partial(const PartialRegions& e, bool flat, Quad<T>* nodes, Quad<T>* particles)
{
    spread_nodes(e, flat, nodes, e.bars, e.bars + e.plates);
    spread_nodes(e, flat, nodes, 0, e.bars);
    geometry::parallel_for(
        e.particle.size(), nodes_a_task, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                Quad<T> total = Quad<T>::Zero();
                for (std::uint32_t k = e.bar_at[i]; k < e.bar_at[i + 1]; ++k) {
                    const std::size_t bar = e.bar[k] >> 8, along = e.bar[k] & 255u;
                    total += nodes[4 * bar] + T(along) * nodes[4 * bar + 1];
                }
                particles[e.particle[i]] += total;
            }
        });
}

template void collect_partial(const PartialRegions&, bool, const Quad<float>*, Quad<float>*);
template void collect_partial(const PartialRegions&, bool, const Quad<double>*, Quad<double>*);
template void spread_partial(const PartialRegions&, bool, Quad<float>*, Quad<float>*);
template void spread_partial(const PartialRegions&, bool, Quad<double>*, Quad<double>*);

}  // namespace physics
