#include "physics/lattice/bend_ratio.hpp"

#include "physics/lattice/matched_regions.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace physics {

namespace {

// Some particles on a line, of some mass each: sums of mass and of its moments about the middle.
struct Window {
    double mass = 0, middle = 0;
    double second = 0, third = 0, fourth = 0;

    double variance() const { return second / mass; }
    // Mean square of what is left of a^2 / 2 beside a line.
    double curved() const
    {
        if (!(second > 0)) return 0;
        return (fourth - second * second / mass - third * third / second) / (4 * mass);
    }
};

template <class Mass> Window window(int first, int last, const Mass& mass)
{
    Window out;
    double moment = 0;
    for (int i = first; i <= last; ++i) out.mass += mass(i), moment += mass(i) * i;
    out.middle = moment / out.mass;
    for (int i = first; i <= last; ++i) {
        const double a = i - out.middle;
        out.second += mass(i) * a * a;
        out.third += mass(i) * a * a * a;
        out.fourth += mass(i) * a * a * a * a;
    }
    return out;
}

// That in the middle of particles 0 .. length; those at the ends weigh a half.
Window middle_window(int length, int w)
{
    if (length > 2 * w) return window(-w, w, [](int) { return 1.0; });
    return window(0, length, [&](int i) { return i == 0 || i == length ? 0.5 : 1.0; });
}

// V and C of all windows on particles 0 .. length, which weigh by the number of windows that hold
// each, as in lattice.hpp.
struct Windows {
    double variance = 0, middles = 0;
};
Windows all_windows(int length, int w)
{
    const auto first = [&](int at) { return std::max(0, at - w); };
    const auto last = [&](int at) { return std::min(length, at + w); };
    const auto mass = [&](int i) {
        return (i == 0 || i == length ? 0.5 : 1.0) / (last(i) - first(i) + 1);
    };
    Windows out;
    double all = 0;
    for (int at = 0; at <= length; ++at) {
        const Window some = window(first(at), last(at), mass);
        all += some.mass;
        out.variance += some.second;
        out.middles += some.mass * std::pow(some.middle - length / 2.0, 2);
    }
    return {out.variance / all, out.middles / all};
}

// The cubes of a model, and which follows which.
class Blocks {
public:
    explicit Blocks(const geometry::Cubes& cubes)
        : cubes_(cubes), at_low_(cubes.corner_count(), none)
    {
        for (std::uint32_t c = 0; c < cubes.count(); ++c) at_low_[cubes.corners[c][0]] = c;
    }

    // Edges of the largest full blocks that the cubes lie in, at most `most`.
    std::vector<int> thickness(int most) const
    {
        const std::vector<int> edge = edges(most);
        std::vector<int> out(edge.size(), 1);
        const int largest = *std::max_element(edge.begin(), edge.end());
        std::vector<int> left(edge.size());
        for (int t = 2; t <= largest; ++t) {
            for (std::size_t c = 0; c < edge.size(); ++c) left[c] = edge[c] >= t ? t : 0;
            for (const unsigned side : {1u, 2u, 4u}) grow(t, side, left);
            for (std::size_t c = 0; c < edge.size(); ++c) {
                if (left[c] > 0) out[c] = t;
            }
        }
        return out;
    }

    // Cubes in the longest rows through them.
    std::vector<int> length() const
    {
        std::vector<int> out(cubes_.count(), 1);
        for (const unsigned side : {1u, 2u, 4u}) {
            std::vector<int> behind(out.size(), 1);  // with it, in a row from its low end
            for (std::size_t c = 0; c < out.size(); ++c) {
                if (const auto n = next(c, side); n != none) behind[n] = behind[c] + 1;
            }
            for (std::size_t c = out.size(); c-- > 0;) {
                if (const auto n = next(c, side); n != none) behind[c] = behind[n];
                out[c] = std::max(out[c], behind[c]);
            }
        }
        return out;
    }

private:
    // The cube beside c, whose low corner is a corner of c. It comes after c in the list.
    std::uint32_t next(std::size_t c, unsigned corner) const
    {
        return at_low_[cubes_.corners[c][corner]];
    }

    // Of the largest full blocks whose low ends the cubes are.
    std::vector<int> edges(int most) const
    {
        std::vector<int> edge(cubes_.count());
        for (std::size_t c = edge.size(); c-- > 0;) {
            int least = most - 1;
            for (unsigned corner = 1; corner < 8 && least > 0; ++corner) {
                const auto n = next(c, corner);
                least = n == none ? 0 : std::min(least, edge[n]);
            }
            edge[c] = least + 1;
        }
        return edge;
    }

    // Cubes with something left have the t - 1 that follow them along an axis marked.
    void grow(int t, unsigned side, std::vector<int>& left) const
    {
        for (std::size_t c = 0; c < left.size(); ++c) {
            const auto n = left[c] > 1 ? next(c, side) : none;
            if (n != none) left[n] = std::max(left[n], left[c] - 1);
        }
        for (int& l : left) l = l > 0 ? t : 0;
    }

    const geometry::Cubes& cubes_;
    std::vector<std::uint32_t> at_low_;
};

}  // namespace

double bend_ratio(int thickness, int length, int half_width)
{
    const Window along = middle_window(length, half_width);
    const Windows across = all_windows(thickness, half_width);
    const double unit = 12.0 / (thickness * thickness) / mean_square_place(half_width);
    const double alpha = unit * along.variance() * across.middles;
    const double beta = unit * (along.curved() + along.variance() * across.variance);
    return alpha < 1 ? std::max(1.0, beta / (1 - alpha)) : 1.0;
}

std::vector<double> bend_ratios(const geometry::Cubes& cubes, int half_width)
{
    const Blocks blocks(cubes);
    // Of thicker ones n is less by at most a tenth.
    const std::vector<int> thickness = blocks.thickness(6 * half_width);
    const std::vector<int> length = blocks.length();
    std::map<std::pair<int, int>, double> known;
    std::vector<double> out(cubes.count());
    for (std::size_t c = 0; c < out.size(); ++c) {
        const std::pair<int, int> of(thickness[c], length[c]);
        const auto [found, fresh] = known.try_emplace(of, 0.0);
        if (fresh) found->second = bend_ratio(of.first, of.second, half_width);
        out[c] = found->second;
    }
    return out;
}

}  // namespace physics
