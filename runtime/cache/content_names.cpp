#include "runtime/cache/content_names.hpp"

#include "graph/types/encode.hpp"

#include <xxhash.h>

namespace runtime {

using graph::ContentName;

ContentName ContentNames::of(const graph::Value& value)
{
    if (!value || !value.type()->encode) return {};
    return of(value.content(), value.type()->layout, value.type()->encode);
}

ContentName ContentNames::of(const void* content, const std::string& layout, Encode encode)
{
    const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(),
                                                                         XXH3_freeState);
    if (!state) throw std::bad_alloc();
    XXH3_128bits_reset(state.get());
    graph::Encoder e;
    e.sink = [&](const void* data, std::size_t size) {
        XXH3_128bits_update(state.get(), data, size);
    };
    e.share = [this](const std::shared_ptr<const void>& part, const std::string& part_layout,
                     Encode encode_part) {
        {
            const std::lock_guard lock(mutex_);
            const auto found = shared_.find(part.get());
            if (found != shared_.end() && !found->second.content.expired()) {
                return found->second.name;
            }
        }
        const ContentName name = of(part.get(), part_layout, encode_part);
        const std::lock_guard lock(mutex_);
        std::erase_if(shared_, [](const auto& s) { return s.second.content.expired(); });
        shared_[part.get()] = {part, name};
        return name;
    };
    graph::encode(layout, e);
    encode(content, e);
    e.drain();
    const XXH128_hash_t hash = XXH3_128bits_digest(state.get());
    return {hash.low64, hash.high64};
}

}  // namespace runtime
