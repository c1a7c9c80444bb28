#include "physics/layered_bodies/layered_fields.hpp"

#include "physics/layered_bodies/layered_moment.hpp"
#include "physics/layers/deformed_layer.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace physics {

std::vector<LayeredField> layered_fields(const LayeredScene& scene)
{
    const auto moment = std::make_shared<const LayeredMoment>(scene);
    std::vector<LayeredField> out;
    for (std::uint32_t b = 0; b < scene.parts.size(); ++b) {
        if (!has_surface(*scene.parts[b].body)) continue;
        LayeredField layer;
        layer.field = iso_field(deformed(moment->bodies, b, moment->contacts));
        // The moment lives as long as the field is asked.
        layer.field.ask = [moment, ask = std::move(layer.field.ask)](
                              const geometry::FieldBlock& block, geometry::BlockValues& values) {
            ask(block, values);
        };
        layer.compression = [moment, b](const Vec3& p) {
            const Field& field = moment->fields[b];
            return std::max(0.0, geometry::value_at(field, p).f - field.isovalue);
        };
        layer.colour = scene.parts[b].colour;
        layer.name = fmt::format("body {}", b);
        out.push_back(std::move(layer));
    }
    return out;
}

}  // namespace physics
