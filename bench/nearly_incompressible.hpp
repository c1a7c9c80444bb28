#pragma once

// Plane strain of nearly incompressible matter: Cook's membrane and a thick cylinder under inner
// pressure, of cubes that are filled as far as the body covers them, beside the bricks of CalculiX
// on meshes that fit (where `ccx` is installed). The linear equations of the elements themselves,
// for plane strain needs rollers, which pins are not.
//
// Cook. Improved 2-D finite element. ASCE J. Struct. Div. 100, 1974; nearly incompressible: Simo,
// Armero. Geometrically non-linear enhanced strain mixed methods. IJNME 33, 1992.

#include "bench/calculix.hpp"
#include "physics/modal/stiffness_matrix.hpp"

#include <Eigen/SparseCholesky>
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <numbers>
#include <sstream>

namespace incompressible {

using geometry::Cubes;
using geometry::Vec3;
using geometry::Vec3i;

constexpr double poisson = 0.4999;

// A place in the plane, and a direction and a load there, N for a layer of thickness 1.
struct Pull {
    double x, y, fx, fy;
};

struct Problem {
    double width, height, young;
    std::function<bool(double x, double y)> inside;
    std::function<std::array<bool, 2>(double x, double y)> held;  // along x, along y
    std::vector<Pull> pulls;
    std::vector<Pull> looked_at;  // the mean of u . f over these
};

inline double share_inside(const Problem& p, double x, double y, double h)
{
    constexpr int n = 16;
    int inside = 0;
    for (int row = 0; row < n; ++row) {
        for (int column = 0; column < n; ++column) {
            inside += p.inside(x + (column + 0.5) / n * h, y + (row + 0.5) / n * h) ? 1 : 0;
        }
    }
    return double(inside) / (n * n);
}

inline Cubes cubes_of(const Problem& p, double h)
{
    std::vector<Vec3i> cells;
    for (int j = 0; j < std::lround(p.height / h); ++j) {
        for (int i = 0; i < std::lround(p.width / h); ++i) {
            if (share_inside(p, i * h, j * h, h) > 0) cells.emplace_back(i, j, 0);
        }
    }
    Cubes cubes = geometry::solid_cubes(cells, h, {"rubber", 1000, p.young, poisson, 0, 0});
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        cubes.fill[c] = share_inside(p, cubes.cell[c].x() * h, cubes.cell[c].y() * h, h);
    }
    return cubes;
}

// The cube at a place, or the nearest, and bilinear weights there.
inline std::pair<std::size_t, std::array<double, 8>> weights_at(const Cubes& cubes, double x,
                                                                double y)
{
    std::size_t best = 0;
    double least = 1e300;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const double dx = x / cubes.size - cubes.cell[c].x() - 0.5;
        const double dy = y / cubes.size - cubes.cell[c].y() - 0.5;
        const double far = std::max(std::abs(dx), std::abs(dy));
        if (far < least - 1e-9) least = far, best = c;
    }
    const double u = x / cubes.size - cubes.cell[best].x(),
                 v = y / cubes.size - cubes.cell[best].y();
    std::array<double, 8> w{};
    for (std::size_t a = 0; a < 8; ++a) w[a] = 0.5 * (a & 1 ? u : 1 - u) * (a & 2 ? v : 1 - v);
    return {best, w};
}

