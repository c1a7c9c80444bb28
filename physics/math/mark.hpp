#pragma once

// A number by which values are told from others, made of their bits.

#include <bit>
#include <cstdint>

namespace physics {

class Mark {
public:
    void add(std::uint64_t word)
    {
        value_ = (value_ ^ word) * 0x9e3779b97f4a7c15u;
        value_ ^= value_ >> 29;
    }
    void add(float number) { add(std::uint64_t{std::bit_cast<std::uint32_t>(number)}); }
    void add(double number) { add(std::bit_cast<std::uint64_t>(number)); }
    std::uint64_t value() const { return value_ * 0xbf58476d1ce4e5b9u; }

private:
    std::uint64_t value_ = 0;
};

}  // namespace physics
