// Parts: files, values, records, the queue of what is to be written, lists. What tends the folder
// as a whole stands in disk_upkeep.cpp.

#include "runtime/cache/disk_cache.hpp"

#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace runtime {

namespace fs = std::filesystem;
using graph::ContentName;

namespace {

constexpr const char* version = "5";
constexpr std::size_t most_queued = std::size_t{512} << 20;

void touch(const fs::path& path)
{
    ::utimensat(AT_FDCWD, path.c_str(), nullptr, 0);
}

}  // namespace

DiskCache::DiskCache(const fs::path& folder, std::uintmax_t budget,
                     std::function<void(const std::string&)> warn)
    : folder_(folder / version), budget_(budget), warn_(std::move(warn)),
      writer_([this](const std::stop_token& stop) { write_jobs(stop); })
{}

DiskCache::~DiskCache()
{
    flush();
    writer_.request_stop();
    queue_changed_.notify_all();
    writer_.join();
    try {
        tend();
    } catch (const std::exception&) {
        // A folder that fails now is looked at by the next process.
    }
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

Key DiskCache::key_of_file(const fs::path& path)
{
    return from_hex(path.parent_path().filename().string() + path.filename().string());
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

// ---- files --------------------------------------------------------------------------------------

std::optional<FileBytes> DiskCache::read_file(const fs::path& path, FileKind kind)
{
    std::string damage;
    std::optional<FileBytes> bytes =
        read_cache_file(path, kind, key_of_file(path), buffers_, damage);
    if (!damage.empty()) set_aside(path, damage);
    return bytes;
}

bool DiskCache::write_file(const fs::path& path, FileKind kind, const FileNames& names,
                           std::string_view bytes)
{
    if (!writable_) return false;
    const Wrote wrote = write_cache_file(path, kind, names, bytes);
    written_ += wrote.size;
    if (wrote.error != 0) {
        writable_ = false;
        warn_once("write", "the cache folder " + folder_.string() + " can't be written (" +
                               std::strerror(wrote.error) + "); results are not stored");
    }
    return wrote.error == 0;
}

void DiskCache::set_aside(const fs::path& path, const std::string& why)
{
    std::error_code error;
    fs::create_directories(folder_ / "aside", error);
    fs::rename(path, folder_ / "aside" / path.filename(), error);
    if (error) fs::remove(path, error);
    warn_once("damaged", "damaged cache file (" + why +
                             "); moved to aside/, its result is recomputed: " + path.string());
}

void DiskCache::warn_once(const std::string& kind, const std::string& text)
{
    {
        const std::lock_guard lock(warned_mutex_);
        if (!warned_.insert(kind).second) return;
    }
    if (warn_) warn_(text);
}

// ---- values -------------------------------------------------------------------------------------

graph::Encoder DiskCache::encoder(std::vector<ContentName>& names)
{
    graph::Encoder e;
    e.share = [this, &names](const std::shared_ptr<const void>& content, const std::string& layout,
                             auto encode) {
        {
            const std::lock_guard lock(shared_mutex_);
            const auto found = stored_.find(content.get());
            if (found != stored_.end() && !found->second.content.expired() &&
                ::access(path_of("contents", key_of(found->second.name)).c_str(), R_OK) == 0) {
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
    } else if (!write_file(path, FileKind::content, {key}, e.bytes)) {
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
        const auto found = loaded_.find(name);
        if (found != loaded_.end() && found->second.decode == decode) {
            if (auto content = found->second.content.lock()) return content;
        }
    }
    const fs::path path = path_of("contents", key_of(name));
    const std::optional<FileBytes> bytes = read_file(path, FileKind::content);
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
        std::erase_if(loaded_, [](const auto& l) { return l.second.content.expired(); });
    }
    loaded_[name] = {content, decode};
    return content;
}

std::optional<CacheRecord> DiskCache::read_record(const fs::path& path)
{
    const std::optional<FileBytes> bytes = read_file(path, FileKind::record);
    if (!bytes) return std::nullopt;
    try {
        graph::Decoder d{bytes->view(), {}};
        CacheRecord record;
        graph::decode(d, record);
        return record;
    } catch (const std::exception&) {
        set_aside(path, "unreadable");
        return std::nullopt;
    }
}

std::optional<CacheRecord> DiskCache::record(const Key& key)
{
    return read_record(path_of("records", key));
}

SharedResult DiskCache::load(const Key& key, const graph::NodeType& type)
{
    return load(path_of("records", key), type);
}

SharedResult DiskCache::load(const fs::path& path, const graph::NodeType& type)
{
    try {
        const std::optional<CacheRecord> record = read_record(path);
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
        take_record(*record, *result);
        touch(path);
        return result;
    } catch (const std::exception&) {
        return nullptr;  // whatever it is, cooking again is right
    }
}

SharedResult DiskCache::load_same(const Key& same, const graph::NodeType& type)
{
    return load(path_of("same", same), type);
}

// A second name of one file: it takes no room, and nothing new has to be synced.
void DiskCache::link(const fs::path& from, const fs::path& to)
{
    if (!writable_) return;
    std::error_code error, ignored;
    fs::create_directories(to.parent_path(), ignored);
    fs::create_hard_link(from, to, error);  // where it can't be done, nothing is lost but time
    // The name of a file that another process wrote and that this one has just written over.
    if (error == std::errc::file_exists && !fs::equivalent(from, to, ignored)) {
        fs::remove(to, ignored);
        fs::create_hard_link(from, to, ignored);
    }
}

void DiskCache::call(const Key& key, const Key& same)
{
    enqueue({key, nullptr, same});
}

void DiskCache::store(const Key& key, SharedResult result, const Key& same)
{
    if (!writable_) return;
    for (const graph::Value& value : result->values) {
        if (value && !value.type()->encode) return;
    }
    enqueue({key, std::move(result), same});
}

void DiskCache::enqueue(Job job)
{
    if (!writable_) return;
    std::unique_lock lock(queue_mutex_);
    queue_changed_.wait(lock, [this] { return queued_bytes_ < most_queued; });
    queued_bytes_ += job.bytes();
    queue_.push_back(std::move(job));
    queue_changed_.notify_all();
}

void DiskCache::flush()
{
    std::unique_lock lock(queue_mutex_);
    queue_changed_.wait(lock, [this] { return queue_.empty() && !writing_; });
}

void DiskCache::write_jobs(const std::stop_token& stop)
{
    std::unique_lock lock(queue_mutex_);
    while (queue_changed_.wait(lock, stop, [this] { return !queue_.empty(); })) {
        Job job = std::move(queue_.front());
        queue_.pop_front();
        writing_ = true;
        const std::size_t bytes = job.bytes();
        lock.unlock();
        try {
            job.result ? write(job) : write_again(job.key, job.same);
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
    CacheRecord record = record_of(*job.result);
    for (const graph::Value& value : job.result->values) {
        CacheRecord::Output output;
        if (value) {
            output.there = true;
            output.name = write_content(value.content(), value.type()->layout, value.type()->encode,
                                        record.names);
        }
        record.outputs.push_back(output);
    }
    write_record(record, job.key, job.same);
}

// The record that has the second name, under another key, too.
void DiskCache::write_again(const Key& key, const Key& same)
{
    const std::optional<CacheRecord> record = read_record(path_of("same", same));
    if (record) write_record(*record, key, same);
}

void DiskCache::write_record(const CacheRecord& record, const Key& key, const Key& same)
{
    graph::Encoder e;
    graph::encode(record, e);
    const fs::path path = path_of("records", key);
    if (write_file(path, FileKind::record, {key, same}, e.bytes) && same) {
        link(path, path_of("same", same));
    }
}

std::optional<std::vector<std::string>> DiskCache::list(const Key& key)
{
    const fs::path path = path_of("lists", key);
    const std::optional<FileBytes> bytes = read_file(path, FileKind::list);
    if (!bytes) return std::nullopt;
    try {
        graph::Decoder d{bytes->view(), {}};
        std::vector<std::string> names;
        graph::decode(d, names);
        return names;
    } catch (const std::exception&) {
        set_aside(path, "unreadable");
        return std::nullopt;
    }
}

void DiskCache::store_list(const Key& key, const std::vector<std::string>& names)
{
    graph::Encoder e;
    graph::encode(names, e);
    write_file(path_of("lists", key), FileKind::list, {key}, e.bytes);
}

}  // namespace runtime
