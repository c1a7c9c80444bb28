#include "render/scene.hpp"

namespace render {

Box bounds(const Scene& scene)
{
    Box box;
    const auto add = [&](const std::vector<Vec3f>& points) {
        for (const Vec3f& p : points) {
            if (p.allFinite()) box.add(p.cast<double>());
        }
    };
    for (const Surface& s : scene.surfaces) add(s.mesh->positions);
    for (const FieldSurface& f : scene.fields) {
        if (!f.extent.empty()) box.add(f.extent);
    }
    for (const Lines& l : scene.lines) add(l.ends);
    for (const Balls& b : scene.balls) add(b.centres);
    return box;
}

}  // namespace render
