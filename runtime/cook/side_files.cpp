#include "runtime/cook/side_files.hpp"

#include "runtime/cache/disk_cache.hpp"

namespace runtime {

Key SideFiles::key(const Key& first, const List& list, const std::filesystem::path& folder,
                   FileDigests& files)
{
    KeyBuilder builder;
    builder.add(first).add("side files").add(list.size());
    for (const std::string& name : list) {
        builder.add(name).add(files.of(folder / name));
    }
    return builder.key();
}

SideFiles::Look SideFiles::look(const Key& first, const std::filesystem::path& folder,
                                FileDigests& files)
{
    const std::lock_guard lock(mutex_);
    const List* const names = list(first);
    if (!names) return {key(first, {}, folder, files), false};
    const Key k = key(first, *names, folder, files);
    return {k, confirmed(k)};
}

std::vector<std::filesystem::path> SideFiles::names(const Key& first,
                                                    const std::filesystem::path& folder)
{
    const std::lock_guard lock(mutex_);
    std::vector<std::filesystem::path> all;
    if (const List* const known = list(first)) {
        for (const std::string& name : *known) all.push_back(folder / name);
    }
    return all;
}

const SideFiles::List* SideFiles::list(const Key& first)
{
    const auto known = lists_.find(first);
    if (known != lists_.end()) return &known->second;
    if (!disk_) return nullptr;
    std::optional<List> stored = disk_->list(first);
    return stored ? &(lists_[first] = std::move(*stored)) : nullptr;
}

bool SideFiles::confirmed(const Key& key)
{
    if (confirmed_.contains(key)) return true;
    // On disk a confirmation is an empty list under K itself.
    if (!disk_ || !disk_->list(key)) return false;
    confirmed_.insert(key);
    return true;
}

Key SideFiles::confirm(const Key& first, const std::filesystem::path& folder,
                       const std::set<std::filesystem::path>& opened, FileDigests& files)
{
    List list;
    for (const std::filesystem::path& path : opened) {
        list.push_back(path.lexically_proximate(folder).generic_string());
    }
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    const std::lock_guard lock(mutex_);
    const Key k = key(first, list, folder, files);
    if (disk_) disk_->store_list(first, list), disk_->store_list(k, {});
    lists_[first] = std::move(list);
    confirmed_.insert(k);
    return k;
}

}  // namespace runtime
