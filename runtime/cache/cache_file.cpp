// Parts: the layout of a file, sorting bytes, packing chunks, reading them, the buffers to read
// into, and the two public functions.

#include "runtime/cache/cache_file.hpp"

#include <tbb/parallel_for.h>
#include <zstd.h>

#include <atomic>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace runtime {

namespace fs = std::filesystem;

namespace {

constexpr char magic[8] = {'a', 's', 'p', 'i', 'c', '-', 'c', '3'};
constexpr std::size_t chunk_size = std::size_t{256} << 10;
constexpr std::size_t most_bytes = std::size_t{1} << 40;

struct Header {
    char magic[8];
    FileKind kind;
    std::uint32_t chunks;
    std::uint64_t size;  // of the content
    FileNames names;
    Key table;  // hash of the table and the fields above
};
static_assert(sizeof(Header) == 72);

struct Chunk {
    std::uint32_t stored;  // bytes
    std::uint32_t stride;  // 0: as it is; else packed, its bytes sorted by place in such numbers
    Key hash;              // of the stored bytes
};
static_assert(sizeof(Chunk) == 24);

Key table_hash(const Header& header, const std::vector<Chunk>& table)
{
    KeyBuilder b;
    b.add(static_cast<std::uint32_t>(header.kind)).add(header.chunks).add(header.size);
    b.add(header.names.name).add(header.names.second);
    for (const Chunk& c : table) b.add(c.stored).add(c.stride).add(c.hash);
    return b.key();
}

struct File {
    int number = -1;
    explicit File(int n) : number(n) {}
    File(const File&) = delete;
    ~File()
    {
        if (number >= 0) ::close(number);
    }
    bool read(void* to, std::size_t size, std::size_t at) const
    {
        char* p = static_cast<char*>(to);
        while (size > 0) {
            const ssize_t got = ::pread(number, p, size, static_cast<off_t>(at));
            if (got < 0 && errno == EINTR) continue;
            if (got <= 0) return false;
            const auto n = static_cast<std::size_t>(got);
            p += n, at += n, size -= n;
        }
        return true;
    }
};

// ---- sorting bytes by their place in numbers of S bytes; what is left over stays at the end

template <std::size_t S> void sort_bytes(const char* from, char* to, std::size_t size)
{
    const std::size_t n = size / S;
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t b = 0; b < S; ++b) to[b * n + i] = from[i * S + b];
    }
    std::memcpy(to + n * S, from + n * S, size - n * S);
}
template <std::size_t S> void unsort_bytes(const char* from, char* to, std::size_t size)
{
    const std::size_t n = size / S;
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t b = 0; b < S; ++b) to[i * S + b] = from[b * n + i];
    }
    std::memcpy(to + n * S, from + n * S, size - n * S);
}

std::string_view sorted(std::string_view raw, std::uint32_t stride, std::string& buffer)
{
    if (stride == 1) return raw;
    buffer.resize(raw.size());
    stride == 4 ? sort_bytes<4>(raw.data(), buffer.data(), raw.size())
                : sort_bytes<8>(raw.data(), buffer.data(), raw.size());
    return buffer;
}

// What one thread packs or unpacks with.
struct PackScratch {
    std::string sorted, packed;
    std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> packer{nullptr, ZSTD_freeCCtx};
    std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> unpacker{nullptr, ZSTD_freeDCtx};
};

std::string_view compress(std::string_view raw, std::uint32_t stride, PackScratch& scratch)
{
    const std::string_view from = sorted(raw, stride, scratch.sorted);
    scratch.packed.resize(ZSTD_compressBound(from.size()));
    if (!scratch.packer) scratch.packer.reset(ZSTD_createCCtx());
    const std::size_t size = ZSTD_compressCCtx(scratch.packer.get(), scratch.packed.data(),
                                               scratch.packed.size(), from.data(), from.size(), 1);
    return ZSTD_isError(size) ? raw : std::string_view(scratch.packed.data(), size);
}

bool halves(std::size_t packed, std::size_t raw)
{
    return packed * 2 <= raw;
}

