#include "physics/lattice/region_volume.hpp"

#include <Eigen/LU>

#include <cmath>

namespace physics {

namespace {

template <class T> Eigen::Matrix<T, 3, 3> cofactors(const Eigen::Matrix<T, 3, 3>& m)
{
    Eigen::Matrix<T, 3, 3> out;
    for (Eigen::Index i = 0; i < 3; ++i) {
        out.row(i) = m.row((i + 1) % 3).cross(m.row((i + 2) % 3));
    }
    return out;
}

template <class T> Eigen::Matrix<T, 3, 3> root_of(const RegionVolume<T>& volume)
{
    const auto& v = volume.root;
    Eigen::Matrix<T, 3, 3> root;
    root << v[0], v[1], v[2], v[1], v[3], v[4], v[2], v[4], v[5];
    return root;
}

}  // namespace

template <class T>
Eigen::Matrix<T, 3, 3> pull_to_volume(const RegionVolume<T>& volume,
                                      const Eigen::Matrix<T, 3, 3>& a, T h, T size)
{
    using Mat = Eigen::Matrix<T, 3, 3>;
    const Mat root = root_of(volume);
    const T edge = std::cbrt(size);
    const Mat g = volume.scale / (h * edge) * a * root, n = cofactors(g);
    const T size_sq = g.squaredNorm(), q = n.squaredNorm() + size_sq * size_sq / 9 + 2;
    if (!(q < T(most_stretched))) return Mat::Zero();
    const T r = (g.row(0).dot(n.row(0)) - 1) / q;
    const Mat stretched = T(11) / 9 * size_sq * g - g * (g.transpose() * g);
    return -2 * edge * (r * n - r * r * stretched) * root;
}

template Eigen::Matrix3f pull_to_volume(const RegionVolume<float>&, const Eigen::Matrix3f&, float,
                                        float);
template Eigen::Matrix3d pull_to_volume(const RegionVolume<double>&, const Eigen::Matrix3d&, double,
                                        double);

template <class T>
Eigen::Matrix<T, 3, 3> linear_map(const RegionVolume<T>& volume, const Eigen::Matrix<T, 3, 3>& a,
                                  T h)
{
    const Eigen::Matrix<T, 3, 3> root = root_of(volume);
    return volume.scale / h * a * root * root;
}

template Eigen::Matrix3f linear_map(const RegionVolume<float>&, const Eigen::Matrix3f&, float);
template Eigen::Matrix3d linear_map(const RegionVolume<double>&, const Eigen::Matrix3d&, double);

}  // namespace physics
