#include "geometry/io/assimp/collada_lenses.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>

namespace geometry::assimp {
namespace {

// What is between the first tag and the last of an element; from npos where there is none.
struct Content {
    std::size_t from = std::string::npos, to = 0;
};

// Of the first element of that name within [from, to).
Content content_of(const std::string& text, const std::string& name, std::size_t from,
                   std::size_t to)
{
    const std::string opening = '<' + name;
    for (std::size_t at = text.find(opening, from); at < to; at = text.find(opening, at + 1)) {
        const std::size_t after = at + opening.size();
        const std::size_t end = text.find_first_of("<>", after);
        if (end >= to || text[end] == '<') continue;
        if (after < end && std::string(" \t\r\n").find(text[after]) == std::string::npos) continue;
        const std::size_t close = text.find("</" + name, end);
        if (text[end - 1] != '/' && close < to) return {end + 1, close};
    }
    return {};
}

double number_in(const std::string& text, const std::string& name, const Content& within)
{
    const Content number = content_of(text, name, within.from, within.to);
    if (number.from == std::string::npos) return 0;
    return std::strtod(text.substr(number.from, number.to - number.from).c_str(), nullptr);
}

void blank_comments(std::string& text)
{
    for (std::size_t at = text.find("<!--"); at != std::string::npos; at = text.find("<!--", at)) {
        const std::size_t end = text.find("-->", at + 4);
        if (end == std::string::npos) return;
        std::fill(text.begin() + std::ptrdiff_t(at), text.begin() + std::ptrdiff_t(end) + 3, ' ');
    }
}

// assimp 5.2 reads a lens of cameras that have a name, which COLLADA does not ask for. Of two it
// takes the first, and calls the camera by its node.
void name_cameras(std::string& text)
{
    const std::string camera = "<camera", name = " name=\"camera\"";
    for (std::size_t at = text.find(camera); at != std::string::npos; at = text.find(camera, at)) {
        at += camera.size();
        const bool whole = at < text.size() && std::string(" \t\r\n").find(text[at]) != text.npos;
        if (whole) text.insert(at, name);
    }
}

}  // namespace

std::vector<ColladaLens> number_lenses(std::string& text)
{
    std::vector<ColladaLens> out;
    blank_comments(text);
    name_cameras(text);
    for (const bool parallel : {false, true}) {
        const std::string name = parallel ? "orthographic" : "perspective";
        const std::string x = parallel ? "xmag" : "xfov", y = parallel ? "ymag" : "yfov";
        for (std::size_t at = 0;;) {
            const Content lens = content_of(text, name, at, text.size());
            if (lens.from == std::string::npos) break;
            out.push_back({parallel, number_in(text, x, lens), number_in(text, y, lens),
                           number_in(text, "aspect_ratio", lens)});
            const std::string number = "<zfar>-" + std::to_string(out.size()) + "</zfar>";
            text.replace(lens.from, lens.to - lens.from, number);
            at = lens.from + number.size();
        }
    }
    return out;
}

std::size_t lens_number(float far_plane)
{
    return far_plane <= -1 ? std::size_t(-far_plane) - 1 : std::numeric_limits<std::size_t>::max();
}

void set_lens(const ColladaLens& lens, ImportedCamera& camera)
{
    const auto reach = [&](double said) {
        return lens.parallel ? said : std::tan(said * std::numbers::pi / 360);
    };
    const double width = reach(lens.width), height = reach(lens.height);
    double aspect = lens.aspect;
    // Of a height alone the width is unknown and does not count: it is square.
    if (!(aspect > 0) && lens.height > 0) aspect = lens.width > 0 ? width / height : 1;
    const double half = lens.width > 0 ? width : height * aspect;
    camera.aspect = float(aspect);
    camera.half_width = lens.parallel ? float(half) : 0;
    camera.width_angle = lens.parallel ? 0 : float(2 * std::atan(half));
}

}  // namespace geometry::assimp
