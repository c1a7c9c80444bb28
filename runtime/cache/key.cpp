#include "runtime/cache/key.hpp"

#include <charconv>

// Compiled in: most keys are of less than a hundred bytes, where the call would be a third.
#define XXH_INLINE_ALL
#include <xxhash.h>

namespace runtime {

std::string to_hex(const Key& key)
{
    char text[33];
    std::snprintf(text, sizeof text, "%016llx%016llx", static_cast<unsigned long long>(key.high),
                  static_cast<unsigned long long>(key.low));
    return text;
}

Key from_hex(std::string_view text)
{
    Key key;
    if (text.size() != 32) return {};
    const auto read = [](std::string_view digits, std::uint64_t& word) {
        const auto [end, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), word, 16);
        return error == std::errc{} && end == digits.data() + digits.size();
    };
    const bool good = read(text.substr(0, 16), key.high) && read(text.substr(16), key.low);
    return good ? key : Key{};
}

Key hash_bytes(const void* data, std::size_t size)
{
    const XXH128_hash_t hash = XXH3_128bits(data, size);
    return {hash.low64, hash.high64};
}

void KeyBuilder::append_long(const void* data, std::size_t size)
{
    if (long_.empty()) long_.assign(short_.data(), size_);
    long_.append(static_cast<const char*>(data), size);
    size_ = short_.size() + 1;
}

KeyBuilder& KeyBuilder::add_content(const graph::ParamValue& value)
{
    std::visit(
        [this](const auto& is) {
            using T = std::decay_t<decltype(is)>;
            if constexpr (std::is_arithmetic_v<T>) {
                add(is);
            } else if constexpr (std::is_same_v<T, std::array<double, 3>>) {
                for (const double x : is) add(x);
            } else if constexpr (std::is_same_v<T, std::string>) {
                add(std::string_view(is));
            } else if constexpr (std::is_same_v<T, graph::ParamValues>) {
                add(is.size());
                for (const graph::ParamValue& child : is) add(child);
            }
        },
        value.is);
    return *this;
}

}  // namespace runtime
