#include "runtime/disk_cache.hpp"

#include <tbb/parallel_for.h>
#include <zstd.h>

#include <chrono>
#include <cstdlib>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace runtime {

namespace fs = std::filesystem;
using graph::ContentName;

namespace {

enum Kind : std::uint32_t { kind_record = 1, kind_content = 2, kind_list = 3 };

constexpr char magic[8] = {'a', 's', 'p', 'i', 'c', '-', 'c', '1'};
constexpr std::size_t chunk_size = std::size_t{1} << 20;
constexpr std::size_t most_bytes = std::size_t{1} << 40;
constexpr std::size_t most_queued = std::size_t{512} << 20;

struct Header {
    char magic[8];
    std::uint32_t kind;
    std::uint32_t chunks;
    std::uint64_t size;  // of what the chunks hold, unpacked
    Key table;           // hash of the table and the fields above
};
static_assert(sizeof(Header) == 40);

struct Chunk {
    std::uint64_t stored;  // bytes; as many as unpacked: stored as they are
    Key hash;              // of the stored bytes
};

Key table_hash(const Header& header, const std::vector<Chunk>& table)
{
    KeyBuilder b;
    b.add(header.kind).add(header.chunks).add(header.size);
    for (const Chunk& c : table) b.add(c.stored).add(c.hash);
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
            if (got <= 0) return false;
            const auto n = static_cast<std::size_t>(got);
            p += n, at += n, size -= n;
        }
        return true;
    }
    bool write(const void* from, std::size_t size) const
    {
        const char* p = static_cast<const char*>(from);
        while (size > 0) {
            const ssize_t put = ::write(number, p, size);
            if (put < 0 && errno == EINTR) continue;
            if (put <= 0) return false;
            p += put, size -= static_cast<std::size_t>(put);
        }
        return true;
    }
};

Key key_of(const ContentName& name)
{
    return {name[0], name[1]};
}

double age_of(const fs::path& path)
{
    std::error_code error;
    const auto time = fs::last_write_time(path, error);
    if (error) return 0;
    return std::chrono::duration<double>(fs::file_time_type::clock::now() - time).count();
}

void touch(const fs::path& path)
{
    ::utimensat(AT_FDCWD, path.c_str(), nullptr, 0);
}

template <class F> void each_file(const fs::path& folder, const F& f)
{
    std::error_code error;
    fs::recursive_directory_iterator at(folder, error), end;
    while (!error && at != end) {
        std::error_code ignored;
        if (at->is_regular_file(ignored)) f(*at);
        at.increment(error);
    }
}

// Packed where it gains a tenth at least: else reading it back would only cost time.
std::string_view pack(std::string_view raw, std::string& buffer)
{
    buffer.resize(ZSTD_compressBound(raw.size()));
    const std::size_t size = ZSTD_compress(buffer.data(), buffer.size(), raw.data(), raw.size(), 1);
    if (ZSTD_isError(size) || size > raw.size() / 10 * 9) return raw;
    return {buffer.data(), size};
}

}  // namespace

// What `records/` holds.
struct DiskCache::Record {
    struct Output {
        bool there = false;
        ContentName name{};
    };
    struct WrittenFile {
        std::string path;
        ContentName digest{};
    };
    std::vector<Output> outputs;
    std::vector<ContentName> names;  // all contents that it needs, shared parts included
    std::vector<std::string> warnings;
    std::vector<WrittenFile> files;
    double seconds = 0;
    std::uint64_t bytes = 0;
};

DiskCache::DiskCache(fs::path folder, std::uintmax_t budget,
                     std::function<void(const std::string&)> warn)
    : folder_(std::move(folder)), budget_(budget), warn_(std::move(warn)),
      writer_([this](std::stop_token stop) { write_jobs(stop); })
{}

DiskCache::~DiskCache()
{
    flush();
    writer_.request_stop();
    queue_changed_.notify_all();
    writer_.join();
    if (written_ > 0) shrink(budget_);
}

fs::path DiskCache::default_folder()
{
    if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache == '/') {
        return fs::path(cache) / "aspic";
    }
    if (const char* home = std::getenv("HOME"); home && *home) {
        return fs::path(home) / ".cache" / "aspic";
    }
    return {};
}

