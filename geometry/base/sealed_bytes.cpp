#include "geometry/base/sealed_bytes.hpp"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <stdexcept>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace geometry {

static_assert(std::endian::native == std::endian::little);

namespace {

struct Seal {
    std::uint64_t size = 0;
    ContentHash hash{};
};
static_assert(sizeof(Seal) == 24);

// The text with what is no printable character as dots.
std::string printable(std::string_view text)
{
    std::string out;
    for (const char c : text) out += c >= ' ' && c <= '~' ? c : '.';
    return out;
}

// Takes the line of kind and version off.
std::string_view after_line(std::string_view kind, int version, std::string_view bytes)
{
    const bool right =
        bytes.starts_with(kind) && bytes.size() > kind.size() && bytes[kind.size()] == ' ';
    const std::size_t end = bytes.substr(0, kind.size() + 16).find('\n');
    int found = 0;
    const char* const number = bytes.data() + kind.size() + 1;
    if (!right || end == std::string_view::npos ||
        std::from_chars(number, bytes.data() + end, found).ptr != bytes.data() + end) {
        throw std::runtime_error(
            fmt::format("expected a file that begins with \"{} {}\", found {}", kind, version,
                        bytes.empty() ? "an empty file"
                                      : fmt::format("\"{}\"", printable(bytes.substr(0, 24)))));
    }
    if (found != version) {
        throw std::runtime_error(
            fmt::format("expected version {} of {}, found version {}: write the file again, or "
                        "read it with the Aspic that wrote it",
                        version, kind, found));
    }
    return bytes.substr(end + 1);
}

}  // namespace

std::string seal(std::string_view kind, int version, std::string_view content)
{
    const Seal made{content.size(), hash_of(content)};
    std::string bytes = fmt::format("{} {}\n", kind, version);
    bytes.append(reinterpret_cast<const char*>(&made), sizeof made);
    bytes.append(content);
    return bytes;
}

std::string_view unseal(std::string_view kind, int version, std::string_view bytes)
{
    const std::string_view rest = after_line(kind, version, bytes);
    Seal wanted;
    if (rest.size() < sizeof wanted) {
        throw std::runtime_error("the file is truncated: it ends in its first line or just after");
    }
    std::memcpy(&wanted, rest.data(), sizeof wanted);
    const std::string_view content = rest.substr(sizeof wanted);
    if (content.size() != wanted.size) {
        throw std::runtime_error(fmt::format(
            "the file is {}: expected {} bytes of content, found {}; copy or write it "
            "again",
            content.size() < wanted.size ? "truncated" : "damaged", wanted.size, content.size()));
    }
    if (hash_of(content) != wanted.hash) {
        throw std::runtime_error(
            "the file is damaged: its content does not have the hash that it states; copy or write "
            "it again");
    }
    return content;
}

ContentHash hash_of(std::string_view content)
{
    const XXH128_hash_t hash = XXH3_128bits(content.data(), content.size());
    return {hash.low64, hash.high64};
}

std::string name_of(const ContentHash& hash)
{
    return fmt::format("{:016x}{:016x}", hash[1], hash[0]);
}

}  // namespace geometry
