#include "physics/layers/volume_control.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace physics {
namespace {

struct Controlled {
    std::span<const double> thickness;
    std::vector<double>& translation;

    double limit(std::size_t i) const { return 0.5 * thickness[i]; }
    // How far i really moves when told to move by dtau.
    double move(std::size_t i, double dtau)
    {
        const double before = translation[i];
        translation[i] = std::clamp(before + dtau, -limit(i), limit(i));
        return translation[i] - before;
    }
    bool can(std::size_t i, double way) const
    {
        return way > 0 ? translation[i] < limit(i) : translation[i] > -limit(i);
    }
};

}  // namespace

void control_volume(const VolumeControl& control, const VolumeSense& sense, double dt,
                    std::vector<double>& translation, std::vector<double>& expected)
{
    const std::span<const double> volume = sense.volume, target = sense.target,
                                  target_after = sense.target_after, slope = sense.slope;
    const std::size_t n = translation.size();
    const double gain = -std::expm1(-control.proportional * dt);
    const bool known = expected.size() == n;
    std::map<std::uint32_t, std::vector<std::size_t>> parts;
    for (std::size_t i = 0; i < n; ++i) parts[sense.part.empty() ? 0 : sense.part[i]].push_back(i);

    std::vector<double> least(n);  // C_0
    for (std::size_t i = 0; i < n; ++i) {
        least[i] = 0.1 * std::cbrt(36 * std::numbers::pi * target[i] * target[i]);
    }
    const auto free_slope = [&](std::size_t i) { return slope[i] > least[i] ? slope[i] : 0; };

    Controlled at{sense.thickness, translation};
    std::vector<double> changed(n, 0);  // C_i dtau_i
    for (const auto& [number, members] : parts) {
        double left = 0;
        for (const std::size_t i : members) {
            const double e = volume[i] - target[i];
            const double sought = target_after[i] - target[i], mend = -gain * e;
            left += sought + mend;
            if (known) left -= control.derivative * (e - expected[i]);
            const double C = slope[i], damped = C * C + least[i] * least[i];
            if (!(damped > 0)) continue;
            changed[i] += C * at.move(i, (sought + 0.5 * mend) * C / damped);
            left -= changed[i];
        }
        // Again for what the limits took.
        for (int round = 0; round < 3 && left != 0; ++round) {
            double sum = 0;
            for (const std::size_t i : members) sum += at.can(i, left) ? free_slope(i) : 0;
            if (!(sum > 0)) break;
            const double dtau = left / sum;
            for (const std::size_t i : members) {
                if (!at.can(i, dtau) || !(free_slope(i) > 0)) continue;
                const double change = slope[i] * at.move(i, dtau);
                changed[i] += change;
                left -= change;
            }
        }
    }
    expected.resize(n);
    for (std::size_t i = 0; i < n; ++i) expected[i] = volume[i] - target_after[i] + changed[i];
}

}  // namespace physics
