#include "physics/state/gusts.hpp"

#include "geometry/base/random.hpp"

#include <cmath>
#include <numbers>

namespace physics {
namespace {

using std::numbers::pi;

// Draws one number after another.
class Draws {
public:
    explicit Draws(std::uint64_t seed) : random_(seed) {}

    double unit() { return random_.unit(next_++); }  // 0 .. 1
    Vec3 direction()
    {
        const double z = 2 * unit() - 1, turn = 2 * pi * unit(), r = std::sqrt(1 - z * z);
        return {r * std::cos(turn), r * std::sin(turn), z};
    }
    Vec3 across(const Vec3& way)  // unit
    {
        for (;;) {
            const Vec3 out = direction().cross(way);
            if (out.norm() > 0.1) return out.normalized();
        }
    }

private:
    geometry::Random random_;
    std::uint64_t next_ = 0;
};

// How much finer than the largest wave wave n of a number is.
double finer(std::size_t n, std::size_t count)
{
    constexpr double finest = 16;
    return std::pow(finest, double(n) / double(count - 1));
}

}  // namespace

void let_pass(const Force& before, double dt, Force& wind)
{
    const double size = 0.5 * (before.gusts.size + wind.gusts.size);
    const double speed = 0.5 * (before.gusts.speed + wind.gusts.speed);
    const Vec3 velocity = 0.5 * (before.velocity + wind.velocity);
    wind.gusts.carried = before.gusts.carried + dt / size * velocity;
    wind.gusts.time = before.gusts.time + dt / size * speed;
}

Air::Air(const Force& wind) : mean_(wind.velocity), gusty_(wind.gusts.speed > 0)
{
    if (!gusty_) return;
    const Gusts& gusts = wind.gusts;
    double sum = 0;
    for (std::size_t n = 0; n < waves; ++n) sum += std::pow(finer(n, waves), -2. / 3);
    Draws draws(gusts.seed);
    for (std::size_t n = 0; n < waves; ++n) {
        Wave& wave = wave_[n];
        const double slower = std::pow(finer(n, waves), -1. / 3);
        const double amplitude = gusts.speed * slower / std::sqrt(sum);
        const Vec3 way = draws.direction();
        const Vec3 k = 2 * pi * finer(n, waves) * way;  // rad in a size
        wave.k = k / gusts.size;
        wave.a = amplitude * draws.across(way);
        wave.b = amplitude * draws.across(way);
        const double turned = 0.4 * k.norm() * slower * gusts.time;
        wave.phase = 2 * pi * draws.unit() + turned - k.dot(gusts.carried);
    }
}

Vec3 Air::at(const Vec3& place) const
{
    Vec3 out = mean_;
    if (!gusty_) return out;
    for (const Wave& wave : wave_) {
        const double phase = wave.k.dot(place) + wave.phase;
        out += std::cos(phase) * wave.a + std::sin(phase) * wave.b;
    }
    return out;
}

}  // namespace physics
