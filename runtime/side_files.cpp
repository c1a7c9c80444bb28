#include "runtime/side_files.hpp"

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
    const auto list = lists_.find(first);
    if (list == lists_.end()) return {key(first, {}, folder, files), false};
    const Key k = key(first, list->second, folder, files);
    return {k, confirmed_.contains(k)};
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
    lists_[first] = std::move(list);
    confirmed_.insert(k);
    return k;
}

}  // namespace runtime