fs::path DiskCache::path_of(const char* folder, const Key& key) const
{
    const std::string hex = to_hex(key);
    return folder_ / folder / hex.substr(0, 2) / hex.substr(2);
}

bool DiskCache::pays(double seconds, std::size_t bytes)
{
    return seconds > 2e-3 + 3e-9 * static_cast<double>(bytes);
}

bool DiskCache::holds(const Key& key) const
{
    return ::access(path_of("records", key).c_str(), R_OK) == 0;
}

// ---- files
// ---------------------------------------------------------------------------------------

std::optional<DiskCache::Bytes> DiskCache::read_file(const fs::path& path, std::uint32_t kind)
{
    const File file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (file.number < 0) return std::nullopt;
    const auto bad = [&](const char* why) {
        set_aside(path, why);
        return std::nullopt;
    };
    struct stat info = {};
    Header header;
    if (::fstat(file.number, &info) != 0 || !file.read(&header, sizeof header, 0)) {
        return bad("it is too short");
    }
    if (std::memcmp(header.magic, magic, sizeof magic) != 0 || header.kind != kind) {
        return bad("it is no such file");
    }
    if (header.size > most_bytes || header.chunks != (header.size + chunk_size - 1) / chunk_size) {
        return bad("its header is damaged");
    }
    std::vector<Chunk> table(header.chunks);
    const std::size_t table_size = table.size() * sizeof(Chunk);
    if (sizeof header + table_size > static_cast<std::size_t>(info.st_size) ||
        !file.read(table.data(), table_size, sizeof header) ||
        table_hash(header, table) != header.table) {
        return bad("its header is damaged");
    }
    std::vector<std::size_t> at(table.size() + 1, sizeof header + table_size);
    for (std::size_t i = 0; i < table.size(); ++i) at[i + 1] = at[i] + table[i].stored;
    if (at.back() != static_cast<std::size_t>(info.st_size)) return bad("it has another length");

    Bytes bytes{std::make_unique_for_overwrite<char[]>(header.size), header.size};
    std::atomic<bool> good{true};
    const auto read_chunk = [&](std::size_t i) {
        char* const to = bytes.data.get() + i * chunk_size;
        const std::size_t size = std::min(chunk_size, bytes.size - i * chunk_size);
        const std::size_t stored = table[i].stored;
        if (stored == size) {
            if (!file.read(to, size, at[i]) || hash_bytes(to, size) != table[i].hash) good = false;
            return;
        }
        const auto packed = std::make_unique_for_overwrite<char[]>(stored);
        if (!file.read(packed.get(), stored, at[i]) ||
            hash_bytes(packed.get(), stored) != table[i].hash ||
            ZSTD_decompress(to, size, packed.get(), stored) != size) {
            good = false;
        }
    };
    if (table.size() == 1) {
        read_chunk(0);
    } else {
        tbb::parallel_for(std::size_t{0}, table.size(), read_chunk);
    }
    if (!good) return bad("its checksum does not fit");
    return bytes;
}

bool DiskCache::write_file(const fs::path& path, std::uint32_t kind, std::string_view bytes)
{
    if (!writable_) return false;
    static std::atomic<unsigned> counter{0};
    const fs::path temporary =
        path.string() + "." + std::to_string(::getpid()) + "." + std::to_string(counter++) + "~";
    const auto give_up = [&](int error) {
        ::unlink(temporary.c_str());
        writable_ = false;
        warn_once("write", "the cache folder " + folder_.string() + " can't be written (" +
                               std::strerror(error) + "); cooking on without storing");
        return false;
    };
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    if (error) return give_up(error.value());

    Header header{};
    std::memcpy(header.magic, magic, sizeof magic);
    header.kind = kind;
    header.size = bytes.size();
    header.chunks = static_cast<std::uint32_t>((bytes.size() + chunk_size - 1) / chunk_size);
    std::vector<Chunk> table(header.chunks);
    std::vector<std::string> buffers(header.chunks);
    std::vector<std::string_view> packed(header.chunks);
    for (std::size_t i = 0; i < table.size(); ++i) {
        packed[i] = pack(bytes.substr(i * chunk_size, chunk_size), buffers[i]);
        table[i] = {packed[i].size(), hash_bytes(packed[i].data(), packed[i].size())};
    }
    header.table = table_hash(header, table);

    const File file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
    if (file.number < 0) return give_up(errno);
    bool good = file.write(&header, sizeof header) &&
                file.write(table.data(), table.size() * sizeof(Chunk));
    std::size_t size = sizeof header + table.size() * sizeof(Chunk);
    for (const std::string_view& chunk : packed) {
        good = good && file.write(chunk.data(), chunk.size());
        size += chunk.size();
    }
    if (!good || ::fsync(file.number) != 0) return give_up(errno);
    if (::rename(temporary.c_str(), path.c_str()) != 0) return give_up(errno);
    written_ += size;
    return true;
}