// The mean of u . f over the places looked at.
inline double solve_cubes(const Problem& p, double h, physics::BrickElement element)
{
    const Cubes cubes = cubes_of(p, h);
    const auto n = Eigen::Index(3 * cubes.corner_count());
    std::vector<std::uint8_t> fixed(std::size_t(n), 0);
    for (std::size_t k = 0; k < cubes.corner_count(); ++k) {
        const Vec3 at = cubes.corner_position(k);
        const auto held = p.held(at.x(), at.y());
        fixed[3 * k] = held[0], fixed[3 * k + 1] = held[1], fixed[3 * k + 2] = 1;
    }
    physics::CubeStiffness stiffness(cubes, element, physics::Weighting::filled);
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const auto [k, factor] = stiffness.of(c);
        for (int i = 0; i < 24; ++i) {
            for (int j = 0; j < 24; ++j) {
                const auto row = 3 * cubes.corners[c][std::size_t(i / 3)] + unsigned(i % 3);
                const auto column = 3 * cubes.corners[c][std::size_t(j / 3)] + unsigned(j % 3);
                if (fixed[row] || fixed[column] || row < column) continue;
                entries.emplace_back(int(row), int(column), factor * k(i, j));
            }
        }
    }
    for (int i = 0; i < n; ++i) {
        if (fixed[std::size_t(i)]) entries.emplace_back(i, i, 1);
    }
    Eigen::SparseMatrix<double> matrix(n, n);
    matrix.setFromTriplets(entries.begin(), entries.end());
    Eigen::VectorXd f = Eigen::VectorXd::Zero(n);
    for (const Pull& pull : p.pulls) {
        const auto [c, w] = weights_at(cubes, pull.x, pull.y);
        for (std::size_t a = 0; a < 8; ++a) {
            const auto at = 3 * cubes.corners[c][a];
            if (!fixed[at]) f[at] += h * w[a] * pull.fx;
            if (!fixed[at + 1]) f[at + 1] += h * w[a] * pull.fy;
        }
    }
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
    const Eigen::VectorXd u = factor.solve(f);
    double sum = 0;
    for (const Pull& at : p.looked_at) {
        const auto [c, w] = weights_at(cubes, at.x, at.y);
        for (std::size_t a = 0; a < 8; ++a) {
            const auto k = 3 * cubes.corners[c][a];
            sum += w[a] * (at.fx * u[k] + at.fy * u[k + 1]);
        }
    }
    return sum / double(p.looked_at.size());
}

inline Problem cook()
{
    Problem p{48, 60, 70, {}, {}, {}, {{48, 60, 0, 1}}};
    p.inside = [](double x, double y) { return y >= 44.0 / 48 * x && y <= 44 + 16.0 / 48 * x; };
    p.held = [](double x, double) { return std::array{x < 1e-9, x < 1e-9}; };
    for (int i = 0; i < 480; ++i) p.pulls.push_back({48, 44 + (i + 0.5) / 30, 0, 100.0 / 480});
    return p;
}

inline Problem cylinder()
{
    Problem p{9, 9, 1000, {}, {}, {}, {}};
    p.inside = [](double x, double y) {
        const double r = std::hypot(x, y);
        return r >= 3 && r <= 9;
    };
    p.held = [](double x, double y) { return std::array{x < 1e-9, y < 1e-9}; };
    for (int i = 0; i < 480; ++i) {
        const double angle = (i + 0.5) / 480 * std::numbers::pi / 2;
        const double c = std::cos(angle), s = std::sin(angle), load = 3 * std::numbers::pi / 960;
        p.pulls.push_back({3 * c, 3 * s, load * c, load * s});
        p.looked_at.push_back({3 * c, 3 * s, c, s});
    }
    return p;
}

// One layer of nx x ny elements of CalculiX on a mesh that fits.
struct Grid {
    int nx, ny;
    std::function<std::array<double, 2>(int i, int j)> at;
    std::function<std::array<bool, 2>(int i, int j)> held;
    std::map<std::pair<int, int>, std::array<double, 2>> load;  // N for a thickness of 1
    double young;

    int node(int i, int j, int k) const { return 1 + i + (nx + 1) * (j + (ny + 1) * k); }
};

inline Grid cook_grid(int n)
{
    Grid g{n, n, {}, {}, {}, 70};
    g.at = [n](int i, int j) {
        const double x = 48.0 * i / n, low = 44.0 * i / n, edge = 44 - 28.0 * i / n;
        return std::array{x, low + edge * j / n};
    };
    g.held = [](int i, int) { return std::array{i == 0, i == 0}; };
    for (int j = 0; j < n; ++j) {
        for (const int at : {j, j + 1}) g.load[{n, at}][1] += 100.0 / n / 2;
    }
    return g;
}

