#include "render/draw.hpp"

#include "render/legend.hpp"
#include "render/renderer.hpp"

#include <mutex>

namespace render {
namespace {

// Renderers that nobody is using. They are never destroyed: at the end of the program OSMesa's own
// statics may already be gone.
class Pool {
public:
    static Pool& shared()
    {
        static Pool& pool = *new Pool;
        return pool;
    }

    std::unique_ptr<Renderer> take()
    {
        {
            const std::lock_guard lock(mutex_);
            if (!idle_.empty()) {
                auto renderer = std::move(idle_.back());
                idle_.pop_back();
                return renderer;
            }
        }
        return std::make_unique<Renderer>();
    }
    void give_back(std::unique_ptr<Renderer> renderer)
    {
        const std::lock_guard lock(mutex_);
        idle_.push_back(std::move(renderer));
    }

private:
    std::mutex mutex_;
    std::vector<std::unique_ptr<Renderer>> idle_;
};

// What OpenGL takes for a picture of this list, generously.
std::size_t bytes_to_draw(const DrawList& list, const Look& look)
{
    constexpr std::size_t compiler = 48 << 20;              // of the shaders
    constexpr std::size_t a_pixel = 28, a_sample = 4 * 16;  // see Renderer::Gl
    const std::size_t pixels =
        static_cast<std::size_t>(look.width) * static_cast<std::size_t>(look.height);
    const std::size_t texels =
        static_cast<std::size_t>(list.shadow.width) * static_cast<std::size_t>(list.shadow.height);
    return compiler + pixels * (a_pixel + a_sample) + 4 * texels +
           2 * (list.vertices.size() * sizeof(Vertex) + list.indices.size() * 4);
}

}  // namespace

Image draw(const Scene& scene, const Camera& camera, const Look& look,
           std::vector<std::string>* warnings)
{
    const DrawList list = draw_list(scene, camera, look);
    if (warnings) warnings->insert(warnings->end(), list.warnings.begin(), list.warnings.end());
    const RoomToDraw room(bytes_to_draw(list, look));
    auto renderer = Pool::shared().take();
    Image image = renderer->draw(list, look);
    Pool::shared().give_back(std::move(renderer));  // one that threw is not used again
    if (scene.legend) draw_legend(image, *scene.legend);
    if (!scene.label.empty()) draw_label(image, scene.label);
    return image;
}

}  // namespace render
