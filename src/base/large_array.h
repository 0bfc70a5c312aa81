#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

namespace corrsel::core {

/// Deleter of memory that std::aligned_alloc() has returned.
struct FreeMemory {
  void operator()(void* memory) const { std::free(memory); }
};

template <class T>
using LargeArray = std::unique_ptr<T[], FreeMemory>;

/// Returns memory for an array of up to hundreds of megabytes. Its values are undefined. The memory is in
/// huge pages where the system gives them on request. The first access to each page interrupts the program,
/// and on virtual machines the interruptions of small pages can take longer than all work on the array.
/// @throws std::bad_alloc
template <class T>
LargeArray<T> makeLargeArray(std::size_t count) {
  static_assert(std::is_trivial_v<T>);
  constexpr std::size_t kHugePage = std::size_t{2} << 20;
  const std::size_t bytes = (count * sizeof(T) / kHugePage + 1) * kHugePage;
  void* const memory = std::aligned_alloc(kHugePage, bytes);
  if (memory == nullptr) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
  // Without huge pages the call fails, and the memory has small ones.
  madvise(memory, bytes, MADV_HUGEPAGE);
#endif
  return LargeArray<T>(static_cast<T*>(memory));
}

}  // namespace corrsel::core
