#include "render/four_views.hpp"

#include <algorithm>
#include <numbers>
#include <stdexcept>

namespace render {
namespace {

// The width of the line between two parts, pixels.
int line_between(int height)
{
    return 2 * std::max(1, height / 540);
}

template <class T>
void paste_rows(std::vector<T>& to, int to_width, const std::vector<T>& from, int width, int height,
                std::ptrdiff_t numbers, int x, int y)
{
    if (to.empty() || from.empty()) return;
    for (int row = 0; row < height; ++row) {
        const auto begin = from.begin() + numbers * row * width;
        std::copy(begin, begin + numbers * width,
                  to.begin() + numbers * (std::ptrdiff_t(y + row) * to_width + x));
    }
}

// All light, with room for what a picture of this look has beside its colours.
Image empty_picture(const Look& look)
{
    const std::size_t pixels = std::size_t(look.width) * std::size_t(look.height);
    Image image{look.width, look.height, std::vector<std::uint8_t>(4 * pixels, 230)};
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
    if (look.linear == Linear::none) return image;
    image.light.assign(4 * pixels, 0);
    image.depth.assign(pixels, nothing_there);
    return image;
}

}  // namespace

std::array<int, 2> fourth_size(int width, int height)
{
    return {std::max(1, (width - line_between(height)) / 2),
            std::max(1, (height - line_between(height)) / 2)};
}

std::array<Camera, 4> four_cameras(const Box& box, const Camera& camera, double aspect,
                                   double margin)
{
    constexpr double right_angle = std::numbers::pi / 2;
    const auto view = [&](double azimuth, double elevation) {
        return fit(box, azimuth, elevation, parallel_view, aspect, margin);
    };
    std::array<Camera, 4> cameras{view(0, right_angle), camera, view(0, 0), view(right_angle, 0)};
    double distance = 0;
    const std::array parallel{FourthView::top, FourthView::front, FourthView::side};
    for (const FourthView v : parallel) {
        const Camera& c = cameras[std::size_t(v)];
        distance = std::max(distance, (c.eye - c.target).norm());
    }
    for (const FourthView v : parallel) {
        Camera& c = cameras[std::size_t(v)];
        const Vec3 back = (c.eye - c.target).normalized();
        if (!box.empty()) c.target = box.centre();
        c.eye = c.target + distance * back;
    }
    return cameras;
}

void paste(Image& whole, const Image& part, int x, int y)
{
    if (x < 0 || y < 0 || x + part.width > whole.width || y + part.height > whole.height) {
        throw std::invalid_argument("a part of a picture reaches over its edge");
    }
    paste_rows(whole.rgba, whole.width, part.rgba, part.width, part.height, 4, x, y);
    paste_rows(whole.light, whole.width, part.light, part.width, part.height, 4, x, y);
    paste_rows(whole.depth, whole.width, part.depth, part.width, part.height, 1, x, y);
}

Image four_views(const Scene& scene, const Box& box, const Camera& camera, double margin,
                 const Look& look, std::vector<std::string>* warnings,
                 const std::function<void()>& check)
{
    if (look.width < 16 || look.height < 16) {
        throw std::invalid_argument("four views need a picture of at least 16 x 16 pixels, got " +
                                    std::to_string(look.width) + " x " +
                                    std::to_string(look.height));
    }
    Image whole = empty_picture(look);
    Look part = look;  // all four of one size, so that they are of one scale
    const std::array<int, 2> size = fourth_size(look.width, look.height);
    part.width = size[0], part.height = size[1];
    const auto cameras =
        four_cameras(box, camera, double(part.width) / double(part.height), margin);
    constexpr std::array names{"top", "", "front", "side"};
    for (std::size_t k = 0; k < cameras.size(); ++k) {
        const bool seen = k == std::size_t(FourthView::camera);
        Scene shown = scene;
        if (!seen) {
            shown.legend.reset();
            shown.notes.clear();
        }
        const bool labelled = k == std::size_t(FourthView::front) && !scene.label.empty();
        shown.label = labelled ? scene.label + "\n" + names[k] : names[k];
        const bool right = k % 2 == 1, low = k / 2 == 1;
        paste(whole, draw(shown, cameras[k], part, seen ? warnings : nullptr, check),
              right ? look.width - part.width : 0, low ? look.height - part.height : 0);
    }
    return whole;
}

}  // namespace render
