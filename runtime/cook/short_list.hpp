#pragma once

// A list that is nearly always short: two elements stand in it, more on the heap. 24 bytes.

#include <algorithm>
#include <cstdint>
#include <type_traits>
#include <utility>

namespace runtime {

template <class T> class ShortList {
    static_assert(std::is_trivially_copyable_v<T> && sizeof(T[1]) <= 8);

public:
    ShortList() = default;
    ShortList(ShortList&& other) noexcept { swap(other); }
    ShortList& operator=(ShortList&& other) noexcept
    {
        ShortList gone(std::move(other));
        swap(gone);
        return *this;
    }
    ~ShortList()
    {
        if (capacity_ > fits) delete[] many_;
    }

    void push_back(T element)
    {
        if (size_ == capacity_) grow();
        begin()[size_++] = element;
    }
    void clear() { *this = ShortList(); }

    T* begin() { return capacity_ > fits ? many_ : own_; }
    T* end() { return begin() + size_; }
    const T* begin() const { return capacity_ > fits ? many_ : own_; }
    const T* end() const { return begin() + size_; }
    T& operator[](std::size_t i) { return begin()[i]; }
    const T& operator[](std::size_t i) const { return begin()[i]; }
    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }

private:
    static constexpr std::uint32_t fits = 2;

    void swap(ShortList& other) noexcept
    {
        std::swap_ranges(bytes(), bytes() + sizeof own_, other.bytes());
        std::swap(size_, other.size_);
        std::swap(capacity_, other.capacity_);
    }
    unsigned char* bytes() { return reinterpret_cast<unsigned char*>(&own_); }
    void grow()
    {
        T* const more = new T[2 * std::size_t{capacity_}];
        std::copy(begin(), end(), more);
        if (capacity_ > fits) delete[] many_;
        many_ = more;
        capacity_ *= 2;
    }

    union {
        T own_[fits] = {};
        T* many_;
    };
    std::uint32_t size_ = 0, capacity_ = fits;
};

}  // namespace runtime
