#include "physics/state/plastic.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace physics {

using geometry::Mat3;

void check_plastic(const PlasticOptions& options)
{
    const auto positive = [](double value) { return std::isfinite(value) && value >= 0; };
    if (positive(options.yield) && positive(options.flow) && options.limit >= 0 &&
        options.limit < 1) {
        return;
    }
    throw std::invalid_argument(fmt::format(
        "plastic: expected a yield and a flow of at least 0 and a limit from 0 to below "
        "1, found yield {}, flow {} and limit {}",
        options.yield, options.flow, options.limit));
}

double share_that_flows(const PlasticOptions& options, double size, double dt)
{
    if (!(options.yield > 0) || !(size > options.yield) || !std::isfinite(size)) return 0;
    const double give = -std::expm1(-options.flow * dt) * (1 - options.yield / size);
    return std::min(1.0, 0.2 / (give * size)) * give;
}

Mat3 strain_beyond(const Mat3& stretch, const Mat3& rest)
{
    const Mat3 strain = stretch * rest.inverse();
    return 0.5 * (strain + strain.transpose()) - Mat3::Identity();
}

Mat3 with_volume_1(const Mat3& stretch)
{
    const double det = stretch.determinant();
    return det > 0 ? Mat3(stretch / std::cbrt(det)) : stretch;
}

Mat3 grown_rest(const Mat3& rest, double share, const Mat3& strain, bool keeps_volume)
{
    const Mat3 grown = (Mat3::Identity() + share * strain) * rest;
    const Mat3 next = 0.5 * (grown + grown.transpose());
    return (keeps_volume ? with_volume_1(next) : next) - Mat3::Identity();
}

}  // namespace physics
