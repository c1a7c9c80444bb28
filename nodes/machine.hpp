#pragma once

// What the nodes need of the machine and of each other's kernels, for the program's own commands.

#include "nodes/wire_types.hpp"
#include "render/contact_sheet.hpp"
#include "render/gl_context.hpp"
#include "render/png.hpp"

#include <array>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace nodes {

// The OpenGL that pictures are drawn with; throws std::runtime_error when it will not do.
inline std::string opengl()
{
    return render::gl_version();
}

// Libraries that are loaded when a node comes to need them.
inline constexpr std::array late_libraries{render::opengl_library};

// Writes pictures with their labels side by side as one PNG, and returns how many there were.
// Values that are no pictures are left out.
inline std::size_t write_sheet(const std::vector<std::pair<graph::Value, std::string>>& pictures,
                               int columns, const std::filesystem::path& path)
{
    std::vector<graph::Wire<render::Image>> images;
    std::vector<render::Tile> tiles;
    for (const auto& [value, label] : pictures) {
        if (!value || *value.type()->type != typeid(render::Image)) continue;
        images.push_back(value.as<render::Image>());
        tiles.push_back({images.back().get(), label});
    }
    if (!tiles.empty()) render::write_png(path, render::contact_sheet(tiles, columns, 1600));
    return tiles.size();
}

}  // namespace nodes
