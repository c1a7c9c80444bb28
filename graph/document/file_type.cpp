#include "graph/document/file_type.hpp"

namespace graph {

std::optional<FileType> file_type(const Json* type)
{
    if (!type || !type->text()) return {};
    FileType f{*type->text(), {}};
    const std::size_t slash = f.path.rfind('/'), at = f.path.rfind('@');
    if (at != std::string::npos && (slash == std::string::npos || at > slash)) {
        f.version = f.path.substr(at + 1);
        f.path.resize(at);
    }
    if (!f.path.ends_with(".json")) return {};
    return f;
}

}  // namespace graph
