#include "physics/layered_bodies/cube_carrier.hpp"

namespace physics {

void take_along(std::span<const CubeCarrier> carriers, std::vector<Vec6>& x)
{
    for (const CubeCarrier& carrier : carriers) {
        for (std::size_t f = 0; f < carrier.holds.size(); ++f) {
            Vec6& twist = x[carrier.first_frame + f];
            twist.setZero();
            const auto corners = carrier.base->corners(f);
            for (std::size_t a = 0; a < corners.size(); ++a) {
                twist += carrier.holds[f].by[a] * x[carrier.first_corner + corners[a]].head<3>();
            }
        }
    }
}

void hand_to_corners(std::span<const CubeCarrier> carriers, std::vector<Vec6>& y)
{
    for (const CubeCarrier& carrier : carriers) {
        for (std::size_t f = 0; f < carrier.holds.size(); ++f) {
            Vec6& wrench = y[carrier.first_frame + f];
            const auto corners = carrier.base->corners(f);
            for (std::size_t a = 0; a < corners.size(); ++a) {
                y[carrier.first_corner + corners[a]].head<3>() +=
                    carrier.holds[f].by[a].transpose() * wrench;
            }
            wrench.setZero();
        }
    }
}

void add_to_corner_blocks(std::span<const CubeCarrier> carriers, std::vector<Mat6>& blocks)
{
    for (const CubeCarrier& carrier : carriers) {
        for (std::size_t f = 0; f < carrier.holds.size(); ++f) {
            const auto corners = carrier.base->corners(f);
            for (std::size_t a = 0; a < corners.size(); ++a) {
                const auto& by = carrier.holds[f].by[a];
                blocks[carrier.first_corner + corners[a]].topLeftCorner<3, 3>() +=
                    by.transpose() * blocks[carrier.first_frame + f] * by;
            }
        }
        const CornerBody& body = carrier.corner_body();
        for (std::size_t k = 0; k < body.corners; ++k) {
            for (int i = 0; i < 3; ++i) {
                blocks[carrier.first_corner + k](i, i) +=
                    carrier.diagonal[4 * body.slot_of(k) + std::size_t(i)];
            }
        }
    }
}

void add_elastic(std::span<CubeCarrier> carriers, const std::vector<Vec6>& x, std::vector<Vec6>& y)
{
    for (CubeCarrier& carrier : carriers) {
        const CornerBody& body = carrier.corner_body();
        for (std::size_t k = 0; k < body.corners; ++k) {
            for (std::size_t i = 0; i < 3; ++i) {
                carrier.in[4 * body.slot_of(k) + i] =
                    x[carrier.first_corner + k][static_cast<Eigen::Index>(i)];
            }
        }
        carrier.elasticity->multiply(carrier.in.data(), carrier.out.data());
        for (std::size_t k = 0; k < body.corners; ++k) {
            for (std::size_t i = 0; i < 3; ++i) {
                y[carrier.first_corner + k][static_cast<Eigen::Index>(i)] +=
                    carrier.out[4 * body.slot_of(k) + i];
            }
        }
    }
}

}  // namespace physics
