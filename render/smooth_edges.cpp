#include "render/smooth_edges.hpp"

#include "geometry/base/parallel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace render {
namespace {

// Less of a jump is no edge: of 255, and of the brighter side.
constexpr int least_jump = 9, least_share = 8;

constexpr std::array<int, 7> stations{1, 2, 3, 4, 6, 8, 10};  // pixels from where a walk starts

// Brightness, with a frame of one more pixel around it, like the pixels next to it.
struct Brightness {
    std::size_t stride;
    std::vector<std::uint8_t> all;

    const std::uint8_t* row(int y) const { return &all[std::size_t(y + 1) * stride + 1]; }
};

Brightness brightness_of(const Image& image)
{
    const std::size_t w = std::size_t(image.width), h = std::size_t(image.height);
    Brightness out{w + 2, std::vector<std::uint8_t>((w + 2) * (h + 2))};
    for (std::size_t y = 0; y < h + 2; ++y) {
        const std::uint8_t* from =
            &image.rgba[4 * w * std::min(std::max(y, std::size_t{1}) - 1, h - 1)];
        std::uint8_t* to = &out.all[y * out.stride];
        for (std::size_t x = 0; x < w; ++x) to[x + 1] = from[4 * x + 3];
        to[0] = to[1];
        to[w + 1] = to[w];
    }
    return out;
}

// 255 where the brightness jumps between a pixel and its neighbours.
void mark(const Brightness& b, int y, int width, std::uint8_t* marks)
{
    const std::uint8_t *n = b.row(y - 1), *m = b.row(y), *s = b.row(y + 1);
    for (int x = 0; x < width; ++x) {
        const std::uint8_t low = std::min({m[x], m[x - 1], m[x + 1], n[x], s[x]});
        const std::uint8_t high = std::max({m[x], m[x - 1], m[x + 1], n[x], s[x]});
        const int jump = high - low;
        marks[x] = jump >= least_jump && least_share * jump >= high ? 255 : 0;
    }
}

// How a marked pixel mixes with a neighbour.
struct Mix {
    int dx = 0, dy = 0;  // to the neighbour
    float share = 0;     // of it
};

class Walker {
public:
    Walker(const Brightness& b, int width, int height) : b_(b), width_(width), height_(height) {}

    Mix mix_at(int x, int y) const
    {
        const std::uint8_t *r0 = b_.row(y - 1) + x, *r1 = b_.row(y) + x, *r2 = b_.row(y + 1) + x;
        const int nw = r0[-1], n = r0[0], ne = r0[1], w = r1[-1], m = r1[0], e = r1[1];
        const int sw = r2[-1], s = r2[0], se = r2[1];
        const int over_rows =
            std::abs(nw + sw - 2 * w) + 2 * std::abs(n + s - 2 * m) + std::abs(ne + se - 2 * e);
        const int over_columns =
            std::abs(nw + ne - 2 * n) + 2 * std::abs(w + e - 2 * m) + std::abs(sw + se - 2 * s);
        const bool level = over_rows >= over_columns;  // the edge runs along a row
        const int before = level ? n : w, after = level ? s : e;
        const bool to_before = std::abs(before - m) >= std::abs(after - m);
        const int side = to_before ? -1 : 1, other = to_before ? before : after;
        Mix out{level ? 0 : side, level ? side : 0, 0};

        // A lone bright or dark pixel has no edge to follow: blend it by how much it stands out.
        const int range = std::max({m, n, s, w, e}) - std::min({m, n, s, w, e});
        const float mean = float(2 * (n + s + w + e) + nw + ne + sw + se) / 12;
        const float out_by = std::min(1.0f, std::abs(mean - float(m)) / float(range));
        const float lone = out_by * out_by * (3 - 2 * out_by);
        out.share = std::max(shift(x, y, level, out, m, other), 0.6f * lone * lone);
        return out;
    }

private:
    // How far along its stair the pixel is: half a pixel at the stair's end, none in its middle.
    float shift(int x, int y, bool level, const Mix& to, int m, int other) const
    {
        // All brightnesses here are of two pixels together, one on each side of the edge.
        const int edge = m + other, jump = std::abs(other - m);
        std::array<int, 2> reach{}, found{};
        for (const int k : {0, 1}) {
            const int sign = k == 0 ? -1 : 1;
            for (const int far : stations) {
                const int px = level ? x + sign * far : x, py = level ? y : y + sign * far;
                found[std::size_t(k)] = at(px, py) + at(px + to.dx, py + to.dy) - edge;
                reach[std::size_t(k)] = far;
                if (2 * std::abs(found[std::size_t(k)]) >= jump) break;
            }
        }
        const std::size_t end = reach[0] < reach[1] ? 0 : 1;
        const bool stair = (found[end] < 0) != (2 * m < edge);
        return stair ? 0.5f - float(reach[end]) / float(reach[0] + reach[1]) : 0.0f;
    }

    int at(int x, int y) const
    {
        return b_.row(std::clamp(y, -1, height_))[std::clamp(x, -1, width_)];
    }

    const Brightness& b_;
    int width_, height_;
};

}  // namespace

void smooth_edges(Image& image)
{
    if (image.width == 0 || image.height == 0) return;
    const Brightness b = brightness_of(image);
    const std::vector<std::uint8_t> before = image.rgba;
    const Walker walker(b, image.width, image.height);
    const std::size_t width = std::size_t(image.width);
    geometry::parallel_for(std::size_t(image.height), 16, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint8_t> marks(width);
        for (std::size_t y = begin; y < end; ++y) {
            mark(b, int(y), image.width, marks.data());
            const std::uint8_t* at = marks.data();
            const std::uint8_t* last = at + width;
            for (; (at = static_cast<const std::uint8_t*>(
                        std::memchr(at, 255, std::size_t(last - at))));
                 ++at) {
                const std::size_t x = std::size_t(at - marks.data());
                const Mix mix = walker.mix_at(int(x), int(y));
                const std::size_t nx = std::size_t(std::clamp(int(x) + mix.dx, 0, image.width - 1));
                const std::size_t ny =
                    std::size_t(std::clamp(int(y) + mix.dy, 0, image.height - 1));
                const std::uint8_t* here = &before[4 * (y * width + x)];
                const std::uint8_t* there = &before[4 * (ny * width + nx)];
                std::uint8_t* to = &image.rgba[4 * (y * width + x)];
                for (int k = 0; k < 3; ++k) {
                    const float c = float(here[k]) + mix.share * float(there[k] - here[k]);
                    to[k] = std::uint8_t(c + 0.5f);
                }
            }
        }
    });
}

}  // namespace render
