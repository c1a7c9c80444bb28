#include "physics/state/pins.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>
#include <string>

namespace physics {
namespace {

// Whether a corner has targets more than `tolerance` apart in the two.
bool conflict(const Pins& p, const Pins& q, double tolerance)
{
    if (p.corner.empty() || q.corner.empty() || p.corner.back() < q.corner.front() ||
        q.corner.back() < p.corner.front()) {
        return false;
    }
    for (std::size_t i = 0, j = 0; i < p.corner.size() && j < q.corner.size();) {
        if (p.corner[i] < q.corner[j]) {
            ++i;
        } else if (q.corner[j] < p.corner[i]) {
            ++j;
        } else {
            const std::uint8_t both = held_axes(p, i) & held_axes(q, j);
            Vec3 apart = p.target[i++] - q.target[j++];
            for (int a = 0; a < 3; ++a) {
                if ((both >> a & 1) == 0) apart[a] = 0;
            }
            if (apart.norm() > tolerance) return true;
        }
    }
    return false;
}

// The same of the points that springs hold.
bool conflict(const HeldMatter& p, const HeldMatter& q, double tolerance)
{
    for (std::size_t i = 0, j = 0; i < p.cubes.size() && j < q.cubes.size();) {
        const HeldCube &a = p.cubes[i], &b = q.cubes[j];
        if (a.cube != b.cube) {
            ++(a.cube < b.cube ? i : j);
            continue;
        }
        for (std::size_t k = 0; k < 8; ++k) {
            Vec3 apart = p.target[a.corner[k]] - q.target[b.corner[k]];
            for (int axis = 0; axis < 3; ++axis) {
                if ((a.axes & b.axes & 1u << axis) == 0) apart[axis] = 0;
            }
            if (apart.norm() > tolerance) return true;
        }
        ++i, ++j;
    }
    return false;
}

void check_matter(const HeldMatter& matter, std::size_t corners)
{
    const auto fail = [](const std::string& what) { throw std::invalid_argument("pins: " + what); };
    if (matter.corner.size() != matter.target.size()) {
        fail("expected a target for each of " + std::to_string(matter.corner.size()) +
             " corners of held points, found " + std::to_string(matter.target.size()));
    }
    for (std::size_t i = 0; i < matter.corner.size(); ++i) {
        const auto k = std::to_string(matter.corner[i]);
        if (matter.corner[i] >= corners) {
            fail("corner " + k + " of held points is not one of the " + std::to_string(corners) +
                 " corners of these cubes. Were the pins made for other cubes?");
        }
        if (!matter.target[i].allFinite()) fail("the target of corner " + k + " is not finite");
    }
    for (const HeldCube& cube : matter.cubes) {
        for (const auto at : cube.corner) {
            if (at < matter.corner.size()) continue;
            fail("a cube of held points names corner " + std::to_string(at) + " of " +
                 std::to_string(matter.corner.size()));
        }
    }
}

void add_matter(const HeldMatter& some, HeldMatter& all)
{
    const auto first = static_cast<std::uint32_t>(all.corner.size());
    all.corner.insert(all.corner.end(), some.corner.begin(), some.corner.end());
    all.target.insert(all.target.end(), some.target.begin(), some.target.end());
    for (std::size_t i = 0; i < some.corner.size(); ++i) {
        all.pivot.push_back(pivot_of(some.pivot, i));
    }
    for (HeldCube cube : some.cubes) {
        for (auto& at : cube.corner) at += first;
        all.cubes.push_back(cube);
    }
}

}  // namespace

void check_pins(const Pins& pins, std::size_t corners)
{
    check_matter(pins.matter, corners);
    const auto fail = [](const std::string& what) { throw std::invalid_argument("pins: " + what); };
    if (pins.corner.size() != pins.target.size()) {
        fail("expected a target for each of " + std::to_string(pins.corner.size()) +
             " corners, found " + std::to_string(pins.target.size()));
    }
    if (!pins.axes.empty() && pins.axes.size() != pins.corner.size()) {
        fail("expected axes of each of " + std::to_string(pins.corner.size()) + " corners, found " +
             std::to_string(pins.axes.size()));
    }
    for (std::size_t i = 0; i < pins.corner.size(); ++i) {
        const auto k = std::to_string(pins.corner[i]);
        if (pins.corner[i] >= corners) {
            fail("corner " + k + " is not one of the " + std::to_string(corners) +
                 " corners of these cubes. Were the pins made for other cubes?");
        }
        if (i > 0 && pins.corner[i] <= pins.corner[i - 1]) {
            fail("expected sorted corners, each once; corner " + k + " is out of order");
        }
        if (!pins.target[i].allFinite()) fail("the target of corner " + k + " is not finite");
        if (held_axes(pins, i) == 0 || held_axes(pins, i) > all_axes) {
            fail("expected axes 1 to 7 of corner " + k + ", found " +
                 std::to_string(held_axes(pins, i)));
        }
    }
}

void require_all_axes(const Pins& pins, const std::string& who)
{
    const auto whole = [](const HeldCube& cube) { return cube.axes == all_axes; };
    if (std::all_of(pins.axes.begin(), pins.axes.end(), [](auto a) { return a == all_axes; }) &&
        std::all_of(pins.matter.cubes.begin(), pins.matter.cubes.end(), whole)) {
        return;
    }
    throw std::invalid_argument(who +
                                " does not take pins that leave axes free: set axes = xyz in Pin, "
                                "or use Simulate with method bricks or springs");
}

void require_corners(const Pins& pins, const std::string& who)
{
    if (pins.matter.cubes.empty()) return;
    throw std::invalid_argument(who + " does not take pins that hold points of the material: set "
                                      "hold = corners in Pin, or use Simulate with method bricks "
                                      "or springs");
}

Pins merge_pins(std::span<const std::shared_ptr<const Pins>> pins, std::size_t corners)
{
    struct Sum {
        Vec3 held = Vec3::Zero(), all = Vec3::Zero();
        std::array<int, 3> holders{};
        int count = 0;
        Vec3 pivot = pivot_of({}, 0);  // the first that is told
    };
    std::map<std::uint32_t, Sum> sums;
    for (const auto& some : pins) {
        check_pins(*some, corners);
        for (std::size_t i = 0; i < some->corner.size(); ++i) {
            Sum& sum = sums[some->corner[i]];
            sum.all += some->target[i];
            ++sum.count;
            if (!sum.pivot.allFinite()) sum.pivot = pivot_of(some->pivot, i);
            for (unsigned a = 0; a < 3; ++a) {
                if ((held_axes(*some, i) >> a & 1) == 0) continue;
                sum.held[a] += some->target[i][a];
                ++sum.holders[a];
            }
        }
    }
    Pins out;
    bool whole = true;
    for (const auto& [corner, sum] : sums) {
        Vec3 target = sum.all / sum.count;
        std::uint8_t axes = 0;
        for (unsigned a = 0; a < 3; ++a) {
            if (sum.holders[a] == 0) continue;
            target[a] = sum.held[a] / sum.holders[a];
            axes = static_cast<std::uint8_t>(axes | 1u << a);
        }
        out.corner.push_back(corner);
        out.target.push_back(target);
        out.pivot.push_back(sum.pivot);
        out.axes.push_back(axes);
        whole &= axes == all_axes;
    }
    if (whole) out.axes.clear();
    for (const auto& some : pins) add_matter(some->matter, out.matter);
    return out;
}

std::vector<std::string> conflicting_pins(std::span<const std::shared_ptr<const Pins>> pins,
                                          double tolerance)
{
    std::vector<std::string> out;
    for (std::size_t i = 0; i < pins.size(); ++i) {
        for (std::size_t j = i + 1; j < pins.size(); ++j) {
            const bool points = conflict(pins[i]->matter, pins[j]->matter, tolerance);
            if (!points && !conflict(*pins[i], *pins[j], tolerance)) continue;
            out.push_back(fmt::format(
                "Pins {} and {} of {} pull the same corners to different places: these corners go "
                "to the mean of both. Pin separate regions, or give both the same motion.",
                i + 1, j + 1, pins.size()));
        }
    }
    return out;
}

}  // namespace physics
