#include "base/parallel.h"

#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

namespace corrsel::core {
namespace {

/// A thread that does one task after the other.
class Companion {
 public:
  Companion() : thread_([this] { run(); }) {}
  Companion(const Companion&) = delete;
  Companion& operator=(const Companion&) = delete;

  ~Companion() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopped_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  /// Only when the task before has ended.
  std::future<void> start(std::function<void()> work) {
    std::packaged_task<void()> task(std::move(work));
    std::future<void> result = task.get_future();
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      task_ = std::move(task);
      busy_ = true;
    }
    changed_.notify_all();
    return result;
  }

  /// Until the task has ended.
  void wait() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return !busy_; });
  }

 private:
  void run() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return stopped_ || busy_; });
      if (stopped_) return;
      std::packaged_task<void()> task = std::move(task_);
      lock.unlock();
      task();
      task = {};  // its contents belong to the waiting thread
      lock.lock();
      busy_ = false;
      changed_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::packaged_task<void()> task_;
  bool busy_ = false, stopped_ = false;
  std::thread thread_;  // last: it uses all of the above
};

struct Kept {
  std::vector<std::unique_ptr<Companion>> companions;
  std::size_t taken = 0;  ///< the first so many have a crew
};

Kept& kept() {
  static thread_local Kept kept;
  return kept;
}

}  // namespace

Crew::Crew() : first_(kept().taken) {}

Crew::~Crew() {
  Kept& mine = kept();
  for (std::size_t i = first_; i < mine.taken; ++i) mine.companions[i]->wait();
  mine.taken = first_;
}

std::future<void> Crew::start(std::function<void()> work) {
  Kept& mine = kept();
  if (mine.taken == mine.companions.size()) mine.companions.push_back(std::make_unique<Companion>());
  return mine.companions[mine.taken++]->start(std::move(work));
}

}  // namespace corrsel::core
