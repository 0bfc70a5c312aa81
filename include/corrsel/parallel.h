#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <future>
#include <vector>

namespace corrsel::core {

/// Calls body(begin, end) for consecutive blocks of [0, n), on up to `threads` threads that take one block
/// after the other; the caller's thread is one of them. Blocks may run in any order and at the same time: the
/// body must write to places of its own. The first exception is passed on once all threads have stopped.
template <class Body>
void forEachBlock(std::size_t n, std::size_t block, int threads, const Body& body) {
  const std::size_t blocks = (n + block - 1) / block;
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < blocks; i = next++) body(i * block, std::min(n, (i + 1) * block));
  };
  std::vector<std::future<void>> others;
  for (std::size_t i = 1; i < std::min(blocks, static_cast<std::size_t>(std::max(1, threads))); ++i) {
    others.push_back(std::async(std::launch::async, work));
  }
  work();
  for (std::future<void>& other : others) other.get();
}

}  // namespace corrsel::core
