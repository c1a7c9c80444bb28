#include "geometry/fields/iso_field.hpp"

#include "geometry/fields/evaluate_block.hpp"

namespace geometry {

IsoField iso_field(const Field& field)
{
    IsoField iso;
    iso.domain = influence(field);
    iso.bounds = [&field](const Box& box) {
        thread_local std::vector<std::uint32_t> near;
        candidates(field, box, near);
        const Interval range = bounds(field, near, box);
        return Interval{range.lo - field.isovalue, range.hi - field.isovalue};
    };
    iso.steepness = [&field](const Box& box) {
        thread_local std::vector<std::uint32_t> near;
        candidates(field, box, near);
        return Steepness{slope_bound(field, near, box)};
    };
    iso.ask = [&field](const FieldBlock& block, BlockValues& values) {
        thread_local std::vector<std::uint32_t> near;
        thread_local FieldScratch scratch;
        Box box;
        for (std::size_t i = 0; i < block.count; ++i) box.add(block.point(i));
        candidates(field, box, near);
        evaluate(field, near, block, scratch, values);
        for (std::size_t i = 0; i < block.count; ++i) values.f[i] -= field.isovalue;
    };
    return iso;
}

}  // namespace geometry
