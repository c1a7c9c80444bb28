#pragma once

// Results kept on disk, shared between graphs, processes and machines.
//
//   records/ab/<key>       which contents a result has, what it cost, its warnings and files
//   same/ab/<key>          the same record (one file of two names) under the key that is made of
//                          the inputs' contents: an edit upstream that changes no byte stops there
//   contents/cd/<name>     one value, named by the hash of its bytes: equal values are one file
//   lists/ef/<key>         side files of a node, see side_files.hpp
//   aside/                 files that did not check out, for people to look at
//   size.txt               about how many bytes all of it is: see bytes_by_notes()
//
// All of it lies in a folder named by the version of this format, so that programs of two versions
// share a folder without taking each other's files for damaged.
//
// Each is a cache_file.hpp and holds its own name: one that stands under another name is not
// believed. Whatever goes wrong here (full disk, no permission, flipped bits) costs a warning and a
// recomputation, never the cook and never a wrong result.

#include "graph/types/codec.hpp"
#include "graph/types/node_type.hpp"
#include "runtime/cache/cache_file.hpp"
#include "runtime/cache/cache_record.hpp"
#include "runtime/cache/result.hpp"

#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <unordered_set>

namespace runtime {

struct DiskUse {
    std::size_t records = 0, contents = 0, lists = 0, aside = 0;  // files
    std::uintmax_t bytes = 0;                                     // that all of them take on disk
};

struct DiskCheck {
    std::size_t good = 0, bad = 0;  // files; the bad ones were set aside
    std::size_t unread = 0;         // files and folders that nobody may read, or that can't be read
};

class DiskCache {
public:
    // `warn` is called at most once for each kind of trouble, from any thread. Never throws for
    // what a file system may do.
    DiskCache(const std::filesystem::path& folder, std::uintmax_t budget,
              std::function<void(const std::string&)> warn);
    ~DiskCache();  // waits until all is written
    DiskCache(const DiskCache&) = delete;

    // $XDG_CACHE_HOME/aspic, or ~/.cache/aspic; empty when neither is known.
    static std::filesystem::path default_folder();

    const std::filesystem::path& folder() const { return folder_; }
    // The key that a file of the cache says by its place.
    static Key key_of_file(const std::filesystem::path& path);
    std::uintmax_t budget() const { return budget_; }
    bool holds(const Key& key) const;
    // Null when it is not there, does not check out, or was written for another layout of the type.
    SharedResult load(const Key& key, const graph::NodeType& type);
    // All results that are stored: for those who ask for very many.
    std::unordered_set<Key, KeyHash> all_held() const;
    // What is stored of a result beside its values; nothing when it is not there.
    std::optional<CacheRecord> record(const Key& key);
    // The result that was stored with this second name.
    SharedResult load_same(const Key& same, const graph::NodeType& type);
    // From now on what is stored under the second name `same` is found under `key` too.
    void call(const Key& key, const Key& same);
    // Writes in the background; waits only while very much is waiting to be written. `same` is a
    // second name, zero for none.
    void store(const Key& key, SharedResult result, const Key& same = {});
    // Whether reading the result back is quicker than making it again.
    static bool pays(double seconds, std::size_t bytes);

    std::optional<std::vector<std::string>> list(const Key& key);
    void store_list(const Key& key, const std::vector<std::string>& names);

    // Waits until everything stored so far is on disk.
    void flush();

    DiskUse use() const;
    DiskCheck verify();
    // Removes what is worth least, by (age * bytes / seconds to make), until `budget` bytes are
    // left. Contents that were written after all records that name them stay until they are older
    // than `grace` seconds, because another process may be about to name them. Returns the bytes
    // that went.
    std::uintmax_t shrink(std::uintmax_t budget, double grace = 60);
    void clear();

private:
    struct Shared {
        std::weak_ptr<const void> content;
        graph::ContentName name;
        std::vector<graph::ContentName> inner;  // names that it names in turn
    };
    struct Job {
        Key key;
        SharedResult result;  // null: the record of the second name gets this key, too
        Key same;
        std::size_t bytes() const { return result ? result->bytes : 0; }
    };
    using Decode = std::shared_ptr<const void> (*)(graph::Decoder&);
    struct Loaded {
        std::weak_ptr<const void> content;
        Decode decode = nullptr;  // says of which type it is
    };

    // At the end: shrinks what may have outgrown the budget. To look at all files, as shrink()
    // does, would cost each of a farm's tasks more, the more the others have stored.
    void tend();
    // What the last look found and what was written since; nothing when that is not known or a day
    // old.
    std::optional<std::uintmax_t> bytes_by_notes() const;
    std::string told_since_a_look() const;  // by those that wrote: the lines
    // After a look; `told_before`: what was told when it began.
    void note_size(std::uintmax_t bytes, const std::string& told_before) const;
    void write_jobs(const std::stop_token& stop);
    void enqueue(Job job);
    void write(const Job& job);
    void write_again(const Key& key, const Key& same);
    void write_record(const CacheRecord& record, const Key& key, const Key& same);
    graph::ContentName write_content(const void* content, const std::string& layout,
                                     void (*encode)(const void*, graph::Encoder&),
                                     std::vector<graph::ContentName>& names);
    graph::Encoder encoder(std::vector<graph::ContentName>& names);
    std::shared_ptr<const void> read_content(const graph::ContentName& name,
                                             const std::string& layout, Decode decode);
    std::optional<CacheRecord> read_record(const std::filesystem::path& path);

    std::filesystem::path path_of(const char* folder, const Key& key) const;
    SharedResult load(const std::filesystem::path& path, const graph::NodeType& type);
    void link(const std::filesystem::path& from, const std::filesystem::path& to);
    // Nothing, without a warning, when there is no such file; a bad one is set aside.
    std::optional<FileBytes> read_file(const std::filesystem::path& path, FileKind kind);
    bool write_file(const std::filesystem::path& path, FileKind kind, const FileNames& names,
                    std::string_view bytes);
    void set_aside(const std::filesystem::path& path, const std::string& why);
    void warn_once(const std::string& kind, const std::string& text);

    std::filesystem::path folder_;
    std::uintmax_t budget_;
    std::function<void(const std::string&)> warn_;
    std::atomic<bool> writable_{true};
    std::atomic<std::uintmax_t> written_{0};  // bytes since the size was last looked at

    ReadBuffers buffers_;

    std::mutex warned_mutex_;
    std::set<std::string> warned_;

    std::mutex shared_mutex_;
    std::map<const void*, Shared> stored_;  // shared parts that were stored, by where they are
    std::map<graph::ContentName, Loaded> loaded_;

    std::mutex queue_mutex_;
    std::condition_variable_any queue_changed_;
    std::deque<Job> queue_;
    std::size_t queued_bytes_ = 0;
    bool writing_ = false;
    std::jthread writer_;  // last: it uses the rest
};

}  // namespace runtime
