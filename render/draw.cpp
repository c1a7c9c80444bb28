#include "render/draw.hpp"

#include "render/captions.hpp"
#include "render/exr.hpp"
#include "render/fill_in.hpp"
#include "render/legend.hpp"
#include "render/make_draw_list.hpp"
#include "render/smooth_edges.hpp"

namespace render {

Image draw(const Scene& scene, const Camera& camera, const Look& look,
           std::vector<std::string>* warnings, const std::function<void()>& check)
{
    const DrawList list = make_draw_list(scene, camera, look);
    if (warnings) warnings->insert(warnings->end(), list.warnings.begin(), list.warnings.end());
    Image image{look.width, look.height, {}};
    image.rgba.resize(std::size_t(look.width) * std::size_t(look.height) * 4);
    const DrawJob job = draw_job(list, look);
    std::vector<float> linear(linear_floats(job.numbers));
    fill_in(job, {image.rgba, linear}, check);
    if (!linear.empty()) {
        image.light = halves(std::span(linear).first(image.rgba.size()));
        image.depth.assign(linear.begin() + std::ptrdiff_t(image.rgba.size()), linear.end());
    }
    if (look.antialias == Antialias::fxaa) smooth_edges(image);
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
    const double taken = scene.legend ? width_of(*scene.legend, image.width, image.height) : 0;
    draw_notes(image, camera, scene.notes, taken);
    if (scene.legend) draw_legend(image, *scene.legend);
    if (!scene.label.empty()) draw_label(image, scene.label);
    return image;
}

}  // namespace render
