#pragma once

// What the disk cache holds of one result beside its values: which contents they are, what it cost,
// its warnings, its figures and the files that it wrote. It is stored field by field, so a change
// here needs another version of the cache's format (disk_cache.cpp).

#include "runtime/cache/result.hpp"

#include <optional>
#include <string>
#include <vector>

namespace runtime {

struct CacheRecord {
    struct Output {
        bool there = false;
        graph::ContentName name{};
    };
    struct WrittenFile {
        std::string path;
        graph::ContentName digest{};
    };
    std::vector<Output> outputs;
    std::vector<graph::ContentName> names;  // all contents that it needs, shared parts included
    struct Heard {
        graph::ContentName from{};
        int frame = 0;
        std::string text;
    };
    struct Told {
        graph::ContentName from{};
        int frame = 0;
        std::string node, type;
        graph::Figures figures;
    };
    std::vector<std::string> warnings;
    std::vector<Heard> heard;
    graph::Figures figures;
    std::vector<Told> told;
    std::vector<WrittenFile> files;
    double seconds = 0;
    std::uint64_t bytes = 0;
};

// A content's name and the key of its file are the same 128 bits.
inline Key key_of(const graph::ContentName& name)
{
    return {name[0], name[1]};
}
inline graph::ContentName name_of(const Key& key)
{
    return {key.low, key.high};
}

// The record of a result, without its outputs and names: they are known once its values are stored.
CacheRecord record_of(const Result& result);

// All but the values into the result.
void take_record(const CacheRecord& record, Result& result);

}  // namespace runtime
