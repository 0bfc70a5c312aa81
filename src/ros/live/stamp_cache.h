#pragma once

#include <ros/time.h>

#include <algorithm>
#include <cstddef>
#include <deque>
#include <utility>

namespace corrsel {

/// One entry for each of the newest stamps. When the cache is full, the stamp that came first is dropped. It
/// is meant for a few hundred entries at most: look-up is O(capacity).
template <class T>
class StampCache {
 public:
  /// @pre capacity > 0
  explicit StampCache(std::size_t capacity) : capacity_(capacity) {}

  /// The entry of this stamp, which is made if there is none. The reference is valid until the next call.
  T& operator[](const ros::Time& stamp) {
    if (T* entry = find(stamp)) return *entry;
    if (entries_.size() >= capacity_) entries_.pop_front();
    entries_.emplace_back(stamp, T());
    return entries_.back().second;
  }

  /// Null if there is no entry.
  T* find(const ros::Time& stamp) {
    const auto found = std::find_if(entries_.begin(), entries_.end(),
                                    [&stamp](const auto& entry) { return entry.first == stamp; });
    return found == entries_.end() ? nullptr : &found->second;
  }

  void clear() { entries_.clear(); }
  auto begin() { return entries_.begin(); }
  auto end() { return entries_.end(); }

 private:
  std::size_t capacity_;
  std::deque<std::pair<ros::Time, T>> entries_;
};

}  // namespace corrsel
