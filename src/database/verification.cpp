#include "corrsel/database/verification.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <future>
#include <iterator>
#include <limits>
#include <map>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "database/keypoint_cache.h"

namespace corrsel::core {
namespace {

/// Pairs of one thread that are read and not yet stored.
constexpr std::size_t kWindow = 64;

/// A pair that was read, and its number among the pairs of the run.
struct Task {
  std::size_t number = 0;
  PairInput input;
};

/// What the threads share: pairs that were read and wait, and results that are not yet taken.
class Window {
 public:
  void add(std::vector<Task> tasks) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      std::move(tasks.begin(), tasks.end(), std::back_inserter(waiting_));
    }
    has_work_.notify_all();
  }

  std::size_t waiting() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return waiting_.size();
  }

  /// The next pair, if one waits.
  bool takeNow(Task& task) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return pop(task);
  }

  /// The next pair, as soon as one waits. @return false after close()
  bool take(Task& task) {
    std::unique_lock<std::mutex> lock(mutex_);
    has_work_.wait(lock, [this] { return closed_ || !waiting_.empty(); });
    return pop(task);
  }

  void finish(std::size_t number, VerifiedPair result) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      finished_.emplace(number, std::move(result));
    }
    has_result_.notify_one();
  }

  void fail(std::exception_ptr failure) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!failure_) failure_ = std::move(failure);
    }
    has_result_.notify_one();
  }

  /// Moves the results from `next` on, up to the first that is missing, until there are `limit` results.
  /// Rethrows what a thread has thrown.
  void collect(std::size_t next, std::size_t limit, std::vector<VerifiedPair>& results) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
    while (results.size() < limit && !finished_.empty() && finished_.begin()->first == next) {
      results.push_back(std::move(finished_.begin()->second));
      finished_.erase(finished_.begin());
      ++next;
    }
  }

  /// Waits until collect(next) has something to do.
  void await(std::size_t next) {
    std::unique_lock<std::mutex> lock(mutex_);
    has_result_.wait(lock,
                     [&] { return failure_ || (!finished_.empty() && finished_.begin()->first == next); });
  }

  /// Drops the pairs that wait. @return the number of the first of them, or `none`
  std::size_t drop(std::size_t none) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const std::size_t first = waiting_.empty() ? none : waiting_.front().number;
    waiting_.clear();
    return first;
  }

  /// Ends the threads that wait for a pair.
  void close() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      waiting_.clear();
      closed_ = true;
    }
    has_work_.notify_all();
  }

 private:
  bool pop(Task& task) {
    if (waiting_.empty()) return false;
    task = std::move(waiting_.front());
    waiting_.pop_front();
    return true;
  }

  mutable std::mutex mutex_;
  std::condition_variable has_work_, has_result_;
  std::deque<Task> waiting_;
  std::map<std::size_t, VerifiedPair> finished_;
  std::exception_ptr failure_;
  bool closed_ = false;
};

VerifiedPair faultyPair(const ImagePairKey& pair, const std::string& message) {
  VerifiedPair result;
  result.pair = pair;
  result.status = Status::kFailed;
  result.confidence = result.ambiguity = std::numeric_limits<double>::quiet_NaN();
  result.message = message;
  result.faulty = true;
  return result;
}

/// Closes the window however the run ends, since the threads wait for that.
class Closing {
 public:
  explicit Closing(Window& window) : window_(window) {}
  ~Closing() { window_.close(); }
  Closing(const Closing&) = delete;
  Closing& operator=(const Closing&) = delete;

 private:
  Window& window_;
};

/// One run. The thread that calls it verifies like the others and is the only one that uses the store, reads
/// ahead and stores results. So nobody waits for a lock while the store works.
class Run {
 public:
  Run(PairStore& store, const PairVerifier& verifier, const VerificationOptions& options,
      const std::function<void(const VerifiedPair&)>& each,
      const std::function<void(const VerificationProgress&)>& progress, const std::atomic<bool>* interrupt)
      : store_(store),
        verifier_(verifier),
        options_(options),
        each_(each),
        progress_(progress),
        interrupt_(interrupt),
        configuration_(verifier.configuration()),
        keypoints_(store, static_cast<std::size_t>(options.memory_gib * (1U << 30))) {}

