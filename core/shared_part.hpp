// A part of the model that few elements have, or that many have alike.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

namespace gudgeon {

/// An optional value on the heap: empty it takes no more room than a pointer, and copies share the value
/// until one of them is changed. Used like std::optional; reading does not allocate, changing a shared value
/// copies it first. Copies may be read by several threads at a time, as those of other types.
template <class T> class SharedPart {
  public:
    SharedPart() = default;
    SharedPart(std::nullopt_t) {}
    template <
        class U = T, class Plain = std::remove_cv_t<std::remove_reference_t<U>>,
        class = std::enable_if_t<std::is_constructible_v<T, U&&> && !std::is_same_v<Plain, SharedPart> &&
                                 !std::is_same_v<Plain, std::nullopt_t>>>
    SharedPart(U&& value) : value_(std::make_shared<T>(std::forward<U>(value))) {}

    bool has_value() const { return value_ != nullptr; }
    explicit operator bool() const { return has_value(); }
    const T& operator*() const { return *value_; }
    const T* operator->() const { return value_.get(); }
    const T& value() const {
        if (!value_)
            throw std::bad_optional_access();
        return *value_;
    }

    T& operator*() { return own(); }
    T* operator->() { return &own(); }
    T& emplace() { return *(value_ = std::make_shared<T>()); }
    void reset() { value_.reset(); }

    /// Takes the value of `other` over where both are equal, so that it is stored once.
    bool share_if_equal(const SharedPart& other) {
        if (!value_ || !other.value_)
            return false;
        if (value_ != other.value_) {
            if (!(*value_ == *other.value_))
                return false;
            value_ = other.value_;
        }
        return true;
    }
    bool shares(const SharedPart& other) const { return value_ == other.value_; }

  private:
    T& own() {
        if (value_.use_count() > 1)
            value_ = std::make_shared<T>(*value_);
        else
            std::atomic_thread_fence(
                std::memory_order_acquire); // another thread may have given it up just now
        return *value_;
    }

    std::shared_ptr<T> value_;
};

} // namespace gudgeon
