#pragma once

// How the contributions f_i of the skeletons at one point become the field f.
//
//    sum              largest_group      smooth_groups, growing w_ij
//     .-"""""-.         .--.  .--.         .--.  .--.        .-"""""-.
//    (  x   x  )       ( x  )( x  )       ( x  )( x  )  ->  (  x   x  )      x: point skeletons
//     '-.....-'         '--'  '--'         '--'  '--'        '-.....-'
//
// Skeletons have pairwise weights w_ij in 0..1, how much the two blend: 1 inside a part; between
// parts what a link says, else 0.
//
//   sum            f = sum f_i
//   largest_group  f = the largest sum over a group of skeletons that all blend with each other
//                  (cliques of w_ij > 0): the solid is the union of the solids of the groups, an
//                  arm never swells the hip it passes. Continuous, with creases where the largest
//                  group changes. (Cani-Gascuel and Desbrun 1997 after Guy and Wyvill. A group need
//                  not hold the largest f_i: if it had to, f would jump where the largest changes.)
//   smooth_groups  the same without creases, and with weights that may grow in time. With F_A the
//                  sums over parts,
//                    f = (sum F_A^p)^(1/p)      (Ricci. A constructive geometry for computer
//                                                graphics. The Computer Journal 16(2), 1973)
//                    1/p = beta = sum w_ij f_i f_j / sum f_i f_j   over pairs of different parts
//                  beta is 1 where all that is present blends: the plain sum; 0 where nothing
//                  does: the largest; and it varies smoothly between, as w does. f is C1 wherever
//                  beta > 0: it is smooth in every f_i > 0, and an f_j that sets in does so with
//                  zero slope while any beta leaves a single contribution as it is.
//   gradient       smooth_groups in which each skeleton is its own part and each pair's weight is
//                  also multiplied by sin^2 of the angle between grad r_i and grad r_j: nothing is
//                  added where gradients are parallel (no bulge where two limbs overlap) or
//                  opposite (no blending at a distance of surfaces that face each other), a full
//                  blend where they are orthogonal. The rule by angle is from Gourmel, Barthe,
//                  Cani, Wyvill, Bernhardt, Paulin, Grasberger. A gradient-based implicit blend.
//                  ACM Transactions on Graphics 32(2), 2013; the operator under it here is Ricci's.
//
// Every rule lies between the largest f_i and the sum of all, and is monotone enough for bounds
// from those two: max f_i <= f <= sum f_i.

#include "geometry/base/vec.hpp"

#include <span>
#include <vector>

namespace geometry {

enum class BlendRule : std::uint8_t { sum, largest_group, smooth_groups, gradient };

struct BlendLink {
    std::uint32_t a = 0, b = 0;  // skeletons of different parts
    double weight = 1;           // 0..1
    bool operator==(const BlendLink&) const = default;
};

struct Blend {
    BlendRule rule = BlendRule::sum;
    std::vector<std::uint32_t> part;  // S, or empty: each skeleton is its own part
    std::vector<BlendLink> links;     // any order, each pair once
};

// The weights of a Blend, quick to look up.
class BlendWeights {
public:
    BlendWeights() = default;
    // Throws std::invalid_argument for a link to a skeleton that is not there, to itself or inside
    // its part, twice the same, or with a weight outside 0..1.
    BlendWeights(const Blend& blend, std::size_t skeletons);

    std::uint32_t part(std::uint32_t i) const { return part_[i]; }
    double operator()(std::uint32_t i, std::uint32_t j) const;

private:
    std::vector<std::uint32_t> part_;   // S
    std::vector<std::uint32_t> first_;  // S + 1, into to_; empty without links
    std::vector<std::uint32_t> to_;     // sorted within a skeleton
    std::vector<double> weight_;
};

// One skeleton's contribution at a point.
struct Contributor {
    std::uint32_t skeleton;
    double f;
    Vec3 gradient;  // of f
    // For the rule `gradient` only:
    Vec3 n = Vec3::Zero();     // grad r / |grad r|
    Mat3 turn = Mat3::Zero();  // grad n: (i, j) is dn_j / dx_i; the Hessian of r without a stretch
    double share = 1;          // df/df_i, set by blend()
};

struct Blended {
    double f = 0;
    Vec3 gradient = Vec3::Zero();
};

// Only contributors with f > 0. Reorders them and sets their shares.
Blended blend(BlendRule rule, const BlendWeights& weights, std::span<Contributor> contributors);

}  // namespace geometry
