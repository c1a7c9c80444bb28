#pragma once

// Shared content in memory, named by its place.

#include "graph/types/codec.hpp"

#include <memory>
#include <string>
#include <string_view>
#include <vector>

struct ContentShelf {
    std::vector<std::string> all;

    graph::Encoder encoder()
    {
        graph::Encoder e;
        e.share = [this](const std::shared_ptr<const void>& content, const std::string&,
                         auto encode) {
            graph::Encoder inner = encoder();
            encode(content.get(), inner);
            all.push_back(inner.bytes);
            return graph::ContentName{all.size() - 1, 0};
        };
        return e;
    }
    graph::Decoder decoder(std::string_view bytes)
    {
        return {bytes, [this](const graph::ContentName& name, const std::string&, auto decode) {
                    graph::Decoder inner = decoder(all.at(name[0]));
                    return decode(inner);
                }};
    }
};
