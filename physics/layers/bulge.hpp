#pragma once

// The bulge of a layer beyond its contact with another body j, by the distance t to j's surface.
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997, III; the formulas are our own (its copies are lost).
//
//   A(t) |        a .-"-.              x1 = min(w / 2, 3 a / k)
//        |       .'      '.            0 <= t <= x1   j soft: A = k x1 u (1 - u)^2 + a u^2 (3 - 2u)
//        |     .'          '.                         rigid:  A = a sqrt(u (2 - u)),   u = t / x1
//   -----+---.'--------------'-._--    x1 <= t <= w   A = a (1 - v)^2 (1 + 2v),
//        | .' 0      x1         w  t                                     v = (t - x1) / (w - x1)
//
// Against a soft j the rise has slope k, that of j's field at its surface, so the layer leaves the
// common surface without a crease; with x1 <= 3a/k it is monotone, so a bulge grows from nothing
// as a contact begins, while its extent stays w. Against a rigid j the layer follows j's surface up
// to the border, and leaves it without a crease only where the rise begins upright: a quarter of
// an ellipse; k is the layer's own then, a rigid body's field is as steep as it happens to be.
//
// t: where j's field is f > 0 the distance at which one skeleton alone has that field, so that t
// has an exact gradient, is smooth, and near the surface is the way along j's gradient to it to
// first order, for one skeleton altogether. Farther out, the distance to the nearest skeleton's
// surface. Where skeletons of unlike profiles meet each weighs as the square of its contribution.
// Against a stretched skeleton t and w are as it measures distances, so that the bulge is as much
// wider as that layer is.
//
// Two soft layers do not meet where A(t) <= s(t) = c - f: then c - f_i = A <= c - f_j on i's
// surface, that is f_i >= f_j, and on j's it is the other way round. With x1 = w / 2,
//   s - A = u^2 ((s1 - a)(3 - 2u) - s1' x1 (1 - u)) >= 0,   s1 = s(x1)
// if and only if a <= s1 - s1' x1 / 3, and a is no more than that. Against a rigid j it is free.

#include "physics/layers/meeting.hpp"

#include <utility>

namespace physics {

// One rise and fall: its height a, extent w and slope k.
struct BulgeShape {
    double a = 0;  // units of the field
    double w = 0;  // m
    double k = 1;  // 1/m, > 0
    bool rigid = false;
};

// A(t) and dA/dt. The slope of a rigid one is bounded where it would be infinite.
std::pair<double, double> bulge_at(const BulgeShape& shape, double t);

// How high a layer's bulges are, in units of the field, at most, against each body; and how wide.
struct Bulges {
    std::vector<double> height;  // one a body; empty: none
    double width = 0;            // m
    double slope = 1;            // 1/m, k of the layer itself: the largest

    double against(std::uint32_t body) const { return height.empty() ? 0 : height[body]; }
    double highest() const;
};

// What one party adds to the field of another at a point outside it, and how far away it is.
struct BulgeValue {
    double A = 0;
    Vec3 gradient = Vec3::Zero();  // of A
    double t = 0;                  // m, as j measures distances
    Vec3 t_gradient = Vec3::Zero();
};

// Of `other`, whose field at p is f with that gradient; f below the isovalue.
BulgeValue bulge_at(const Meeting& meeting, const Party& other, const Bulges& bulges, const Vec3& p,
                    double f, const Vec3& gradient);

// Bulges that reach a point together: each weighs ((w / t)^2 - 1)^2, so that a near one is alone.
class BulgeSum {
public:
    explicit BulgeSum(double width) : width_(width) {}
    void add(const BulgeValue& value);
    std::pair<double, Vec3> total() const;  // A and its gradient

private:
    double width_ = 0, weight_ = 0, sum_ = 0;
    Vec3 weight_gradient_ = Vec3::Zero(), sum_gradient_ = Vec3::Zero();
};

}  // namespace physics
