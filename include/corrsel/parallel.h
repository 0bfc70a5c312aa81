#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <future>
#include <vector>

namespace corrsel::core {

/// Calls work() on `threads` threads, the caller's included, and passes on the first exception once all have
/// stopped.
template <class Work>
void onThreads(std::size_t threads, const Work& work) {
  std::vector<std::future<void>> others;
  for (std::size_t i = 1; i < threads; ++i) others.push_back(std::async(std::launch::async, work));
  work();
  for (std::future<void>& other : others) other.get();
}

/// Calls body(begin, end) for consecutive blocks of [0, n), on up to `threads` threads that take one block
/// after the other. Blocks may run in any order and at the same time: the
/// body must write to places of its own. Exceptions as in onThreads().
template <class Body>
void forEachBlock(std::size_t n, std::size_t block, int threads, const Body& body) {
  const std::size_t blocks = (n + block - 1) / block;
  std::atomic<std::size_t> next{0};
  onThreads(std::min(blocks, static_cast<std::size_t>(std::max(1, threads))), [&] {
    for (std::size_t i = next++; i < blocks; i = next++) body(i * block, std::min(n, (i + 1) * block));
  });
}

}  // namespace corrsel::core
