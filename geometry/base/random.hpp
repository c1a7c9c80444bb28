#pragma once

// Random numbers that do not depend on the order in which they are drawn.

#include <cstdint>

namespace geometry {

// Counter-based generator: value `i` of stream `seed` is a pure function of (seed, i), so values
// can be drawn in any order, on any thread, with any standard library, and come out the same.
// Steele, Lea, Flood. Fast splittable pseudorandom number generators. OOPSLA 2014 (SplitMix64).
class Random {
public:
    explicit constexpr Random(std::uint64_t seed) : seed_(seed) {}

    constexpr std::uint64_t bits(std::uint64_t i) const
    {
        std::uint64_t z = seed_ + (i + 1) * 0x9e3779b97f4a7c15u;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }

    // Uniform in [0, 1).
    constexpr double unit(std::uint64_t i) const
    {
        return static_cast<double>(bits(i) >> 11) * 0x1p-53;
    }

private:
    std::uint64_t seed_;
};

}  // namespace geometry
