#pragma once

// Bars of brick elements solved by CalculiX (`ccx` of the package calculix-ccx), where installed.

#include <Eigen/Core>
#include <fmt/format.h>

#include <sys/resource.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace calculix {

using Eigen::Vector3d;

// Of child processes that have ended, s.
inline double child_seconds()
{
    rusage used{};
    getrusage(RUSAGE_CHILDREN, &used);
    return double(used.ru_utime.tv_sec) + 1e-6 * double(used.ru_utime.tv_usec);
}

// A bar along x from the origin; y and z are centred. SI units.
struct Bar {
    Vector3d size;
    std::array<int, 3> elements;
    double young, poisson, density;
    bool held = false;  // all of its end at x = 0

    int node(int i, int j, int k) const
    {
        return 1 + i + (elements[0] + 1) * (j + (elements[1] + 1) * k);
    }
    int nodes() const { return (elements[0] + 1) * (elements[1] + 1) * (elements[2] + 1); }
    Vector3d at(int i, int j, int k) const
    {
        return {size.x() * i / elements[0], size.y() * (double(j) / elements[1] - 0.5),
                size.z() * (double(k) / elements[2] - 0.5)};
    }
    template <class F> void each_node(const F& call) const
    {
        for (int k = 0; k <= elements[2]; ++k) {
            for (int j = 0; j <= elements[1]; ++j) {
                for (int i = 0; i <= elements[0]; ++i) call(i, j, k);
            }
        }
    }
};

inline void write_bar(std::ostream& o, const Bar& bar, const std::string& element)
{
    o << "*NODE,NSET=NALL\n";
    bar.each_node([&](int i, int j, int k) {
        const Vector3d p = bar.at(i, j, k);
        o << fmt::format("{},{:.12g},{:.12g},{:.12g}\n", bar.node(i, j, k), p.x(), p.y(), p.z());
    });
    o << "*ELEMENT,TYPE=" << element << ",ELSET=EALL\n";
    int number = 0;
    for (int k = 0; k < bar.elements[2]; ++k) {
        for (int j = 0; j < bar.elements[1]; ++j) {
            for (int i = 0; i < bar.elements[0]; ++i) {
                o << ++number;
                for (const int up : {k, k + 1}) {
                    o << fmt::format(",{},{},{},{}", bar.node(i, j, up), bar.node(i + 1, j, up),
                                     bar.node(i + 1, j + 1, up), bar.node(i, j + 1, up));
                }
                o << "\n";
            }
        }
    }
    o << fmt::format("*MATERIAL,NAME=M\n*ELASTIC\n{},{}\n*DENSITY\n{}\n"
                     "*SOLID SECTION,ELSET=EALL,MATERIAL=M\n",
                     bar.young, bar.poisson, bar.density);
    if (!bar.held) return;
    o << "*BOUNDARY\n";
    bar.each_node([&](int i, int j, int k) {
        if (i == 0) o << fmt::format("{},1,3\n", bar.node(i, j, k));
    });
}

// Displacements of all nodes, one after the other, in each block of the output; none where CalculiX
// can't be run.
inline std::vector<std::vector<Vector3d>> run(const std::filesystem::path& folder, int nodes)
{
    const std::string command = fmt::format(
        "cd '{}' && rm -f bar.dat && OMP_NUM_THREADS=1 ccx bar >/dev/null 2>&1", folder.string());
    std::vector<std::vector<Vector3d>> out;
    if (std::system(command.c_str()) != 0) return out;
    std::ifstream in(folder / "bar.dat");
    bool wanted = false;
    for (std::string line; std::getline(in, line);) {
        if (line.find("displacements") != line.npos) {
            wanted = true;
            out.emplace_back(std::size_t(nodes), Vector3d::Zero());
            continue;
        }
        std::istringstream words(line);
        int node = 0;
        Vector3d u;
        if (!(words >> node)) continue;
        if (words >> u.x() >> u.y() >> u.z()) {
            if (wanted && node >= 1 && node <= nodes) out.back()[std::size_t(node - 1)] = u;
        } else {
            wanted = false;
        }
    }
    return out;
}

// Where the bar's end comes to lie under a dead load on it (N), with large rotations: the mean over
// the corners of its end, m. In as many increments as CalculiX needs, from `first` of the load on.
// Not a number where CalculiX can't be run or does not converge.
inline Vector3d pulled_end(const Bar& bar, const std::string& element, const Vector3d& load,
                           double first, const std::filesystem::path& folder)
{
    const int far = bar.elements[0];
    std::ofstream o(folder / "bar.inp");
    write_bar(o, bar, element);
    o << fmt::format("*STEP,NLGEOM,INC=1000\n*STATIC\n{},1.\n*CLOAD\n", first);
    bar.each_node([&](int i, int j, int k) {
        if (i != far) return;
        const double along_y = j == 0 || j == bar.elements[1] ? 0.5 : 1;
        const double along_z = k == 0 || k == bar.elements[2] ? 0.5 : 1;
        const Vector3d share = load * (along_y * along_z / (bar.elements[1] * bar.elements[2]));
        for (int d = 0; d < 3; ++d) {
            if (share[d] != 0) {
                o << fmt::format("{},{},{:.12g}\n", bar.node(i, j, k), d + 1, share[d]);
            }
        }
    });
    o << "*NODE PRINT,NSET=NALL,FREQUENCY=100000\nU\n*END STEP\n";
    o.close();
    const auto found = run(folder, bar.nodes());
    if (found.empty()) return Vector3d::Constant(std::nan(""));
    Vector3d sum = Vector3d::Zero();
    int count = 0;
    bar.each_node([&](int i, int j, int k) {
        if (i != far) return;
        sum += bar.at(i, j, k) + found.back()[std::size_t(bar.node(i, j, k) - 1)];
        ++count;
    });
    return sum / count;
}

struct Vibration {
    double frequency;  // Hz
    std::vector<Vector3d> shape;
};

// Vibrations in ascending order, those below `least` Hz left out: those of a free body that do not
// bend it. None where CalculiX can't be run.
inline std::vector<Vibration> vibrations(const Bar& bar, const std::string& element, int count,
                                         double least, const std::filesystem::path& folder)
{
    std::ofstream o(folder / "bar.inp");
    write_bar(o, bar, element);
    o << fmt::format("*STEP\n*FREQUENCY\n{}\n*NODE PRINT,NSET=NALL\nU\n*END STEP\n", count);
    o.close();
    const auto shapes = run(folder, bar.nodes());
    std::vector<Vibration> out;
    std::ifstream in(folder / "bar.dat");
    // "mode, eigenvalue, rad/s, cycles/s, imaginary part", and later a table of participation.
    std::size_t at = 0;
    for (std::string line; std::getline(in, line) && at < shapes.size();) {
        std::istringstream words(line);
        std::size_t mode = 0;
        double eigenvalue = 0, radians = 0, cycles = 0;
        if (!(words >> mode >> eigenvalue >> radians >> cycles) || mode != at + 1) continue;
        if (cycles >= least) out.push_back({cycles, shapes[at]});
        ++at;
    }
    return out;
}

}  // namespace calculix
