#include "graph/types/decode.hpp"

#include <tbb/parallel_for.h>

namespace graph {

void detail::copy_bytes(char* to, const char* from, std::size_t size)
{
    constexpr std::size_t large = std::size_t{4} << 20, piece = std::size_t{1} << 20;
    if (size < large) {
        if (size > 0) std::memcpy(to, from, size);
        return;
    }
    tbb::parallel_for(std::size_t{0}, (size + piece - 1) / piece, [&](std::size_t k) {
        std::memcpy(to + k * piece, from + k * piece, std::min(piece, size - k * piece));
    });
}

}  // namespace graph
