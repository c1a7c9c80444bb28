#include "geometry/io/mesh_text.hpp"

#include <cstdlib>
#include <string>

namespace geometry {

std::from_chars_result number_from(const char* begin, const char* end, double& value)
{
    std::from_chars_result read = std::from_chars(begin, end, value);
    if (read.ec == std::errc::result_out_of_range) {
        value = std::strtod(std::string(begin, read.ptr).c_str(), nullptr);
        read.ec = {};
    }
    return read;
}

std::string_view without_byte_order_mark(std::string_view text)
{
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    return text;
}

}  // namespace geometry
