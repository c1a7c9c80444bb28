#pragma once

// The stable Neo-Hookean material: rubber and flesh, whose volume costs the more the more it is
// stretched, and which has forces and a derivative at every deformation gradient F, turned inside
// out or flat as well. Smith, de Goes, Kim. Stable Neo-Hookean flesh simulation. ACM TOG 37(2),
// 2018: with I = |F|^2 and J = det F,
//   W(F) = m/2 (I - 3) + l/2 (J - a)^2 - m/2 log(I + 1),   a = 1 + m/l - m/(4 l)
// per volume at rest. m = 4/3 mu and l = lambda + 5/6 mu make it the linear material of Lame's mu
// and lambda at small strains.

#include "physics/bricks/brick_element.hpp"

namespace physics {

// d vec(P) / d vec(F), with vec() column by column. Symmetric.
using Mat9 = Eigen::Matrix<double, 9, 9>;

class NeoHookean {
public:
    explicit NeoHookean(Lame material);  // Pa; mu > 0 and lambda > -2/3 mu

    // J/m^3, 0 at rest.
    double energy(const geometry::Mat3& f) const;
    // P = dW/dF, Pa.
    geometry::Mat3 stress(const geometry::Mat3& f) const;
    // dP/dF, Pa. `positive`: without its negative directions, which are known in closed form in
    // the axes of F's singular values.
    Mat9 hessian(const geometry::Mat3& f, bool positive) const;

private:
    double m_, l_, a_;
};

}  // namespace physics
