// Tending the folder of the disk cache as a whole: counting, checking, shrinking and clearing it.

#include "runtime/cache/cache_record.hpp"
#include "runtime/cache/disk_cache.hpp"
#include "runtime/cache/whole_file.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <unistd.h>

namespace runtime {

namespace fs = std::filesystem;
using graph::ContentName;

namespace {

using Time = fs::file_time_type;

// When it was written; now, when that is not known.
Time time_of(const fs::path& path)
{
    std::error_code error;
    const Time time = fs::last_write_time(path, error);
    return error ? Time::clock::now() : time;
}
double age_of(Time time)
{
    return std::chrono::duration<double>(Time::clock::now() - time).count();
}
double age_of(const fs::path& path)
{
    return age_of(time_of(path));
}

// Returns whether all of the folder could be listed; one that is not there is empty.
template <class F> bool each_of(const fs::path& folder, bool unfinished, const F& f)
{
    std::error_code error;
    fs::recursive_directory_iterator at(folder, error), end;
    while (!error && at != end) {
        std::error_code ignored;
        if (at->is_regular_file(ignored) && is_unfinished(at->path()) == unfinished) f(*at);
        at.increment(error);
    }
    return !error || error == std::errc::no_such_file_or_directory;
}
template <class F> bool each_file(const fs::path& folder, const F& f)
{
    return each_of(folder, false, f);
}
template <class F> bool each_unfinished(const fs::path& folder, const F& f)
{
    return each_of(folder, true, f);
}

}  // namespace

std::unordered_set<Key, KeyHash> DiskCache::all_held() const
{
    std::unordered_set<Key, KeyHash> keys;
    each_file(folder_ / "records",
              [&](const fs::directory_entry& file) { keys.insert(key_of_file(file.path())); });
    return keys;
}

DiskUse DiskCache::use() const
{
    DiskUse use;
    const auto count = [&](const char* folder, std::size_t& files) {
        each_file(folder_ / folder, [&](const fs::directory_entry& file) {
            ++files;
            use.bytes += size_on_disk(file.path());
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
    const auto check_all = [&](const char* folder, const auto& is_good) {
        const bool listed = each_file(folder_ / folder, [&](const fs::directory_entry& file) {
            if (::access(file.path().c_str(), R_OK) != 0) {
                ++check.unread;
            } else {
                is_good(file) ? ++check.good : ++check.bad;
            }
        });
        if (!listed) ++check.unread;
    };
    check_all("records", [&](const fs::directory_entry& file) {
        return read_record(file.path()).has_value();
    });
    check_all("lists", [&](const fs::directory_entry& file) {
        return read_file(file.path(), FileKind::list).has_value();
    });
    check_all("contents", [&](const fs::directory_entry& file) {
        const std::optional<FileBytes> bytes = read_file(file.path(), FileKind::content);
        if (!bytes) return false;
        const std::string_view all = bytes->view();
        const bool named_right = hash_bytes(all.data(), all.size()) == key_of_file(file.path());
        if (!named_right) set_aside(file.path(), "content does not match its name");
        return named_right;
    });
    const bool listed = each_file(folder_ / "same", [&](const fs::directory_entry& file) {
        std::error_code ignored;
        const bool counted = file.hard_link_count(ignored) > 1;  // a file of two names is one
        if (!read_record(file.path())) {
            ++check.bad;
        } else if (!counted) {
            ++check.good;
        }
    });
    if (!listed) ++check.unread;
    return check;
}

namespace {

struct Content {
    std::uintmax_t size = 0;
    std::size_t users = 0;     // records that name it
    fs::path path;             // empty when it is not there
    Time named = Time::min();  // when the last record that names it was written
};

struct OldRecord {
    fs::path path;
    std::vector<ContentName> names;
    double worth = 0;
    std::uintmax_t size = 0;
};

// What lies in the folder, while some of it is removed.
struct Stock {
    std::map<ContentName, Content> contents;
    std::vector<OldRecord> records;
    std::uintmax_t total = 0, gone = 0;  // bytes

    void remove(const fs::path& path, std::uintmax_t size)
    {
        std::error_code ignored;
        if (fs::remove(path, ignored)) gone += size, leave_out(size);
    }
    // It stays for now, and nothing else has to make room for it.
    void leave_out(std::uintmax_t size) { total -= std::min(total, size); }
};

// Files that a killed writer left, and damaged ones that had their time to be looked at.
void remove_unfinished(const fs::path& folder, Stock& stock)
{
    constexpr double grace = 600;  // s: a slow disk may hold up a write for long
    for (const char* part : {"records", "contents", "lists"}) {
        each_unfinished(folder / part, [&](const fs::directory_entry& file) {
            if (age_of(file.path()) > grace) stock.remove(file.path(), size_on_disk(file.path()));
        });
    }
    constexpr double week = 7 * 24 * 3600;
    each_file(folder / "aside", [&](const fs::directory_entry& file) {
        if (age_of(file.path()) > week) stock.remove(file.path(), size_on_disk(file.path()));
    });
}

void find_contents(const fs::path& folder, Stock& stock)
{
    each_file(folder / "contents", [&](const fs::directory_entry& file) {
        const std::uintmax_t size = size_on_disk(file.path());
        stock.total += size;
        stock.contents[name_of(DiskCache::key_of_file(file.path()))] = {size, 0, file.path(),
                                                                        Time::min()};
    });
}

// Contents that no record names.
void remove_unnamed(double grace, Stock& stock)
{
    for (const auto& [name, content] : stock.contents) {
        if (content.users > 0 || content.path.empty()) continue;
        if (age_of(content.path) > grace) {
            stock.remove(content.path, content.size);
        } else {  // it goes later, unless it is named
            stock.leave_out(content.size);
        }
    }
}

// The least worth first, and the contents that no other record names.
void remove_records(std::uintmax_t budget, double grace, Stock& stock)
{
    std::sort(stock.records.begin(), stock.records.end(),
              [](const OldRecord& a, const OldRecord& b) { return a.worth < b.worth; });
    for (const OldRecord& old : stock.records) {
        if (stock.total <= budget) return;
        stock.remove(old.path, old.size);
        for (const ContentName& name : old.names) {
            Content& content = stock.contents[name];
            if (--content.users > 0 || content.path.empty()) continue;
            // One that is younger than its records was stored again just now, and another process
            // is about to name it: its time comes later.
            const Time time = time_of(content.path);
            if (time > content.named && age_of(time) <= grace) {
                stock.leave_out(content.size);
            } else {
                stock.remove(content.path, content.size);
            }
        }
    }
}

// A second name alone keeps no content alive.
void remove_second_names(const fs::path& folder, Stock& stock)
{
    each_file(folder / "same", [&](const fs::directory_entry& file) {
        std::error_code ignored;
        if (file.hard_link_count(ignored) < 2) {
            stock.remove(file.path(), size_on_disk(file.path()));
        }
    });
}

}  // namespace

std::uintmax_t DiskCache::shrink(std::uintmax_t budget, double grace)
{
    written_ = 0;
    const std::string told_before = told_since_a_look();
    Stock stock;
    remove_unfinished(folder_, stock);
    find_contents(folder_, stock);
    each_file(folder_ / "records", [&](const fs::directory_entry& file) {
        stock.total += size_on_disk(file.path());
        const Time time = time_of(file.path());
        const std::optional<CacheRecord> record = read_record(file.path());
        if (!record) return;
        OldRecord old{file.path(), record->names, 0, size_on_disk(file.path())};
        double bytes = static_cast<double>(old.size);
        for (const ContentName& name : record->names) {
            Content& content = stock.contents[name];
            ++content.users;
            content.named = std::max(content.named, time);
            bytes += static_cast<double>(content.size);
        }
        old.worth = (record->seconds + 1e-3) / (bytes * (age_of(time) + 1));
        stock.records.push_back(std::move(old));
    });
    const std::uintmax_t found = stock.total, gone_before = stock.gone;
    remove_unnamed(grace, stock);
    // A little more than asked for, so that the next write does not start over.
    if (stock.total > budget) remove_records(budget / 10 * 9, grace, stock);
    const std::uintmax_t gone =
        stock.gone - gone_before;  // second names are none of what was found
    remove_second_names(folder_, stock);
    note_size(found - std::min(found, gone), told_before);
    return stock.gone;
}

// ---- how much there is, without a look at all of it ---------------------------------------------

namespace {

// A line of bytes and seconds since 1970, when somebody looked; then one of bytes for each process
// that wrote since then.
constexpr const char* notes = "size.txt";

std::int64_t seconds_now()
{
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return std::chrono::duration_cast<std::chrono::seconds>(now).count();
}

}  // namespace

std::optional<std::uintmax_t> DiskCache::bytes_by_notes() const
{
    constexpr std::int64_t minute = 60, day = 24 * 3600;
    std::ifstream in(folder_ / notes);
    std::uintmax_t bytes = 0, more = 0;
    std::int64_t then = 0;
    const std::int64_t now = seconds_now();
    if (!(in >> bytes >> then) || then < now - day || then > now + minute) return std::nullopt;
    while (in >> more) bytes += more;
    if (!in.eof()) return std::nullopt;
    return bytes;
}

std::string DiskCache::told_since_a_look() const
{
    std::ifstream in(folder_ / notes);
    std::string look;
    std::getline(in, look);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

// What others told during the look may be counted twice, and is not lost: only what is told between
// the last two lines here is.
void DiskCache::note_size(std::uintmax_t bytes, const std::string& told_before) const
{
    std::error_code error;
    if (!fs::exists(folder_, error)) return;
    std::string text = std::to_string(bytes) + ' ' + std::to_string(seconds_now()) + '\n';
    const std::string told = told_since_a_look();
    // Where it is not longer by what was told, another process has looked in between.
    text += told.starts_with(told_before) ? told.substr(told_before.size()) : told;
    const std::string_view pieces[] = {text};
    write_whole_file(folder_ / notes, pieces);  // without it the next process looks
}

void DiskCache::tend()
{
    if (written_ == 0) return;
    const std::optional<std::uintmax_t> before = bytes_by_notes();
    if (!before || *before + written_ > budget_) {
        shrink(budget_);
        return;
    }
    const std::string line = std::to_string(written_) + '\n';
    std::ofstream(folder_ / notes, std::ios::app).write(line.data(), std::ssize(line));
}

void DiskCache::clear()
{
    flush();
    std::error_code error;
    fs::remove(folder_ / notes, error);
    for (const char* folder : {"records", "same", "contents", "lists", "aside"}) {
        std::error_code ignored;
        fs::remove_all(folder_ / folder, ignored);
    }
}

}  // namespace runtime