void DiskCache::set_aside(const fs::path& path, const std::string& why)
{
    std::error_code error;
    fs::create_directories(folder_ / "aside", error);
    fs::rename(path, folder_ / "aside" / path.filename(), error);
    if (error) fs::remove(path, error);
    warn_once("damaged", "a file of the cache was set aside because " + why +
                             ", and what it held is cooked again: " + path.string());
}

void DiskCache::warn_once(const std::string& kind, const std::string& text)
{
    {
        const std::lock_guard lock(warned_mutex_);
        if (!warned_.insert(kind).second) return;
    }
    if (warn_) warn_(text);
}

// ---- values
// --------------------------------------------------------------------------------------

graph::Encoder DiskCache::encoder(std::vector<ContentName>& names)
{
    graph::Encoder e;
    e.share = [this, &names](const std::shared_ptr<const void>& content, const std::string& layout,
                             auto encode) {
        {
            const std::lock_guard lock(shared_mutex_);
            const auto found = stored_.find(content.get());
            if (found != stored_.end() && !found->second.content.expired()) {
                const Shared& shared = found->second;
                names.insert(names.end(), shared.inner.begin(), shared.inner.end());
                return shared.name;
            }
        }
        Shared shared{content, {}, {}};
        shared.name = write_content(content.get(), layout, encode, shared.inner);
        names.insert(names.end(), shared.inner.begin(), shared.inner.end());
        const std::lock_guard lock(shared_mutex_);
        std::erase_if(stored_, [](const auto& s) { return s.second.content.expired(); });
        stored_[content.get()] = shared;
        return shared.name;
    };
    return e;
}

// Appends the content's own name and those of its shared parts to `names`.
ContentName DiskCache::write_content(const void* content, const std::string& layout,
                                     void (*encode)(const void*, graph::Encoder&),
                                     std::vector<ContentName>& names)
{
    graph::Encoder e = encoder(names);
    graph::encode(layout, e);
    encode(content, e);
    const Key key = hash_bytes(e.bytes.data(), e.bytes.size());
    const fs::path path = path_of("contents", key);
    if (::access(path.c_str(), R_OK) == 0) {
        touch(path);  // so that nobody takes it for forgotten before the record names it
    } else if (!write_file(path, kind_content, e.bytes)) {
        throw std::runtime_error("the cache can't be written");
    }
    names.push_back({key.low, key.high});
    return names.back();
}

std::shared_ptr<const void>
DiskCache::read_content(const ContentName& name, const std::string& layout,
                        std::shared_ptr<const void> (*decode)(graph::Decoder&))
{
    {
        const std::lock_guard lock(shared_mutex_);
        if (const auto found = loaded_.find(name); found != loaded_.end()) {
            if (auto content = found->second.lock()) return content;
        }
    }
    const fs::path path = path_of("contents", key_of(name));
    const std::optional<Bytes> bytes = read_file(path, kind_content);
    if (!bytes) return nullptr;
    graph::Decoder d{bytes->view(), [this](const ContentName& inner,
                                           const std::string& inner_layout, auto inner_decode) {
                         auto content = read_content(inner, inner_layout, inner_decode);
                         if (!content) throw std::runtime_error("a shared part is missing");
                         return content;
                     }};
    std::string written_layout;
    graph::decode(d, written_layout);
    if (written_layout != layout) return nullptr;  // by an older program
    std::shared_ptr<const void> content = decode(d);
    const std::lock_guard lock(shared_mutex_);
    if (loaded_.size() > 4096) {
        std::erase_if(loaded_, [](const auto& l) { return l.second.expired(); });
    }
    loaded_[name] = content;
    return content;
}

