#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <functional>
#include <future>
#include <vector>

namespace corrsel::core {

/// Threads beside the calling one. They are kept for the next Crew of the calling thread and end with that
/// thread. OpenCV keeps almost a kilobyte for every thread that has ever called it, so new threads for every
/// image would add up. Crews of a thread may be nested. Other threads must not use them.
class Crew {
 public:
  Crew();
  /// Waits until all started work has ended.
  ~Crew();
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  /// Calls work() on another thread. The future carries its exceptions. Throws std::system_error if no more
  /// threads can be started.
  std::future<void> start(std::function<void()> work);

 private:
  std::size_t first_;  ///< of this crew among the kept threads
};

/// Calls work() on `threads` threads, including the caller's, and rethrows the first exception once all have
/// stopped.
template <class Work>
void onThreads(std::size_t threads, const Work& work) {
  Crew crew;
  std::vector<std::future<void>> others;
  for (std::size_t i = 1; i < threads; ++i) others.push_back(crew.start(std::cref(work)));
  work();
  for (std::future<void>& other : others) other.get();
}

/// Calls body(begin, end) for consecutive blocks of [0, n), on up to `threads` threads that take one block
/// after the other. Blocks may run in any order and at the same time, so each must write to its own memory
/// only. Exceptions as in onThreads().
template <class Body>
void forEachBlock(std::size_t n, std::size_t block, int threads, const Body& body) {
  const std::size_t blocks = (n + block - 1) / block;
  std::atomic<std::size_t> next{0};
  onThreads(std::min(blocks, static_cast<std::size_t>(std::max(1, threads))), [&] {
    for (std::size_t i = next++; i < blocks; i = next++) body(i * block, std::min(n, (i + 1) * block));
  });
}

}  // namespace corrsel::core
