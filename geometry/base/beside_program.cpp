#include "geometry/base/beside_program.hpp"

#include <unistd.h>

namespace geometry {

std::filesystem::path beside_program(const std::string& name)
{
    std::error_code none;
    const std::filesystem::path here =
        std::filesystem::read_symlink("/proc/self/exe", none).parent_path();
    for (const auto& folder : {here, here.parent_path(), here / "../libexec/aspic"}) {
        if (::access((folder / name).c_str(), R_OK) == 0) return folder / name;
    }
    return {};
}

}  // namespace geometry
