#include "render/draw.hpp"

#include "render/captions.hpp"
#include "render/exr.hpp"
#include "render/fill_in.hpp"
#include "render/make_draw_list.hpp"
#include "render/motion_blur.hpp"
#include "render/sample_places.hpp"
#include "render/smooth_edges.hpp"

#include <algorithm>

namespace render {

namespace {

// A picture without words; `linear` gets its light and depths, where the look asks for them.
// `only`: see PictureNumbers.
Image exposed(const Scene& scene, const Camera& camera, const Look& look, int only,
              std::vector<float>& linear, std::vector<std::string>* warnings,
              const std::function<void()>& check)
{
    const DrawList list = make_draw_list(scene, camera, look);
    if (warnings) warnings->insert(warnings->end(), list.warnings.begin(), list.warnings.end());
    Image image{look.width, look.height, {}};
    image.rgba.resize(std::size_t(look.width) * std::size_t(look.height) * 4);
    DrawJob job = draw_job(list, look);
    job.numbers.only = only;
    if (only >= 0) job.numbers.pictures = 1;
    linear.resize(linear_floats(job.numbers));
    fill_in(job, {image.rgba, linear}, check);
    if (look.antialias == Antialias::fxaa) smooth_edges(image);
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
    return image;
}

// The mean of pictures from an open shutter until now; for the final quality each has its samples
// in another place of their pixels: as often in each, and later ones not farther to one side, so
// that what moves across a pixel meets them as what moves back. Time and place are a lattice too.
Image blurred(const Scene& scene, const Camera& camera, const Look& look,
              std::vector<float>& linear, std::vector<std::string>* warnings,
              const std::function<void()>& check)
{
    const bool lattice = look.antialias == Antialias::samples16;
    const int turns = (look.exposures + lattice_samples - 1) / lattice_samples;
    const int count = lattice ? lattice_samples * std::max(turns, 1) : std::max(look.exposures, 1);
    Exposure sum;
    for (int k = 0; k < count; ++k) {
        const double ago = look.shutter * (k + 0.5) / count;
        const int only = lattice ? 5 * k % lattice_samples : -1;
        sum.add(exposed(moment_of(scene, ago), camera, look, only, linear,
                        k == 0 ? warnings : nullptr, check),
                linear);
    }
    linear = sum.mean_linear();
    return sum.mean_picture();
}

}  // namespace

Image draw(const Scene& scene, const Camera& camera, const Look& look,
           std::vector<std::string>* warnings, const std::function<void()>& check)
{
    std::vector<float> linear;
    Image image = look.shutter > 0 && moves(scene)
                      ? blurred(scene, camera, look, linear, warnings, check)
                      : exposed(scene, camera, look, -1, linear, warnings, check);
    if (!linear.empty()) {
        image.light = halves(std::span(linear).first(image.rgba.size()));
        image.depth.assign(linear.begin() + std::ptrdiff_t(image.rgba.size()), linear.end());
    }
    draw_captions(image, camera, scene);
    return image;
}

}  // namespace render
