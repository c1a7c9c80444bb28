#include "runtime/disk_cache.hpp"

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace runtime {

namespace fs = std::filesystem;
using graph::ContentName;

namespace {

constexpr const char* version = "3";
constexpr std::size_t most_queued = std::size_t{512} << 20;

Key key_of(const ContentName& name)
{
    return {name[0], name[1]};
}

ContentName name_of(const Key& key)
{
    return {key.low, key.high};
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

// Left by a writer that was killed, or of one that is at it.
bool is_temporary(const fs::path& path)
{
    return path.native().ends_with('~');
}

template <class F> void each_of(const fs::path& folder, bool temporary, const F& f)
{
    std::error_code error;
    fs::recursive_directory_iterator at(folder, error), end;
    while (!error && at != end) {
        std::error_code ignored;
        if (at->is_regular_file(ignored) && is_temporary(at->path()) == temporary) f(*at);
        at.increment(error);
    }
}
template <class F> void each_file(const fs::path& folder, const F& f)
{
    each_of(folder, false, f);
}
template <class F> void each_temporary(const fs::path& folder, const F& f)
{
    each_of(folder, true, f);
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
    struct Heard {
        ContentName from{};
        int frame = 0;
        std::string text;
    };
    std::vector<std::string> warnings;
    std::vector<Heard> heard;
    std::vector<WrittenFile> files;
    double seconds = 0;
    std::uint64_t bytes = 0;
};

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

// ---- files --------------------------------------------------------------------------------------

std::optional<FileBytes> DiskCache::read_file(const fs::path& path, FileKind kind)
{
    std::string damage;
    std::optional<FileBytes> bytes = read_cache_file(path, kind, buffers_, damage);
    if (!damage.empty()) set_aside(path, damage);
    return bytes;
}

bool DiskCache::write_file(const fs::path& path, FileKind kind, std::string_view bytes)
{
    if (!writable_) return false;
    const Wrote wrote = write_cache_file(path, kind, bytes);
    written_ += wrote.size;
    if (wrote.error != 0) {
        writable_ = false;
        warn_once("write", "the cache folder " + folder_.string() + " can't be written (" +
                               std::strerror(wrote.error) + "); cooking on without storing");
    }
    return wrote.error == 0;
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
    } else if (!write_file(path, FileKind::content, e.bytes)) {
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
        std::erase_if(loaded_, [](const auto& l) { return l.second.expired(); });
    }
    loaded_[name] = content;
    return content;
}

std::optional<DiskCache::Record> DiskCache::read_record(const fs::path& path)
{
    const std::optional<FileBytes> bytes = read_file(path, FileKind::record);
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
    return load(path_of("records", key), type);
}

SharedResult DiskCache::load(const fs::path& path, const graph::NodeType& type)
{
    try {
        const std::optional<Record> record = read_record(path);
        if (!record || record->outputs.size() != type.outputs.size()) return nullptr;
        auto result = std::make_shared<Result>();
        std::vector<ContentName> names;
        for (std::size_t i = 0; i < record->outputs.size(); ++i) {
            const graph::WireType* wire = type.outputs[i].wire;
            names.push_back(record->outputs[i].name);
            if (!record->outputs[i].there) {
                result->values.emplace_back();
                continue;
            }
            if (!wire || !wire->decode) return nullptr;
            auto content = read_content(record->outputs[i].name, wire->layout, wire->decode);
            if (!content) return nullptr;
            result->values.push_back(graph::Value::restored(std::move(content), *wire));
        }
        result->know_names(std::move(names));
        result->warnings = record->warnings;
        for (const Record::Heard& h : record->heard) {
            result->heard.push_back({key_of(h.from), h.frame, h.text});
        }
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
    link(path_of("same", same), path_of("records", key));
}

void DiskCache::store(const Key& key, SharedResult result, const Key& same)
{
    if (!writable_) return;
    for (const graph::Value& value : result->values) {
        if (value && !value.type()->encode) return;
    }
    std::unique_lock lock(queue_mutex_);
    queue_changed_.wait(lock, [this] { return queued_bytes_ < most_queued; });
    queued_bytes_ += result->bytes;
    queue_.push_back({key, std::move(result), same});
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
    for (const Heard& h : job.result->heard) {
        record.heard.push_back({name_of(h.from), h.frame, h.text});
    }
    for (const Written& w : job.result->files) {
        record.files.push_back({w.path.string(), name_of(w.digest)});
    }
    record.seconds = job.result->seconds;
    record.bytes = job.result->bytes;
    graph::Encoder e;
    graph::encode(record, e);
    const fs::path path = path_of("records", job.key);
    if (write_file(path, FileKind::record, e.bytes) && job.same)
        link(path, path_of("same", job.same));
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
        set_aside(path, "it can't be read");
        return std::nullopt;
    }
}

void DiskCache::store_list(const Key& key, const std::vector<std::string>& names)
{
    graph::Encoder e;
    graph::encode(names, e);
    write_file(path_of("lists", key), FileKind::list, e.bytes);
}

// ---- housekeeping -------------------------------------------------------------------------------

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
    for (const char* folder : {"records", "same"}) {
        each_file(folder_ / folder, [&](const fs::directory_entry& file) {
            // A file of two names is one file.
            if (folder[0] == 's' && file.hard_link_count() > 1) return;
            tell(read_record(file.path()).has_value());
        });
    }
    each_file(folder_ / "lists", [&](const fs::directory_entry& file) {
        tell(read_file(file.path(), FileKind::list).has_value());
    });
    each_file(folder_ / "contents", [&](const fs::directory_entry& file) {
        const std::optional<FileBytes> bytes = read_file(file.path(), FileKind::content);
        if (!bytes) return tell(false);
        const std::string name =
            file.path().parent_path().filename().string() + file.path().filename().string();
        const std::string_view all = bytes->view();
        const bool named_right = hash_bytes(all.data(), all.size()) == from_hex(name);
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
    for (const char* folder : {"records", "contents", "lists"}) {
        each_temporary(folder_ / folder, [&](const fs::directory_entry& file) {
            if (age_of(file.path()) > grace) remove(file.path(), file.file_size(ignored));
        });
    }
    constexpr double week = 7 * 24 * 3600;  // to look at them
    each_file(folder_ / "aside", [&](const fs::directory_entry& file) {
        if (age_of(file.path()) > week) remove(file.path(), file.file_size(ignored));
    });
    each_file(folder_ / "contents", [&](const fs::directory_entry& file) {
        const Key key = from_hex(file.path().parent_path().filename().string() +
                                 file.path().filename().string());
        const std::uintmax_t size = file.file_size(ignored);
        total += size;
        contents[{key.low, key.high}] = {size, 0, file.path()};
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
        if (content.users > 0 || content.path.empty()) continue;
        if (age_of(content.path) > grace) {
            remove(content.path, content.size);
        } else {  // it goes later, unless it is named; nothing else has to make room for it
            total -= std::min(total, content.size);
        }
    }
    // A second name alone keeps no content alive.
    const auto drop_second_names = [&] {
        each_file(folder_ / "same", [&](const fs::directory_entry& file) {
            if (file.hard_link_count(ignored) < 2) remove(file.path(), file.file_size(ignored));
        });
    };
    if (total <= budget) return drop_second_names(), gone;
    // A little more than asked for, so that the next write does not start over.
    constexpr double moment = 10;  // s, from a content to the record that names it
    for (const Old& old : records) {
        if (total <= budget / 10 * 9) break;
        remove(old.path, old.size);
        for (const ContentName& name : old.names) {
            Content& content = contents[name];
            if (--content.users > 0 || content.path.empty()) continue;
            // A moment ago another record may have been about to name it: its time comes later.
            if (grace == 0 || age_of(content.path) > moment) {
                remove(content.path, content.size);
            } else {
                total -= std::min(total, content.size);
            }
        }
    }
    drop_second_names();
    return gone;
}

void DiskCache::clear()
{
    flush();
    for (const char* folder : {"records", "same", "contents", "lists", "aside"}) {
        std::error_code ignored;
        fs::remove_all(folder_ / folder, ignored);
    }
}

}  // namespace runtime
