#pragma once

// One file of the disk cache: there whole or not at all, and never believed unread.
//
//   header     magic, kind, number of chunks, size, names, hash of these and of the table
//   table      a chunk's stored size, how it is packed, and the hash of what is stored
//   chunks     256 KiB of the content each, so that all cores read one file
//
// A chunk is packed by zstd where that halves it at least, after sorting the bytes of its
// numbers by significance (neighbouring numbers share sign and exponent); else it is stored as it
// is, because reading it then costs a copy and a checksum.

#include "runtime/cache/key.hpp"
#include "runtime/cache/whole_file.hpp"

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace runtime {

enum class FileKind : std::uint32_t { record = 1, content = 2, list = 3 };

// What a file is stored under. They stand inside of it, so that a file that was renamed or swapped
// with another one is found out.
struct FileNames {
    Key name;
    Key second = {};  // another name of the same file; zero for none
};

// Buffers to read into, used again: fresh memory costs as much as reading does.
class ReadBuffers {
public:
    struct Buffer {
        std::unique_ptr<char[]> data;
        std::size_t size = 0;
    };
    Buffer take(std::size_t size);
    void give_back(Buffer buffer);

private:
    std::mutex mutex_;
    std::vector<Buffer> free_;
};

// The content of a file that checked out. Its address is a multiple of 16.
class FileBytes {
public:
    FileBytes(ReadBuffers& buffers, std::size_t size)
        : buffers_(&buffers), buffer_(buffers.take(size)), size_(size)
    {}
    FileBytes(FileBytes&& other) noexcept
        : buffers_(std::exchange(other.buffers_, nullptr)), buffer_(std::move(other.buffer_)),
          size_(other.size_)
    {}
    ~FileBytes()
    {
        if (buffers_) buffers_->give_back(std::move(buffer_));
    }
    char* data() { return buffer_.data.get(); }
    std::string_view view() const { return {buffer_.data.get(), size_}; }

private:
    ReadBuffers* buffers_;
    ReadBuffers::Buffer buffer_;
    std::size_t size_;
};

// Nothing when there is no such file; then `damage` is empty. Nothing, and `damage` says why, when
// the file is not what write_cache_file left under that name.
std::optional<FileBytes> read_cache_file(const std::filesystem::path& path, FileKind kind,
                                         const Key& name, ReadBuffers& buffers,
                                         std::string& damage);

// Folders above are made. The size is that on disk.
Wrote write_cache_file(const std::filesystem::path& path, FileKind kind, const FileNames& names,
                       std::string_view bytes);

}  // namespace runtime