// The stride by which a chunk packs best, judged by a piece of its middle; 0 when none pays.
std::uint32_t best_stride(std::string_view raw, PackScratch& scratch)
{
    constexpr std::size_t sample = std::size_t{16} << 10, too_small = 256;
    if (raw.size() < too_small) return 0;
    const std::size_t begin = raw.size() > 2 * sample ? raw.size() / 2 / 8 * 8 : 0;
    const std::string_view piece = raw.substr(begin, raw.size() > 2 * sample ? sample : raw.npos);
    std::uint32_t best = 0;
    std::size_t least = piece.size();
    for (const std::uint32_t stride : {1u, 4u, 8u}) {
        const std::size_t size = compress(piece, stride, scratch).size();
        if (size < least && halves(size, piece.size())) best = stride, least = size;
    }
    return best;
}

struct Packed {
    std::string_view stored;  // of the content, or of `bytes`
    std::string bytes;
    std::uint32_t stride = 0;
};

Packed pack(std::string_view raw, PackScratch& scratch)
{
    const std::uint32_t stride = best_stride(raw, scratch);
    if (stride == 0) return {raw, {}, 0};
    const std::string_view packed = compress(raw, stride, scratch);
    if (!halves(packed.size(), raw.size())) return {raw, {}, 0};
    return {{}, std::string(packed), stride};
}

bool unpack(std::uint32_t stride, char* to, std::size_t size, PackScratch& scratch)
{
    if (!scratch.unpacker) scratch.unpacker.reset(ZSTD_createDCtx());
    char* into = to;
    if (stride > 1) {
        scratch.sorted.resize(size);
        into = scratch.sorted.data();
    }
    if (ZSTD_decompressDCtx(scratch.unpacker.get(), into, size, scratch.packed.data(),
                            scratch.packed.size()) != size) {
        return false;
    }
    if (stride == 4) unsort_bytes<4>(into, to, size);
    if (stride == 8) unsort_bytes<8>(into, to, size);
    return true;
}

// Reads what stands before the chunks, and where each of them begins. Returns what is wrong; empty
// when nothing is.
const char* read_table(const File& file, FileKind kind, const Key& name, Header& header,
                       std::vector<Chunk>& table, std::vector<std::size_t>& at)
{
    struct stat info = {};
    if (::fstat(file.number, &info) != 0 || !file.read(&header, sizeof header, 0)) {
        return "too short";
    }
    if (std::memcmp(header.magic, magic, sizeof magic) != 0 || header.kind != kind) {
        return "wrong kind of file";
    }
    if (header.size > most_bytes || header.chunks != (header.size + chunk_size - 1) / chunk_size) {
        return "damaged header";
    }
    const std::size_t table_size = header.chunks * sizeof(Chunk);
    if (sizeof header + table_size > static_cast<std::size_t>(info.st_size)) {
        return "damaged header";
    }
    table.resize(header.chunks);
    if (!file.read(table.data(), table_size, sizeof header) ||
        table_hash(header, table) != header.table) {
        return "damaged header";
    }
    const bool is_second = header.names.second && name == header.names.second;
    if (name != header.names.name && !is_second) return "stored under another name";
    at.assign(table.size() + 1, sizeof header + table_size);
    for (std::size_t i = 0; i < table.size(); ++i) {
        const std::uint32_t stride = table[i].stride;
        if ((stride > 1 && stride != 4 && stride != 8) || table[i].stored > chunk_size) {
            return "damaged table";
        }
        at[i + 1] = at[i] + table[i].stored;
    }
    return at.back() == static_cast<std::size_t>(info.st_size) ? "" : "wrong length";
}

