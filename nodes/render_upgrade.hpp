#pragma once

// What older versions of Render become.

#include "graph/document/json.hpp"

#include <string>

namespace nodes::render {

// Version 1 had one look: a hard light over a dark floor with a grid.
inline void say_old_look(graph::Json& node)
{
    graph::Json* const params = graph::put_missing(node, "params", graph::Json::Object());
    if (!params) return;
    const auto colour = [](double r, double g, double b) {
        return graph::Json::Array{graph::Json{r}, graph::Json{g}, graph::Json{b}};
    };
    graph::put_missing(*params, "look", std::string("plain"));
    const graph::Json* const antialias = params->find("antialias");
    const std::string* const named = antialias ? antialias->text() : nullptr;
    std::string quality = "preview";
    if (named && *named == "none") quality = "draft";
    if (named && *named == "samples4") quality = "standard";
    graph::erase(*params, "antialias");
    graph::put_missing(*params, "quality", std::move(quality));
    if (auto* light = graph::put_missing(*params, "light", graph::Json::Object())) {
        graph::put_missing(*light, "rim", 0.0);
    }
    if (auto* camera = graph::put_missing(*params, "camera", graph::Json::Object())) {
        const graph::Json* const kind = camera->find("kind");
        const std::string* const stands = kind ? kind->text() : nullptr;
        if (!stands || *stands != "look_at") {
            graph::put_missing(*camera, "hold", std::string("box"));
        }
    }
    if (auto* ground = graph::put_missing(*params, "ground", graph::Json::Object())) {
        graph::put_missing(*ground, "grid", true);
        graph::put_missing(*ground, "colour", colour(0.34, 0.34, 0.34));
    }
    if (auto* backdrop = graph::put_missing(*params, "backdrop", graph::Json::Object())) {
        graph::put_missing(*backdrop, "top", colour(0.10, 0.12, 0.15));
        graph::put_missing(*backdrop, "horizon", colour(0.40, 0.42, 0.45));
    }
}

}  // namespace nodes::render