std::optional<DiskCache::Record> DiskCache::read_record(const fs::path& path)
{
    const std::optional<Bytes> bytes = read_file(path, kind_record);
    if (!bytes) return std::nullopt;
    try {
        graph::Decoder d{bytes->view(), {}};
        Record record;
        graph::decode(d, record);
        return record;
    } catch (const std::exception&) {
        set_aside(path, "it can't be read");
        return std::nullopt;
    }
}

SharedResult DiskCache::load(const Key& key, const graph::NodeType& type)
{
    try {
        const fs::path path = path_of("records", key);
        const std::optional<Record> record = read_record(path);
        if (!record || record->outputs.size() != type.outputs.size()) return nullptr;
        auto result = std::make_shared<Result>();
        for (std::size_t i = 0; i < record->outputs.size(); ++i) {
            const graph::WireType* wire = type.outputs[i].wire;
            if (!record->outputs[i].there) {
                result->values.emplace_back();
                continue;
            }
            if (!wire || !wire->decode) return nullptr;
            auto content = read_content(record->outputs[i].name, wire->layout, wire->decode);
            if (!content) return nullptr;
            result->values.push_back(graph::Value::restored(std::move(content), *wire));
        }
        result->warnings = record->warnings;
        for (const Record::WrittenFile& f : record->files) {
            result->files.push_back({f.path, key_of(f.digest)});
        }
        result->seconds = record->seconds;
        result->bytes = record->bytes;
        touch(path);
        return result;
    } catch (const std::exception&) {
        return nullptr;  // whatever it is, cooking again is right
    }
}

void DiskCache::store(const Key& key, SharedResult result)
{
    if (!writable_) return;
    for (const graph::Value& value : result->values) {
        if (value && !value.type()->encode) return;
    }
    std::unique_lock lock(queue_mutex_);
    queue_changed_.wait(lock, [this] { return queued_bytes_ < most_queued; });
    queued_bytes_ += result->bytes;
    queue_.push_back({key, std::move(result)});
    queue_changed_.notify_all();
}

void DiskCache::flush()
{
    std::unique_lock lock(queue_mutex_);
    queue_changed_.wait(lock, [this] { return queue_.empty() && !writing_; });
}

void DiskCache::write_jobs(std::stop_token stop)
{
    std::unique_lock lock(queue_mutex_);
    while (queue_changed_.wait(lock, stop, [this] { return !queue_.empty(); })) {
        Job job = std::move(queue_.front());
        queue_.pop_front();
        writing_ = true;
        const std::size_t bytes = job.result->bytes;
        lock.unlock();
        try {
            write(job);
            if (written_ > budget_ / 16) shrink(budget_);
        } catch (const std::exception&) {
            // What could not be written was warned of; the result lives on in memory.
        }
        job.result.reset();
        lock.lock();
        writing_ = false;
        queued_bytes_ -= bytes;
        queue_changed_.notify_all();
    }
}

void DiskCache::write(const Job& job)
{
    Record record;
    for (const graph::Value& value : job.result->values) {
        Record::Output output;
        if (value) {
            output.there = true;
            output.name = write_content(value.content(), value.type()->layout, value.type()->encode,
                                        record.names);
        }
        record.outputs.push_back(output);
    }
    record.warnings = job.result->warnings;
    for (const Written& w : job.result->files) {
        record.files.push_back({w.path.string(), {w.digest.low, w.digest.high}});
    }
    record.seconds = job.result->seconds;
    record.bytes = job.result->bytes;
    graph::Encoder e;
    graph::encode(record, e);
    write_file(path_of("records", job.key), kind_record, e.bytes);
}

std::optional<std::vector<std::string>> DiskCache::list(const Key& key)
{
    const fs::path path = path_of("lists", key);
    const std::optional<Bytes> bytes = read_file(path, kind_list);
    if (!bytes) return std::nullopt;
    try {
        graph::Decoder d{bytes->view(), {}};
        std::vector<std::string> names;
        graph::decode(d, names);
        return names;
    } catch (const std::exception&) {
        set_aside(path, "it can't be read");
        return std::nullopt;
    }
}

void DiskCache::store_list(const Key& key, const std::vector<std::string>& names)
{
    graph::Encoder e;
    graph::encode(names, e);
    write_file(path_of("lists", key), kind_list, e.bytes);
}