  VerificationSummary run() {
    choosePairs();
    report();
    {
      Crew crew;
      const Closing closing(window_);
      std::vector<std::future<void>> others;
      for (int i = 1; i < options_.threads; ++i) others.push_back(crew.start([this] { follow(); }));
      lead();
      window_.close();
      for (std::future<void>& other : others) other.get();
    }
    summary_.seconds = watch_.seconds();
    return summary_;
  }

 private:
  /// Fills todo_ with the pairs that were asked for and are not stored yet.
  void choosePairs() {
    todo_ = options_.pairs.empty() ? store_.pairs() : options_.pairs;
    if (!std::is_sorted(todo_.begin(), todo_.end())) {
      throw std::invalid_argument("verification: the pairs must be in ascending order");
    }
    summary_.pairs = todo_.size();
    if (!options_.again) {
      const std::vector<ImagePairKey> before = store_.verifiedPairs(configuration_);
      std::vector<ImagePairKey> missing;
      std::set_difference(todo_.begin(), todo_.end(), before.begin(), before.end(),
                          std::back_inserter(missing));
      todo_ = std::move(missing);
    }
    summary_.skipped = summary_.pairs - todo_.size();
    end_ = todo_.size();
  }

  void lead() {
    Workspace workspace;
    while (true) {
      if (interrupt_ && *interrupt_ && !stopped_) {
        summary_.interrupted = true;
        stop();
      }
      readAhead();
      takeResults();
      if (taken_ >= end_) break;
      Task task;
      if (window_.takeNow(task)) {
        verify(task, workspace);
      } else {
        window_.await(taken_);
      }
    }
    commit();
  }

  /// What the other threads do.
  void follow() {
    Workspace workspace;
    Task task;
    try {
      while (window_.take(task)) verify(task, workspace);
    } catch (...) {
      window_.fail(std::current_exception());
    }
  }

  void verify(const Task& task, Workspace& workspace) {
    window_.finish(task.number, verifier_.verify(task.input, workspace));
  }

  /// Drops what no thread has begun.
  void stop() {
    stopped_ = true;
    end_ = window_.drop(read_);
  }

  /// Fills the window when half of it is used up, so that no thread runs out of pairs while this one is busy.
  void readAhead() {
    const std::size_t room = kWindow * static_cast<std::size_t>(options_.threads);
    if (stopped_ || window_.waiting() > room / 2) return;
    std::vector<Task> tasks;
    for (; read_ < end_ && read_ - taken_ < room; ++read_) {
      try {
        tasks.push_back({read_, input(todo_[read_])});
      } catch (const StoreError& error) {
        if (error.kind() != StoreError::Kind::kContent) throw;
        window_.finish(read_, faultyPair(todo_[read_], error.what()));
      }
    }
    if (!tasks.empty()) window_.add(std::move(tasks));
  }

  PairInput input(const ImagePairKey& pair) {
    PairInput input;
    input.pair = pair;
    input.first = &image(pair.first, pair);
    input.second = &image(pair.second, pair);
    input.matches = store_.matches(pair);
    input.first_keypoints = keypoints_.get(pair.first);
    input.second_keypoints = keypoints_.get(pair.second);
    return input;
  }

  const StoredImage& image(std::uint32_t id, const ImagePairKey& pair) const {
    const std::vector<StoredImage>& images = store_.images();
    const auto found =
        std::lower_bound(images.begin(), images.end(), id,
                         [](const StoredImage& image, std::uint32_t wanted) { return image.id < wanted; });
    if (found != images.end() && found->id == id) return *found;
    throw StoreError(StoreError::Kind::kContent, "the pair of the images " + std::to_string(pair.first) +
                                                     " and " + std::to_string(pair.second) +
                                                     " has matches, but there is no image " +
                                                     std::to_string(id) + "; remove its rows of matches");
  }

