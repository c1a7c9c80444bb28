#pragma once

// How one skeleton's contribution falls with the distance r from it.
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997. The published copy that we have lost its formulas; this is our own derivation from the
// properties it names: thickness e, stiffness k, radius of influence R, isovalue c.
//
//        f |\  .                         outside, u = (R - r) / (R - e), m = 2c - k (R - e):
//          | \   . stiffening              f = u^2 (c + m (1 - u))
//          |  \ .                          f' = -u (2c + m (2 - 3u)) / (R - e)
//        c |---\  slope -k               inside, d = e - r:
//          |    `.                         f = c + k d (1 + s d / (2e))
//          |      ` - .                    f' = -k (1 + s d / e)
//          +-----+------`--- r
//                e      R
// Outside is the one cubic with f(e) = c, f'(e) = -k, f(R) = f'(R) = 0: at u = 1 it is c with slope
// -(2c - m) / (R - e) = -k, at u = 0 both vanish. It is the same cubic as (r - R)^2 (a r + b) with
// D = e - R, a = -(k + 2c/D) / D^2, b = c/D^2 - a e, in a form that does not cancel near R.
// It falls all the way if and only if 2c + m (2 - 3u) >= 0 on 0 <= u <= 1; that is linear in u: at
// u = 1 it is k (R - e) > 0, at u = 0 it is 2 (c + m) >= 0, that is  k (R - e) <= 3c.
// -f' is the layer's stiffness: linear elasticity for s = 0; for s > 0 it grows under compression
// to (1 + s) times k at the skeleton.
// A volume controller moves the whole curve outward by t: f(r - t), shape and slope kept.

namespace geometry {

struct Contribution {
    double thickness = 0.1;  // e, m: distance of the surface of this skeleton alone
    double stiffness = 10;   // k, 1/m for an isovalue without unit
    double radius = 0.25;    // R, m: no influence from here on
    double stiffening = 0;   // s >= 0: by how much k has grown, relatively, at full compression

    bool operator==(const Contribution&) const = default;
};

// A contribution made ready to evaluate.
struct FieldProfile {
    double e = 0, R = 0;         // m, both with the translation added
    double c = 0, k = 0, q = 0;  // inside: f = c + d (k + q d)
    double m = 0, inverse = 0;   // 1 / (R - e)
};

struct ProfileValue {
    double f, slope;  // slope = df/dr
};

// Throws std::invalid_argument when the parameters do not give a decreasing function of distance,
// saying which bound is broken. `translation` t: any finite, m.
FieldProfile make_profile(const Contribution& contribution, double isovalue,
                          double translation = 0);

// The same contribution moved outward to `translation` in place of what it had; no checks.
FieldProfile moved(const FieldProfile& profile, double by);

// Zero at and beyond R, and where r is not a number.
inline ProfileValue profile_at(const FieldProfile& p, double r)
{
    if (!(r < p.R)) return {0, 0};
    const double depth = p.e - r;
    if (depth >= 0) {
        return {p.c + depth * (p.k + p.q * depth), -(p.k + (p.q + p.q) * depth)};
    }
    const double u = (p.R - r) * p.inverse;
    return {u * u * (p.c + p.m * (1 - u)), -p.inverse * u * (2 * p.c + p.m * (2 - 3 * u))};
}

// The largest -df/dr for from <= r <= to.
double steepest(const FieldProfile& p, double from, double to);

}  // namespace geometry
