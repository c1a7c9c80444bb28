#include "physics/layered_bodies/cube_carrier.hpp"

namespace physics {

void take_along(std::span<const CarriedFrame> carried, std::vector<Vec6>& x)
{
    for (const CarriedFrame& one : carried) {
        Vec6& twist = x[one.frame];
        twist.setZero();
        for (std::size_t a = 0; a < one.on.size(); ++a) {
            twist += one.by[a] * x[one.on[a]].head<3>();
        }
    }
}

void hand_on(std::span<const CarriedFrame> carried, std::vector<Vec6>& y)
{
    for (const CarriedFrame& one : carried) {
        Vec6& wrench = y[one.frame];
        for (std::size_t a = 0; a < one.on.size(); ++a) {
            y[one.on[a]].head<3>() += one.by[a].transpose() * wrench;
        }
        wrench.setZero();
    }
}

void hand_on_blocks(std::span<const CarriedFrame> carried, std::vector<Mat6>& blocks)
{
    for (const CarriedFrame& one : carried) {
        for (std::size_t a = 0; a < one.on.size(); ++a) {
            blocks[one.on[a]].topLeftCorner<3, 3>() +=
                one.by[a].transpose() * blocks[one.frame] * one.by[a];
        }
    }
}

void add_to_corner_blocks(std::span<const CubeCarrier> carriers, std::vector<Mat6>& blocks)
{
    for (const CubeCarrier& carrier : carriers) {
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
