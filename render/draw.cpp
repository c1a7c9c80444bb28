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

}  // namespace

Image draw(const Scene& scene, const Camera& camera, const Look& look,
           std::vector<std::string>* warnings)
{
    const DrawList list = draw_list(scene, camera, look);
    if (warnings) warnings->insert(warnings->end(), list.warnings.begin(), list.warnings.end());
    auto renderer = Pool::shared().take();
    Image image = renderer->draw(list, look);
    Pool::shared().give_back(std::move(renderer));  // one that threw is not used again
    if (scene.legend) draw_legend(image, *scene.legend);
    if (!scene.label.empty()) draw_label(image, scene.label);
    return image;
}

}  // namespace render