// ---- housekeeping
// --------------------------------------------------------------------------------

DiskUse DiskCache::use() const
{
    DiskUse use;
    const auto count = [&](const char* folder, std::size_t& files) {
        each_file(folder_ / folder, [&](const fs::directory_entry& file) {
            std::error_code ignored;
            ++files;
            use.bytes += file.file_size(ignored);
        });
    };
    count("records", use.records);
    count("contents", use.contents);
    count("lists", use.lists);
    count("aside", use.aside);
    return use;
}

DiskCheck DiskCache::verify()
{
    flush();
    DiskCheck check;
    const auto tell = [&](bool good) { good ? ++check.good : ++check.bad; };
    each_file(folder_ / "records",
              [&](const fs::directory_entry& file) { tell(read_record(file.path()).has_value()); });
    each_file(folder_ / "lists", [&](const fs::directory_entry& file) {
        tell(read_file(file.path(), kind_list).has_value());
    });
    each_file(folder_ / "contents", [&](const fs::directory_entry& file) {
        const std::optional<Bytes> bytes = read_file(file.path(), kind_content);
        if (!bytes) return tell(false);
        const std::string name =
            file.path().parent_path().filename().string() + file.path().filename().string();
        const bool named_right = hash_bytes(bytes->data.get(), bytes->size) == from_hex(name);
        if (!named_right) set_aside(file.path(), "it is not what its name says");
        tell(named_right);
    });
    return check;
}

std::uintmax_t DiskCache::shrink(std::uintmax_t budget, double grace)
{
    written_ = 0;
    struct Content {
        std::uintmax_t size = 0;
        std::size_t users = 0;
        fs::path path;
    };
    struct Old {
        fs::path path;
        std::vector<ContentName> names;
        double worth = 0;
        std::uintmax_t size = 0;
    };
    std::map<ContentName, Content> contents;
    std::uintmax_t total = 0, gone = 0;
    const auto remove = [&](const fs::path& path, std::uintmax_t size) {
        std::error_code ignored;
        if (fs::remove(path, ignored)) gone += size, total -= std::min(total, size);
    };
    std::error_code ignored;
    each_file(folder_ / "contents", [&](const fs::directory_entry& file) {
        const Key key = from_hex(file.path().parent_path().filename().string() +
                                 file.path().filename().string());
        const std::uintmax_t size = file.file_size(ignored);
        total += size;
        if (key)
            contents[{key.low, key.high}] = {size, 0, file.path()};
        else if (age_of(file.path()) > grace)
            remove(file.path(), size);  // left by a killed writer
    });
    std::vector<Old> records;
    each_file(folder_ / "records", [&](const fs::directory_entry& file) {
        total += file.file_size(ignored);
        const double age = age_of(file.path());
        const std::optional<Record> record = read_record(file.path());
        if (!record) return;
        Old old{file.path(), record->names, 0, file.file_size(ignored)};
        double bytes = static_cast<double>(old.size);
        for (const ContentName& name : record->names) {
            Content& content = contents[name];
            ++content.users;
            bytes += static_cast<double>(content.size);
        }
        old.worth = (record->seconds + 1e-3) / (bytes * (age + 1));
        records.push_back(std::move(old));
    });
    std::sort(records.begin(), records.end(),
              [](const Old& a, const Old& b) { return a.worth < b.worth; });
    for (const auto& [name, content] : contents) {
        if (content.users == 0 && !content.path.empty() && age_of(content.path) > grace) {
            remove(content.path, content.size);
        }
    }
    if (total <= budget) return gone;
    // A little more than asked for, so that the next write does not start over.
    for (const Old& old : records) {
        if (total <= budget / 10 * 9) break;
        remove(old.path, old.size);
        for (const ContentName& name : old.names) {
            Content& content = contents[name];
            if (--content.users == 0 && !content.path.empty() &&
                (grace == 0 || age_of(content.path) > grace)) {
                remove(content.path, content.size);
            }
        }
    }
    return gone;
}

void DiskCache::clear()
{
    flush();
    for (const char* folder : {"records", "contents", "lists", "aside"}) {
        std::error_code ignored;
        fs::remove_all(folder_ / folder, ignored);
    }
}

}  // namespace runtime
