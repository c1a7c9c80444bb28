#pragma once

// A binary tree of boxes over any items that have one: triangles, cubes, bodies. Built top-down by
// the surface area heuristic over bins:
// Wald. On fast construction of SAH-based bounding volume hierarchies. IEEE RT 2007.

#include "geometry/base/vec.hpp"

#include <span>
#include <vector>

namespace geometry {

struct Box3f {
    Vec3f lo = Vec3f::Constant(std::numeric_limits<float>::infinity());
    Vec3f hi = Vec3f::Constant(-std::numeric_limits<float>::infinity());

    void add(const Vec3f& p)
    {
        lo = lo.cwiseMin(p);
        hi = hi.cwiseMax(p);
    }
    void add(const Box3f& b)
    {
        lo = lo.cwiseMin(b.lo);
        hi = hi.cwiseMax(b.hi);
    }
    bool overlaps(const Box3f& b) const
    {
        return (lo.array() <= b.hi.array()).all() && (b.lo.array() <= hi.array()).all();
    }
    // Squared distance from p, 0 inside.
    double distance_sq(const Vec3& p) const
    {
        return (lo.cast<double>() - p)
            .cwiseMax(p - hi.cast<double>())
            .cwiseMax(Vec3::Zero())
            .squaredNorm();
    }
};

struct BoxTree {
    struct Node {
        Box3f box;
        std::uint32_t first = 0;  // leaf: into items. Inner: the left child, the right one follows
        std::uint32_t count = 0;  // items in a leaf, 0 for an inner node
    };
    static constexpr int max_depth = 96;

    std::vector<Node> nodes;           // nodes[0] is the root; a child comes after its parent
    std::vector<std::uint32_t> items;  // indices of the boxes, leaf by leaf

    // Calls visit(item, best_sq) for items whose box is nearer to p than sqrt(best_sq), nearest
    // boxes first; visit lowers best_sq when it finds something nearer.
    template <class Visit> void nearest(const Vec3& p, double& best_sq, const Visit& visit) const;

    // Calls visit(item) for every item whose leaf's box overlaps `box`, in no special order.
    template <class Visit> void overlapping(const Box3f& box, const Visit& visit) const;
};

// Leaves hold at most `leaf_size` boxes, unless all their centres coincide; even then.
// Boxes must be finite.
BoxTree build_box_tree(std::span<const Box3f> boxes, std::uint32_t leaf_size = 4);

template <class Visit>
void BoxTree::nearest(const Vec3& p, double& best_sq, const Visit& visit) const
{
    if (nodes.empty()) return;
    struct Entry {
        std::uint32_t node;
        double distance_sq;
    };
    std::array<Entry, max_depth + 1> stack;
    int top = 0;
    stack[0] = {0, nodes[0].box.distance_sq(p)};
    while (top >= 0) {
        const Entry entry = stack[static_cast<std::size_t>(top--)];
        if (!(entry.distance_sq < best_sq)) continue;
        const Node* node = &nodes[entry.node];
        while (node->count == 0) {  // down the nearer child, the other one later
            std::uint32_t near = node->first, far = near + 1;
            double near_sq = nodes[near].box.distance_sq(p);
            double far_sq = nodes[far].box.distance_sq(p);
            if (far_sq < near_sq) std::swap(near, far), std::swap(near_sq, far_sq);
            if (far_sq < best_sq) stack[static_cast<std::size_t>(++top)] = {far, far_sq};
            node = &nodes[near];
            if (!(near_sq < best_sq)) break;
        }
        for (std::uint32_t i = 0; i < node->count; ++i) visit(items[node->first + i], best_sq);
    }
}

template <class Visit> void BoxTree::overlapping(const Box3f& box, const Visit& visit) const
{
    if (nodes.empty()) return;
    std::array<std::uint32_t, max_depth + 1> stack;
    std::size_t count = 1;
    stack[0] = 0;
    while (count > 0) {
        const Node& node = nodes[stack[--count]];
        if (!node.box.overlaps(box)) continue;
        if (node.count == 0) {
            stack[count++] = node.first + 1;
            stack[count++] = node.first;
        }
        for (std::uint32_t i = 0; i < node.count; ++i) visit(items[node.first + i]);
    }
}

}  // namespace geometry
