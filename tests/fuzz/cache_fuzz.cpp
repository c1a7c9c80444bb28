// Any bytes in the disk cache: a miss or a value, never a crash. The first byte says where they
// stand: as a whole file (headers and checksums), or inside of one whose checksums are right.

#include "runtime/disk_cache.hpp"
#include "tests/runtime/toys.hpp"

namespace {

namespace fs = std::filesystem;
using runtime::FileKind;

const graph::NodeType& type()
{
    return *toys::registry().find("Slow");
}

// A folder in memory that holds one good result, kept for the life of the program.
struct Folder {
    toys::Folder folder;
    std::vector<fs::path> records, contents;

    Folder()
    {
        runtime::DiskCache cache(folder.path, std::uintmax_t{1} << 30, nullptr);
        auto result = std::make_shared<runtime::Result>();
        toys::Numbers numbers{std::vector<double>(3, 0.5)};
        result->values = {graph::Value::of(std::move(numbers)), graph::Value::of(1.0)};
        cache.store({1, 1}, result);
        cache.flush();
        list("2/records", records);
        list("2/contents", contents);
    }
    void list(const char* name, std::vector<fs::path>& files) const
    {
        for (const auto& file : fs::recursive_directory_iterator(folder.path / name)) {
            if (file.is_regular_file()) files.push_back(file.path());
        }
        std::sort(files.begin(), files.end());
    }
};

void write(const fs::path& path, std::string_view bytes)
{
    std::ofstream(path, std::ios::binary).write(bytes.data(), std::ssize(bytes));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    if (size == 0) return 0;
    static const Folder pristine;
    const toys::Folder folder;
    fs::copy(pristine.folder.path, folder.path, fs::copy_options::recursive);
    const auto there = [&](const fs::path& file) {
        return folder.path / file.lexically_relative(pristine.folder.path);
    };
    const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
    const fs::path record = there(pristine.records[0]);
    const fs::path content = there(pristine.contents[data[0] / 4 % pristine.contents.size()]);
    switch (data[0] % 4) {
    case 0:
        write(record, bytes);
        break;
    case 1:
        write(content, bytes);
        break;
    case 2:
        runtime::write_cache_file(record, FileKind::record, bytes);
        break;
    case 3:
        runtime::write_cache_file(content, FileKind::content, bytes);
        break;
    }
    runtime::DiskCache cache(folder.path, std::uintmax_t{1} << 30, nullptr);
    if (const runtime::SharedResult found = cache.load({1, 1}, type())) {
        if (found->values.size() != 2) std::abort();
    }
    static_cast<void>(cache.verify());
    static_cast<void>(cache.shrink(100, 0));
    return 0;
}
