#pragma once

// Files that a node opened beside those its parameters name: a material library, a texture. Which
// they are is known only after the node ran, so its key has two levels:
//   K1 = hash(type, parameters, bytes of the named files, inputs)
//   K  = hash(K1, for each file of the list its name and bytes, or that it is not there or refused)
// A list is remembered by K1 and the name of the named file: readers also look for files with the
// model's own name, "chair.mtl" beside "chair.obj". What opens nothing is shared by all names.
// A key K counts only once a node ran and confirmed it: another list may hold for other bytes.

#include "runtime/cache/file_digests.hpp"

#include <set>
#include <unordered_set>

namespace runtime {

class DiskCache;

class SideFiles {
public:
    // Lists of other processes, and where to leave ours; may be null.
    void remember_in(DiskCache* disk) { disk_ = disk; }

    // Where a node may read: the folder of the named file, to which lists are relative, so that
    // they hold wherever the project lies; the name of that file; and the folder that all must lie
    // in, empty: anywhere. What lies outside of that is refused, and counts as that: its bytes are
    // not looked at.
    struct Place {
        std::filesystem::path folder, name, root;
    };
    static bool refused(const std::filesystem::path& path, const std::filesystem::path& root);

    // K for K1 as the files are now, and whether a run has confirmed it.
    struct Look {
        Key key;
        bool confirmed = false;
    };
    Look look(const Key& first, const Place& place, FileDigests& files);

    // The files of the list; empty when there is none.
    std::vector<std::filesystem::path> names(const Key& first, const Place& place);

    // A node of key K1 ran and opened these. Returns K.
    Key confirm(const Key& first, const Place& place, const std::set<std::filesystem::path>& opened,
                FileDigests& files);

private:
    using List = std::vector<std::string>;
    static Key key(const Key& first, const List& list, const Place& place, FileDigests& files);

    const List* list(const Key& listed);
    bool confirmed(const Key& key);

    DiskCache* disk_ = nullptr;
    std::mutex mutex_;
    std::unordered_map<Key, List, KeyHash> lists_;  // by K1 and name
    std::unordered_set<Key, KeyHash> confirmed_;    // K
};

}  // namespace runtime
