#include "runtime/cook/side_files.hpp"

#include "graph/document/path_rules.hpp"
#include "runtime/cache/disk_cache.hpp"

namespace runtime {

namespace {

// The key of the list.
Key list_key(const Key& first, const SideFiles::Place& place)
{
    KeyBuilder builder;
    return builder.add(first).add("list").add(place.name.generic_string()).key();
}

}  // namespace

bool SideFiles::refused(const std::filesystem::path& path, const std::filesystem::path& root)
{
    namespace fs = std::filesystem;
    if (root.empty()) return false;
    std::error_code none;
    return !graph::lies_in(fs::weakly_canonical(fs::absolute(path, none), none),
                           fs::weakly_canonical(fs::absolute(root, none), none));
}

Key SideFiles::key(const Key& first, const List& list, const Place& place, FileDigests& files)
{
    KeyBuilder builder;
    builder.add(first).add("side files").add(list.size());
    for (const std::string& name : list) {
        const std::filesystem::path path = place.folder / name;
        if (refused(path, place.root)) {
            builder.add(name).add("refused");
        } else {
            builder.add(name).add(files.of(path));
        }
    }
    return builder.key();
}

SideFiles::Look SideFiles::look(const Key& first, const Place& place, FileDigests& files)
{
    const std::lock_guard lock(mutex_);
    const List* const names = list(list_key(first, place));
    const Key k = key(first, names ? *names : List(), place, files);
    return {k, confirmed(k)};
}

std::vector<std::filesystem::path> SideFiles::names(const Key& first, const Place& place)
{
    const std::lock_guard lock(mutex_);
    std::vector<std::filesystem::path> all;
    if (const List* const known = list(list_key(first, place))) {
        for (const std::string& name : *known) all.push_back(place.folder / name);
    }
    return all;
}

const SideFiles::List* SideFiles::list(const Key& listed)
{
    const auto known = lists_.find(listed);
    if (known != lists_.end()) return &known->second;
    if (!disk_) return nullptr;
    std::optional<List> stored = disk_->list(listed);
    return stored ? &(lists_[listed] = std::move(*stored)) : nullptr;
}

bool SideFiles::confirmed(const Key& key)
{
    if (confirmed_.contains(key)) return true;
    // On disk a confirmation is an empty list under K itself.
    if (!disk_ || !disk_->list(key)) return false;
    confirmed_.insert(key);
    return true;
}

Key SideFiles::confirm(const Key& first, const Place& place,
                       const std::set<std::filesystem::path>& opened, FileDigests& files)
{
    List list;
    for (const std::filesystem::path& path : opened) {
        list.push_back(path.lexically_proximate(place.folder).generic_string());
    }
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    const std::lock_guard lock(mutex_);
    const Key k = key(first, list, place, files);
    const Key listed = list_key(first, place);
    if (disk_) disk_->store_list(listed, list), disk_->store_list(k, {});
    lists_[listed] = std::move(list);
    confirmed_.insert(k);
    return k;
}

}  // namespace runtime
