// Any bytes in the disk cache: a miss or a value, never a crash. The first byte says where they
// stand: as a whole file (headers and checksums), or inside of one whose checksums are right; and
// whether two files stand under each other's names.

#include "runtime/cache/disk_cache.hpp"
#include "tests/runtime/toys.hpp"

namespace {

namespace fs = std::filesystem;
using runtime::FileKind;

const graph::NodeType& type()
{
    return *toys::registry().find("Slow");
}

// A folder that holds one good result, made good again for each input.
struct Cache {
    toys::Folder folder;
    std::map<fs::path, std::string> good;  // what is in each file
    std::vector<fs::path> records, contents;

    Cache()
    {
        runtime::DiskCache cache(folder.path, std::uintmax_t{1} << 30, nullptr);
        auto result = std::make_shared<runtime::Result>();
        toys::Numbers numbers{std::vector<double>(3, 0.5)};
        result->values = {graph::Value::of(std::move(numbers)), graph::Value::of(1.0)};
        cache.store({1, 1}, result);
        cache.flush();
        list("5/records", records);
        list("5/contents", contents);
    }
    void list(const char* name, std::vector<fs::path>& files)
    {
        for (const auto& file : fs::recursive_directory_iterator(folder.path / name)) {
            if (!file.is_regular_file()) continue;
            files.push_back(file.path());
            std::ifstream in(file.path(), std::ios::binary);
            good[file.path()] = std::string(std::istreambuf_iterator<char>(in), {});
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
    static const Cache cache;
    for (const auto& [file, content] : cache.good) write(file, content);
    const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
    const fs::path& record = cache.records[0];
    const fs::path& content = cache.contents[data[0] / 4 % cache.contents.size()];
    switch (data[0] % 4) {
    case 0:
        write(record, bytes);
        break;
    case 1:
        write(content, bytes);
        break;
    case 2:
        runtime::write_cache_file(record, FileKind::record, {{1, 1}}, bytes);
        break;
    case 3:
        runtime::write_cache_file(content, FileKind::content,
                                  {runtime::DiskCache::key_of_file(content)}, bytes);
        break;
    }
    if ((data[0] & 64) != 0) {
        const fs::path& other = (data[0] & 128) != 0 ? record : cache.contents[0];
        const fs::path between = cache.folder.path / "between";
        fs::rename(other, between);
        fs::rename(cache.contents[1], other);
        fs::rename(between, cache.contents[1]);
    }
    runtime::DiskCache disk(cache.folder.path, std::uintmax_t{1} << 30, nullptr);
    if (const runtime::SharedResult found = disk.load({1, 1}, type())) {
        if (found->values.size() != 2) std::abort();
    }
    static_cast<void>(disk.verify());
    static_cast<void>(disk.shrink(100, 0));
    return 0;
}
