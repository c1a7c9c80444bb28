#pragma once

// Names of values by what is in them: the hash of the bytes that the disk cache would store. Two
// results whose values have the same names are the same, however they came about.

#include "graph/types/encoder.hpp"
#include "graph/types/value.hpp"

#include <map>
#include <mutex>

namespace runtime {

// Safe to use from many threads.
class ContentNames {
public:
    // All zero for a value that is empty or of a type that can't be stored.
    graph::ContentName of(const graph::Value& value);

private:
    using Encode = void (*)(const void*, graph::Encoder&);
    graph::ContentName of(const void* content, const std::string& layout, Encode encode);

    struct Known {
        std::weak_ptr<const void> content;
        graph::ContentName name;
    };
    std::mutex mutex_;
    std::map<const void*, Known> shared_;  // parts that many values share, by where they are
};

}  // namespace runtime