  /// Takes the results that are complete in the order of the pairs, and stores them when it is time.
  void takeResults() {
    bool more = true;
    while (more) {
      const std::size_t before = batch_.size();
      window_.collect(taken_, options_.commit_pairs, batch_);
      taken_ += batch_.size() - before;
      if (options_.strict && !stopped_) stopAtFault();
      more = batch_.size() >= options_.commit_pairs;
      if (more || since_commit_.seconds() >= options_.commit_seconds) commit();
    }
  }

  void stopAtFault() {
    const auto faulty =
        std::find_if(batch_.begin(), batch_.end(), [](const VerifiedPair& result) { return result.faulty; });
    if (faulty == batch_.end()) return;
    batch_.erase(faulty + 1, batch_.end());
    stop();
    end_ = taken_;
  }

  void commit() {
    since_commit_.restart();
    if (batch_.empty()) return;
    std::vector<VerifiedPair> usable;
    for (VerifiedPair& result : batch_) {
      count(result);
      if (!result.faulty && !options_.dry_run) usable.push_back(result);
    }
    if (!usable.empty()) store_.write(usable, configuration_);
    if (each_) std::for_each(batch_.begin(), batch_.end(), each_);
    done_ += batch_.size();
    batch_.clear();
    report();
  }

  void count(const VerifiedPair& result) {
    if (result.faulty) {
      ++summary_.faulty;
      return;
    }
    ++summary_.verified;
    ++summary_.configs.at(static_cast<std::size_t>(result.geometry.config));
    if (result.geometry.config != TwoViewConfig::kUndefined) ++summary_.accepted;
  }

  void report() const {
    if (progress_) progress_({todo_.size(), done_, summary_.accepted, watch_.seconds()});
  }

  PairStore& store_;
  const PairVerifier& verifier_;
  const VerificationOptions& options_;
  const std::function<void(const VerifiedPair&)>& each_;
  const std::function<void(const VerificationProgress&)>& progress_;
  const std::atomic<bool>* interrupt_;
  const std::string configuration_;
  KeypointCache keypoints_;
  std::vector<ImagePairKey> todo_;
  Window window_;
  std::size_t read_ = 0;   ///< pairs of todo_ that were read
  std::size_t taken_ = 0;  ///< of these, pairs whose result was taken from the window
  std::size_t end_ = 0;    ///< pairs of todo_ that this run verifies
  std::size_t done_ = 0;   ///< pairs of todo_ that are stored
  bool stopped_ = false;   ///< no further pair is read
  std::vector<VerifiedPair> batch_;
  Stopwatch watch_, since_commit_;
  VerificationSummary summary_;
};

void check(const VerificationOptions& options) {
  if (options.threads < 1) {
    throw std::invalid_argument("verification: threads must be at least 1, not " +
                                std::to_string(options.threads));
  }
  if (!(options.memory_gib >= 0 && options.memory_gib <= 1e6)) {
    throw std::invalid_argument("verification: memory_gib must be between 0 and 1000000, not " +
                                formatNumber(options.memory_gib));
  }
  if (options.commit_pairs < 1) {
    throw std::invalid_argument("verification: commit_pairs must be at least 1, not 0");
  }
  if (!(options.commit_seconds >= 0)) {
    throw std::invalid_argument("verification: commit_seconds must be at least 0, not " +
                                formatNumber(options.commit_seconds));
  }
}

}  // namespace

VerificationSummary verifyPairs(PairStore& store, const PairVerifier& verifier,
                                const VerificationOptions& options,
                                const std::function<void(const VerifiedPair&)>& each,
                                const std::function<void(const VerificationProgress&)>& progress,
                                const std::atomic<bool>* interrupt) {
  check(options);
  return Run(store, verifier, options, each, progress, interrupt).run();
}

}  // namespace corrsel::core