// Reads, checks and unpacks the chunks [begin, end).
bool read_chunks(const File& file, const std::vector<Chunk>& table,
                 const std::vector<std::size_t>& at, std::size_t begin, std::size_t end, char* to,
                 std::size_t total)
{
    PackScratch scratch;
    for (std::size_t i = begin; i < end; ++i) {
        char* const out = to + i * chunk_size;
        const std::size_t size = std::min(chunk_size, total - i * chunk_size);
        const std::size_t stored = table[i].stored;
        if (table[i].stride == 0) {
            if (stored != size || !file.read(out, size, at[i])) return false;
            if (hash_bytes(out, size) != table[i].hash) return false;
            continue;
        }
        scratch.packed.resize(stored);
        if (!file.read(scratch.packed.data(), stored, at[i])) return false;
        if (hash_bytes(scratch.packed.data(), stored) != table[i].hash) return false;
        if (!unpack(table[i].stride, out, size, scratch)) return false;
    }
    return true;
}

}  // namespace

ReadBuffers::Buffer ReadBuffers::take(std::size_t size)
{
    {
        const std::lock_guard lock(mutex_);
        for (std::size_t i = 0; i < free_.size(); ++i) {
            if (free_[i].size < size || free_[i].size / 4 > size + 4096) continue;
            Buffer found = std::move(free_[i]);
            free_.erase(free_.begin() + static_cast<std::ptrdiff_t>(i));
            return found;
        }
    }
    return {std::make_unique_for_overwrite<char[]>(size), size};
}

void ReadBuffers::give_back(Buffer buffer)
{
    constexpr std::size_t most = 4, largest = std::size_t{64} << 20;
    if (buffer.size > largest) return;
    const std::lock_guard lock(mutex_);
    if (free_.size() == most) free_.erase(free_.begin());
    free_.push_back(std::move(buffer));
}

std::optional<FileBytes> read_cache_file(const fs::path& path, FileKind kind, const Key& name,
                                         ReadBuffers& buffers, std::string& damage)
{
    damage.clear();
    const File file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (file.number < 0) return std::nullopt;
    Header header;
    std::vector<Chunk> table;
    std::vector<std::size_t> at;
    damage = read_table(file, kind, name, header, table, at);
    if (!damage.empty()) return std::nullopt;

    FileBytes bytes(buffers, header.size);
    std::atomic<bool> good{true};
    const auto read_some = [&](std::size_t begin, std::size_t end) {
        if (!read_chunks(file, table, at, begin, end, bytes.data(), header.size)) good = false;
    };
    constexpr std::size_t grain = 4;
    if (table.size() <= grain) {
        read_some(0, table.size());
    } else {
        tbb::parallel_for(
            tbb::blocked_range<std::size_t>(0, table.size(), grain),
            [&](const tbb::blocked_range<std::size_t>& r) { read_some(r.begin(), r.end()); });
    }
    if (good) return bytes;
    damage = "wrong checksum";
    return std::nullopt;
}

Wrote write_cache_file(const fs::path& path, FileKind kind, const FileNames& names,
                       std::string_view bytes)
{
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    if (error) return {error.value(), 0};

    Header header{};
    std::memcpy(header.magic, magic, sizeof magic);
    header.kind = kind;
    header.names = names;
    header.size = bytes.size();
    header.chunks = static_cast<std::uint32_t>((bytes.size() + chunk_size - 1) / chunk_size);
    std::vector<Chunk> table(header.chunks);
    std::vector<Packed> chunks(header.chunks);
    PackScratch scratch;
    for (std::size_t i = 0; i < table.size(); ++i) {
        Packed& chunk = chunks[i];
        chunk = pack(bytes.substr(i * chunk_size, chunk_size), scratch);
        if (chunk.stride != 0) chunk.stored = chunk.bytes;
        table[i] = {static_cast<std::uint32_t>(chunk.stored.size()), chunk.stride,
                    hash_bytes(chunk.stored.data(), chunk.stored.size())};
    }
    header.table = table_hash(header, table);

    std::vector<std::string_view> pieces;
    pieces.emplace_back(reinterpret_cast<const char*>(&header), sizeof header);
    pieces.emplace_back(reinterpret_cast<const char*>(table.data()), table.size() * sizeof(Chunk));
    for (const Packed& chunk : chunks) pieces.push_back(chunk.stored);
    return write_whole_file(path, pieces);
}

}  // namespace runtime
