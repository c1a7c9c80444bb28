// Any text as an expression: an ExpressionError or a number, never a crash.

#include "graph/document/expression.hpp"

#include <string>

namespace {

struct WithAName : graph::Grammar {
    WithAName() { define("scale", 0.5); }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    static const WithAName grammar;
    try {
        const graph::Expression e =
            grammar.compile(std::string(reinterpret_cast<const char*>(data), size));
        static_cast<void>(e.value(7, 0.25));
        static_cast<void>(e.value(-1, -3));
    } catch (const graph::ExpressionError& error) {
        if (error.position > size) __builtin_trap();
    }
    return 0;
}
