#include "geometry/fields/iso_extent.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/fields/iso_rays.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace geometry {
namespace {

constexpr int rays_along_cell = 4, closer = 16;

// Rays along one axis, from the grid's low or high side.
class Feeler {
public:
    Feeler(const IsoField& field, const IsoCells& cells, int axis, bool from_high)
        : field_(field), cells_(cells), axis_(axis), u_((axis + 1) % 3), v_((axis + 2) % 3),
          from_high_(from_high)
    {}

    // How far from that side of the grid the surface begins, m; infinite: it is nowhere.
    double depth()
    {
        feel_columns();
        double spacing = cells_.cell / rays_along_cell;
        for (int round = 0; round < 2 && hit_.there(); ++round) {
            const std::array<double, 2> around = {at_[0], at_[1]};
            for (int j = 0; j < closer; ++j) {
                for (int i = 0; i < closer; ++i) {
                    const double half = 0.5 * (closer - 1);
                    add(around[0] + spacing * (i - half) / half,
                        around[1] + spacing * (j - half) / half);
                }
            }
            feel();
            spacing *= 2.0 / (closer - 1);
        }
        return hit_.t;
    }

private:
    struct Column {
        int before = 0, u = 0, v = 0;  // cells before the first that the surface may pass
    };

    // Nearest first: as soon as one is met, those that begin behind it are left.
    void feel_columns()
    {
        std::vector<Column> columns;
        for (int v = 0; v < cells_.dims[v_]; ++v) {
            for (int u = 0; u < cells_.dims[u_]; ++u) {
                for (int k = 0; k < cells_.dims[axis_]; ++k) {
                    Vec3i at;
                    at[axis_] = from_high_ ? cells_.dims[axis_] - 1 - k : k;
                    at[u_] = u;
                    at[v_] = v;
                    if (!(cells_.slope[cells_.index(at)] > 0)) continue;
                    columns.push_back({k, u, v});
                    break;
                }
            }
        }
        std::stable_sort(columns.begin(), columns.end(),
                         [](const Column& a, const Column& b) { return a.before < b.before; });
        for (const Column& column : columns) {
            if (column.before * cells_.cell > hit_.t) break;
            const double step = cells_.cell / rays_along_cell;
            const double u = cells_.lo[u_] + column.u * cells_.cell + 0.5 * step;
            const double v = cells_.lo[v_] + column.v * cells_.cell + 0.5 * step;
            for (int j = 0; j < rays_along_cell; ++j) {
                for (int i = 0; i < rays_along_cell; ++i) add(u + i * step, v + j * step);
            }
            if (rays_.size() >= FieldBlock::capacity) feel();
        }
        feel();
    }

    void add(double u, double v)
    {
        Ray ray;
        ray.origin[axis_] = from_high_ ? cells_.bounds.hi[axis_] : cells_.bounds.lo[axis_];
        ray.origin[u_] = u;
        ray.origin[v_] = v;
        ray.direction = (from_high_ ? -1.0 : 1.0) * Vec3::Unit(axis_);
        ray.begin = -cells_.cell;  // from outside the grid
        ray.end = hit_.t;
        rays_.push_back(ray);
    }

    void feel()
    {
        hits_.resize(rays_.size());
        trace(field_, cells_, rays_, 1e-6 * cells_.cell, hits_);
        for (std::size_t i = 0; i < rays_.size(); ++i) {
            if (!(hits_[i].t < hit_.t)) continue;
            hit_ = hits_[i];
            at_ = {rays_[i].origin[u_], rays_[i].origin[v_]};
        }
        rays_.clear();
    }

    const IsoField& field_;
    const IsoCells& cells_;
    int axis_, u_, v_;
    bool from_high_;
    std::vector<Ray> rays_;
    std::vector<RayHit> hits_;
    RayHit hit_;
    std::array<double, 2> at_{};
};

}  // namespace

Box surface_box(const IsoField& field, const IsoCells& cells)
{
    if (cells.bounds.empty()) return {};
    std::array<double, 6> depth{};
    parallel_for(depth.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            depth[i] = Feeler(field, cells, static_cast<int>(i / 2), i % 2 == 1).depth();
        }
    });
    Box box;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto axis = static_cast<Eigen::Index>(k);
        box.lo[axis] = cells.bounds.lo[axis] + depth[2 * k];
        box.hi[axis] = cells.bounds.hi[axis] - depth[2 * k + 1];
    }
    return box.lo.allFinite() && box.hi.allFinite() ? box : Box{};
}

}  // namespace geometry
