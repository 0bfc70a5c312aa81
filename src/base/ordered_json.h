#pragma once

#include <nlohmann/json.hpp>

#if NLOHMANN_JSON_VERSION_MAJOR == 3 && NLOHMANN_JSON_VERSION_MINOR < 9
#include <algorithm>
#include <iterator>
#include <list>
#include <stdexcept>
#include <tuple>
#include <utility>
#endif

namespace corrsel::core {

#if NLOHMANN_JSON_VERSION_MAJOR == 3 && NLOHMANN_JSON_VERSION_MINOR < 9
/// A map of few keys that keeps them in the order of their insertion. Look-ups are linear.
template <class Key, class Value, class Less, class Allocator>
class InsertionOrderedMap : public std::list<std::pair<const Key, Value>, Allocator> {
  using Base = std::list<std::pair<const Key, Value>, Allocator>;

 public:
  using key_type = Key;
  using mapped_type = Value;
  using key_compare = Less;
  using Base::Base;
  using Base::erase;
  using typename Base::const_iterator;
  using typename Base::iterator;
  using typename Base::size_type;
  using typename Base::value_type;

  iterator find(const Key& key) {
    return std::find_if(this->begin(), this->end(), [&key](const auto& entry) { return entry.first == key; });
  }
  const_iterator find(const Key& key) const {
    return std::find_if(this->begin(), this->end(), [&key](const auto& entry) { return entry.first == key; });
  }
  size_type count(const Key& key) const { return find(key) == this->end() ? 0 : 1; }

  /// Adds an entry unless the key is there. Returns the entry of the key, and whether it is new.
  template <class... Arguments>
  std::pair<iterator, bool> emplace(const Key& key, Arguments&&... arguments) {
    const iterator found = find(key);
    if (found != this->end()) return {found, false};
    this->emplace_back(std::piecewise_construct, std::forward_as_tuple(key),
                       std::forward_as_tuple(std::forward<Arguments>(arguments)...));
    return {std::prev(this->end()), true};
  }
  std::pair<iterator, bool> insert(const value_type& entry) { return emplace(entry.first, entry.second); }
  template <class Iterator>
  void insert(Iterator first, Iterator last) {
    for (; first != last; ++first) emplace(first->first, first->second);
  }

  Value& operator[](const Key& key) { return emplace(key).first->second; }
  Value& at(const Key& key) {
    const iterator found = find(key);
    if (found == this->end()) throw std::out_of_range("key not found");
    return found->second;
  }
  const Value& at(const Key& key) const {
    const const_iterator found = find(key);
    if (found == this->end()) throw std::out_of_range("key not found");
    return found->second;
  }
  size_type erase(const Key& key) {
    const iterator found = find(key);
    if (found == this->end()) return 0;
    erase(found);
    return 1;
  }
};

/// JSON whose objects keep the order of their keys; nlohmann-json has it from version 3.9 on.
using OrderedJson = nlohmann::basic_json<InsertionOrderedMap>;
#else
using OrderedJson = nlohmann::ordered_json;
#endif

}  // namespace corrsel::core
