#pragma once

// From keys to places in an array of its owner's, where what belongs to the key stands. Linear
// probing; what is removed leaves no mark, those behind it move up.
//   Knuth. The Art of Computer Programming, volume 3, 1998, section 6.4, algorithms L and R.
// A slot holds 32 bits of the key beside the place, 8 bytes in all: that a key is not there, or
// where it is, is nearly always known from one line of memory, however large the records are.

#include "runtime/cache/key.hpp"

#include <utility>
#include <vector>

namespace runtime {

class KeyTable {
public:
    static constexpr std::uint32_t none = 0xffff'ffff;

    // The place that was put in with the key, or none. key_of(place) is the key of a place.
    template <class KeyOf> std::uint32_t find(const Key& key, const KeyOf& key_of) const
    {
        if (count_ == 0) return none;
        const auto mark = mark_of(key);
        for (std::size_t at = mark & mask_; slots_[at].place != none; at = (at + 1) & mask_) {
            if (slots_[at].mark == mark && key_of(slots_[at].place) == key) return slots_[at].place;
        }
        return none;
    }

    // The key must not be there yet.
    void insert(const Key& key, std::uint32_t place)
    {
        if (2 * (count_ + 1) > slots_.size()) grow();
        put({mark_of(key), place});
        ++count_;
    }

    // Both must be there together.
    void erase(const Key& key, std::uint32_t place)
    {
        std::size_t hole = mark_of(key) & mask_;
        while (slots_[hole].place != place) hole = (hole + 1) & mask_;
        for (std::size_t at = (hole + 1) & mask_; slots_[at].place != none; at = (at + 1) & mask_) {
            // It may move up as far as where its own search begins.
            if (((at - slots_[at].mark) & mask_) < ((at - hole) & mask_)) continue;
            slots_[hole] = slots_[at];
            hole = at;
        }
        slots_[hole] = {};
        --count_;
    }

    // Has what is stored of the key fetched while other work goes on: in a table larger than the
    // processor's caches it takes as long as all the rest of a brief node.
    void expect(const Key& key) const
    {
        if (!slots_.empty()) __builtin_prefetch(&slots_[mark_of(key) & mask_], 1);
    }

    std::size_t size() const { return count_; }

private:
    struct Slot {
        std::uint32_t mark = 0;
        std::uint32_t place = none;
    };
    static std::uint32_t mark_of(const Key& key) { return static_cast<std::uint32_t>(key.low); }

    void put(Slot slot)
    {
        std::size_t at = slot.mark & mask_;
        while (slots_[at].place != none) at = (at + 1) & mask_;
        slots_[at] = slot;
    }
    void grow()
    {
        const std::vector<Slot> old = std::exchange(slots_, {});
        slots_.resize(std::max<std::size_t>(64, 2 * old.size()));
        mask_ = slots_.size() - 1;
        for (const Slot& slot : old) {
            if (slot.place != none) put(slot);
        }
    }

    std::vector<Slot> slots_;  // a power of two of them
    std::size_t mask_ = 0, count_ = 0;
};

}  // namespace runtime