inline Grid cylinder_grid(int n)
{
    const int around = 2 * n;
    Grid g{n, around, {}, {}, {}, 1000};
    g.at = [n, around](int i, int j) {
        const double r = 3 + 6.0 * i / n, angle = std::numbers::pi / 2 * j / around;
        return std::array{r * std::cos(angle), r * std::sin(angle)};
    };
    g.held = [around](int, int j) { return std::array{j == around, j == 0}; };
    for (int j = 0; j < around; ++j) {
        const auto a = g.at(0, j), b = g.at(0, j + 1);
        for (const int at : {j, j + 1}) {
            g.load[{0, at}][0] += (b[1] - a[1]) / 2;
            g.load[{0, at}][1] += (a[0] - b[0]) / 2;
        }
    }
    return g;
}

inline void write_input(const Grid& g, const std::string& element,
                        const std::filesystem::path& path)
{
    std::ofstream o(path);
    o << "*NODE,NSET=NALL\n";
    for (int k = 0; k < 2; ++k) {
        for (int j = 0; j <= g.ny; ++j) {
            for (int i = 0; i <= g.nx; ++i) {
                const auto [x, y] = g.at(i, j);
                o << fmt::format("{},{:.12g},{:.12g},{}.\n", g.node(i, j, k), x, y, k);
            }
        }
    }
    o << "*ELEMENT,TYPE=" << element << ",ELSET=EALL\n";
    for (int j = 0; j < g.ny; ++j) {
        for (int i = 0; i < g.nx; ++i) {
            o << 1 + i + g.nx * j;
            for (int k = 0; k < 2; ++k) {
                o << fmt::format(",{},{},{},{}", g.node(i, j, k), g.node(i + 1, j, k),
                                 g.node(i + 1, j + 1, k), g.node(i, j + 1, k));
            }
            o << "\n";
        }
    }
    o << fmt::format("*MATERIAL,NAME=M\n*ELASTIC\n{},{}\n*SOLID SECTION,ELSET=EALL,MATERIAL=M\n"
                     "*STEP\n*STATIC\n*BOUNDARY\nNALL,3,3\n",
                     g.young, poisson);
    for (int k = 0; k < 2; ++k) {
        for (int j = 0; j <= g.ny; ++j) {
            for (int i = 0; i <= g.nx; ++i) {
                const auto held = g.held(i, j);
                for (std::size_t d = 0; d < 2; ++d) {
                    if (held[d]) o << fmt::format("{},{},{}\n", g.node(i, j, k), d + 1, d + 1);
                }
            }
        }
    }
    o << "*CLOAD\n";
    for (const auto& [at, f] : g.load) {
        for (int k = 0; k < 2; ++k) {
            for (std::size_t d = 0; d < 2; ++d) {
                if (f[d] == 0) continue;
                o << fmt::format("{},{},{:.12g}\n", g.node(at.first, at.second, k), d + 1,
                                 f[d] / 2);
            }
        }
    }
    o << "*NODE PRINT,NSET=NALL\nU\n*END STEP\n";
}

// Displacement (m) of a node along an axis; not a number where CalculiX can't be run.
inline double run_calculix(const Grid& g, const std::string& element, int i, int j,
                           std::size_t axis, const std::filesystem::path& folder)
{
    write_input(g, element, folder / "plane.inp");
    const std::string command =
        fmt::format("cd '{}' && rm -f plane.dat && OMP_NUM_THREADS=1 ccx plane >/dev/null 2>&1",
                    folder.string());
    if (std::system(command.c_str()) != 0) return std::nan("");
    std::ifstream in(folder / "plane.dat");
    for (std::string line; std::getline(in, line);) {
        std::istringstream words(line);
        int node = 0;
        std::array<double, 3> u{};
        if (words >> node >> u[0] >> u[1] >> u[2] && node == g.node(i, j, 0)) return u[axis];
    }
    return std::nan("");
}

}  // namespace incompressible
