#include "geometry/io/file_axes.hpp"

#include <cmath>
#include <stdexcept>

namespace geometry {
namespace {

Mat3 to_y_up(UpAxis up, const ImportedScene& scene)
{
    Mat3 M = Mat3::Identity();
    switch (up) {
    case UpAxis::automatic:
        if (scene.has_axes) {
            M = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
                scene.to_y_up.data());
        }
        return M;
    case UpAxis::y:
        return M;
    case UpAxis::z:
        M << 1, 0, 0, 0, 0, 1, 0, -1, 0;
        return M;
    case UpAxis::x:
        M << 0, -1, 0, 1, 0, 0, 0, 0, 1;
        return M;
    }
    throw std::invalid_argument("no such axis");
}

}  // namespace

double metres_of(LengthUnit unit, double custom, double said)
{
    switch (unit) {
    case LengthUnit::automatic:
        return said > 0 && std::isfinite(said) ? said : 1;
    case LengthUnit::metre:
        return 1;
    case LengthUnit::centimetre:
        return 0.01;
    case LengthUnit::millimetre:
        return 0.001;
    case LengthUnit::inch:
        return 0.0254;
    case LengthUnit::foot:
        return 0.3048;
    case LengthUnit::custom:
        if (!(custom > 0) || !std::isfinite(custom)) {
            throw std::invalid_argument("custom unit: expected a positive number of metres");
        }
        return custom;
    }
    throw std::invalid_argument("no such unit");
}

Mat3 to_metres(const ImportedScene& scene, const ReadOptions& options)
{
    return metres_of(options.unit, options.custom_unit, scene.unit) * to_y_up(options.up, scene);
}

}  // namespace geometry
