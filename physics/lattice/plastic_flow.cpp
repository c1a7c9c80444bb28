#include "physics/lattice/plastic_flow.hpp"

namespace physics {

template <class T>
void flow(FrameState& step, std::size_t slot, const Eigen::Matrix<T, 3, 3>& m,
          const Eigen::Matrix<T, 3, 3>& r)
{
    if (step.matched->regions.particle[slot] == none) return;
    const PlasticOptions& options = step.options.plastic;
    const float* const b = step.inverse_spread + 6 * slot;
    Mat3 inverse_b;
    inverse_b << double(b[0]), double(b[1]), double(b[2]), double(b[1]), double(b[3]), double(b[4]),
        double(b[2]), double(b[4]), double(b[5]);
    const Mat3 s = rest_shape<T>(step, slot).template cast<double>();
    const Mat3 turned = r.transpose().template cast<double>() * m.template cast<double>();
    Mat3 shape = turned * inverse_b / step.body.base.h;
    // Along an axis that nothing in it lies along (of a plane, or where links have broken) it
    // is as it was.
    for (Eigen::Index d = 0; d < 3; ++d) {
        if (inverse_b(d, d) == 0) shape.col(d) = s.col(d);
    }
    const Mat3 strain = strain_beyond(shape, s);
    const double share = share_that_flows(options, strain.norm(), step.dt);
    if (!(share > 0)) return;
    Mat3 change = grown_rest(s, share, strain, !step.flat);
    const double total = change.norm();
    if (total > options.limit) change *= options.limit / total;
    float* const p = step.state.plastic.data() + 6 * slot;
    const double packed[6] = {change(0, 0), change(0, 1), change(0, 2),
                              change(1, 1), change(1, 2), change(2, 2)};
    for (std::size_t c = 0; c < 6; ++c) p[c] = float(packed[c]);
}

template void flow(FrameState&, std::size_t, const Eigen::Matrix<float, 3, 3>&,
                   const Eigen::Matrix<float, 3, 3>&);
template void flow(FrameState&, std::size_t, const Eigen::Matrix<double, 3, 3>&,
                   const Eigen::Matrix<double, 3, 3>&);

void find_plastic_strain(FrameState& step)
{
    step.state.plastic_strain.clear();
    if (!step.plastic) return;
    const LatticeRegions& regions = step.matched->regions;
    std::vector<float> of_particle(step.n, 0);
    for (std::size_t slot = 0; slot < regions.slots(); ++slot) {
        if (regions.particle[slot] == none) continue;
        const Mat3 strain = rest_shape<double>(step, slot) - Mat3::Identity();
        of_particle[regions.particle[slot]] = float(strain.norm());
    }
    for (const auto& corners : step.body.cubes) {
        float sum = 0;
        for (const auto k : corners) sum += of_particle[k];
        step.state.plastic_strain.push_back(sum / 8);
    }
}

template <class T> std::span<const float> find_membrane_rest(StepState<T>& step)
{
    using Mat = Eigen::Matrix<T, 3, 3>;
    if (!step.plastic) return {};
    const LatticeRegions& regions = step.matched->regions;
    const int u = step.body.membrane.axes[0], v = step.body.membrane.axes[1];
    std::vector<std::uint32_t> slot(step.n);
    for (std::size_t s = 0; s < regions.slots(); ++s) {
        if (regions.particle[s] != none) slot[regions.particle[s]] = std::uint32_t(s);
    }
    const Membrane& membrane = step.body.membrane;
    step.membrane_rest.resize(3 * membrane.cells());
    const auto find_rest = [&](std::size_t c, const Membrane::Cell& cell) {
        Mat mean = Mat::Zero();
        for (const auto k : cell) mean += T(0.25) * rest_shape<T>(step, slot[k]);
        const T det = mean(u, u) * mean(v, v) - mean(u, v) * mean(u, v);
        const T inverse = det > 0 ? 1 / det : T(0);
        step.membrane_rest[3 * c] = float(mean(v, v) * inverse);
        step.membrane_rest[3 * c + 1] = float(-mean(u, v) * inverse);
        step.membrane_rest[3 * c + 2] = float(mean(u, u) * inverse);
    };
    geometry::parallel_for(
        membrane.strip.size(), membrane_strips_a_task,
        [&](std::size_t begin, std::size_t end) { membrane.for_each_cell(begin, end, find_rest); });
    return step.membrane_rest;
}

template std::span<const float> find_membrane_rest(StepState<float>&);
template std::span<const float> find_membrane_rest(StepState<double>&);

}  // namespace physics
