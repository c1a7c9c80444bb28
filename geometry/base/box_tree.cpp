#include "geometry/base/box_tree.hpp"

#include "geometry/base/stop.hpp"

#include <algorithm>
#include <numeric>

namespace geometry {
namespace {

constexpr std::uint32_t bins = 16;
constexpr int balanced_depth = 56;  // below it every cut halves: max_depth is never reached

float half_area(const Box3f& b)
{
    const Vec3f d = (b.hi - b.lo).cwiseMax(0.0f);
    return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
}

struct Range {
    std::uint32_t node, begin, end;
    int depth;
};

// Items are moved along with their boxes, so that a pass over a range reads memory in order.
struct Item {
    Box3f box;
    Vec3f centre;
    std::uint32_t index;
};

// Puts the items of `r` into two non-empty parts; returns where the second begins.
std::uint32_t cut(std::vector<Item>& items, const Range& r, const Box3f& centres)
{
    const auto first = items.begin() + r.begin, last = items.begin() + r.end;
    const std::uint32_t middle = r.begin + (r.end - r.begin) / 2;
    Eigen::Index axis = 0;
    const Vec3f extent = centres.hi - centres.lo;
    extent.maxCoeff(&axis);
    const auto halve = [&] {
        std::nth_element(first, items.begin() + middle, last, [axis](const auto& a, const auto& b) {
            return std::pair(a.centre[axis], a.index) < std::pair(b.centre[axis], b.index);
        });
        return middle;
    };
    if (!(extent[axis] > 0) || r.depth >= balanced_depth || r.end - r.begin < 5) return halve();

    const float scale = static_cast<float>(bins) / extent[axis];
    const float lo = centres.lo[axis];
    const auto bin_of = [=](const Item& item) {
        const float at = (item.centre[axis] - lo) * scale;
        return at < static_cast<float>(bins) ? static_cast<std::uint32_t>(at) : bins - 1;
    };
    std::array<Box3f, bins> box;
    std::array<std::uint32_t, bins> count{};
    for (auto item = first; item != last; ++item) {
        const std::uint32_t b = bin_of(*item);
        box[b].add(item->box);
        ++count[b];
    }
    std::array<float, bins> right_cost{};
    Box3f side;
    std::uint32_t side_count = 0;
    for (std::uint32_t b = bins - 1; b > 0; --b) {
        side.add(box[b]);
        side_count += count[b];
        right_cost[b] = side_count > 0 ? half_area(side) * static_cast<float>(side_count) : 0;
    }
    side = {};
    side_count = 0;
    std::uint32_t best = 0;
    float best_cost = std::numeric_limits<float>::infinity();
    for (std::uint32_t b = 1; b < bins; ++b) {
        side.add(box[b - 1]);
        side_count += count[b - 1];
        if (side_count == 0 || side_count == r.end - r.begin) continue;
        const float cost = half_area(side) * static_cast<float>(side_count) + right_cost[b];
        if (cost < best_cost) best_cost = cost, best = b;
    }
    if (best == 0) return halve();
    const auto split = std::partition(first, last, [&](const Item& i) { return bin_of(i) < best; });
    return static_cast<std::uint32_t>(split - items.begin());
}

}  // namespace

BoxTree build_box_tree(std::span<const Box3f> boxes, std::uint32_t leaf_size)
{
    BoxTree tree;
    if (boxes.empty()) return tree;
    std::vector<Item> items(boxes.size());
    for (std::uint32_t i = 0; i < items.size(); ++i) {
        items[i] = {boxes[i], 0.5f * boxes[i].lo + 0.5f * boxes[i].hi, i};
    }
    tree.nodes.reserve(boxes.size());
    tree.nodes.emplace_back();
    std::vector<Range> todo{{0, 0, static_cast<std::uint32_t>(items.size()), 0}};
    StopCheck check;
    while (!todo.empty()) {
        check();
        const Range r = todo.back();
        todo.pop_back();
        Box3f box, centres;
        for (std::uint32_t i = r.begin; i < r.end; ++i) {
            box.add(items[i].box);
            centres.add(items[i].centre);
        }
        tree.nodes[r.node].box = box;
        if (r.end - r.begin <= leaf_size) {
            tree.nodes[r.node].first = r.begin;
            tree.nodes[r.node].count = r.end - r.begin;
            continue;
        }
        const std::uint32_t middle = cut(items, r, centres);
        const auto left = static_cast<std::uint32_t>(tree.nodes.size());
        tree.nodes[r.node].first = left;
        tree.nodes.resize(tree.nodes.size() + 2);
        todo.push_back({left + 1, middle, r.end, r.depth + 1});
        todo.push_back({left, r.begin, middle, r.depth + 1});
    }
    tree.items.resize(items.size());
    for (std::size_t i = 0; i < items.size(); ++i) tree.items[i] = items[i].index;
    return tree;
}

}  // namespace geometry
