#include "physics/body/bent_cube.hpp"

namespace physics {

InCube place_in(const std::array<Vec3, 8>& x, const Vec3& u, Vec3& p)
{
    InCube out{u, Mat3::Zero()};
    // Between the ends along x, then along y, then along z.
    std::array<Vec3, 4> along_x, slope_x;
    for (std::size_t i = 0; i < 4; ++i) {
        slope_x[i] = x[2 * i + 1] - x[2 * i];
        along_x[i] = x[2 * i] + u.x() * slope_x[i];
    }
    const Vec3 rise_low = along_x[1] - along_x[0], rise_high = along_x[3] - along_x[2];
    const Vec3 low = along_x[0] + u.y() * rise_low, high = along_x[2] + u.y() * rise_high;
    const Vec3 slope_low = slope_x[0] + u.y() * (slope_x[1] - slope_x[0]);
    const Vec3 slope_high = slope_x[2] + u.y() * (slope_x[3] - slope_x[2]);
    p = low + u.z() * (high - low);
    out.axes.col(0) = slope_low + u.z() * (slope_high - slope_low);
    out.axes.col(1) = rise_low + u.z() * (rise_high - rise_low);
    out.axes.col(2) = high - low;
    return out;
}

std::optional<InCube> find_in_cube(const std::array<Vec3, 8>& x, double size, const Vec3& p,
                                   double slack)
{
    Vec3 u = Vec3::Constant(0.5), here;
    for (int round = 0; round < 12; ++round) {
        const InCube in = place_in(x, u, here);
        if (!(in.axes.determinant() > 1e-6 * size * size * size)) return std::nullopt;
        const Vec3 off = p - here;
        if (off.norm() <= 1e-10 * size) {
            const bool inside = u.minCoeff() >= -slack && u.maxCoeff() <= 1 + slack;
            return inside ? std::optional(in) : std::nullopt;
        }
        u = (u + in.axes.inverse() * off).cwiseMax(-1.0).cwiseMin(2.0);
    }
    return std::nullopt;
}

}  // namespace physics
