#include "corrsel/database/pair_matching.h"

#include <algorithm>
#include <fstream>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <sstream>
#include <unordered_map>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "matching/nearest.h"

namespace corrsel::core {
namespace {

// A transaction is written after so many pairs or seconds.
constexpr std::size_t kCommitPairs = 500;
constexpr double kCommitSeconds = 2;
// Memory that the size of blocks is computed from, bytes an image: 10000 descriptors of 128 bytes.
constexpr double kBytesOfImage = 1.28e6;

NeighbourSearch searchOfBytes() {
  NeighbourSearch search;
  search.bytes = NeighbourSearch::Bytes::kNumbers;
  return search;
}

/// Matches that are nearest to each other and pass the test of ratios from both sides.
std::vector<KeypointPair> matchByRatio(const cv::Mat& first, const cv::Mat& second, double ratio) {
  NeighbourSearch search = searchOfBytes();
  search.ratio = ratio;
  const Neighbours forth = findNeighbours(first, second, search);
  // Few rows pass the test, so the way back is short.
  std::vector<std::uint32_t> rows;
  for (const std::uint32_t row : forth.train) {
    if (row != Neighbours::kNone) rows.push_back(row);
  }
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  cv::Mat candidates(static_cast<int>(rows.size()), second.cols, second.type());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    second.row(static_cast<int>(rows[i])).copyTo(candidates.row(static_cast<int>(i)));
  }
  const Neighbours back = findNeighbours(candidates, first, search);
  std::vector<KeypointPair> matches;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::uint32_t row = back.train[i];
    if (row != Neighbours::kNone && forth.train[row] == rows[i]) matches.push_back({row, rows[i]});
  }
  std::sort(matches.begin(), matches.end());
  return matches;
}

/// Descriptors of the images that were used last, as many as fit into the memory.
class DescriptorCache {
 public:
  DescriptorCache(const ColmapStore& store, double memory_gib)
      : store_(store), capacity_(static_cast<std::size_t>(memory_gib * (1 << 30))) {}

  cv::Mat get(std::uint32_t image) {
    const auto found = places_.find(image);
    if (found != places_.end()) {
      entries_.splice(entries_.begin(), entries_, found->second);
      return found->second->second;
    }
    const cv::Mat descriptors = store_.descriptors(image);
    entries_.emplace_front(image, descriptors);
    places_[image] = entries_.begin();
    size_ += descriptors.total();
    while (size_ > capacity_ && entries_.size() > 2) {
      size_ -= entries_.back().second.total();
      places_.erase(entries_.back().first);
      entries_.pop_back();
    }
    return descriptors;
  }

 private:
  using Entry = std::pair<std::uint32_t, cv::Mat>;

  const ColmapStore& store_;
  const std::size_t capacity_;
  std::size_t size_ = 0;
  std::list<Entry> entries_;  ///< the one used last comes first
  std::unordered_map<std::uint32_t, std::list<Entry>::iterator> places_;
};

/// Pairs in an order in which two blocks of images at a time are used.
void sortByBlocks(std::vector<ImagePairKey>& pairs, double memory_gib) {
  const auto block = static_cast<std::uint32_t>(std::max(1.0, memory_gib * (1 << 30) / kBytesOfImage / 2));
  std::stable_sort(pairs.begin(), pairs.end(), [block](const ImagePairKey& a, const ImagePairKey& b) {
    const ImagePairKey a_block{a.first / block, a.second / block}, b_block{b.first / block, b.second / block};
    return a_block == b_block ? a < b : a_block < b_block;
  });
}

/// Gives pairs to threads, and stores what they found. One thread at a time is in it.
class MatchingQueue {
 public:
  using ProgressFunction = std::function<void(std::size_t, std::size_t)>;

  struct Work {
    ImagePairKey pair;
    cv::Mat first, second;
  };

  MatchingQueue(ColmapStore& store, const std::vector<ImagePairKey>& pairs, double memory_gib,
                const ProgressFunction& progress, const std::atomic<bool>* interrupt,
                PairMatchingSummary& summary)
      : store_(store),
        pairs_(pairs),
        cache_(store, memory_gib),
        progress_(progress),
        interrupt_(interrupt),
        summary_(summary) {}

  /// @return whether there was another pair
  bool take(Work& work) {
    const std::lock_guard<std::mutex> lock(mutex_);
    while (next_ < pairs_.size()) {
      if (failed_) return false;
      if (interrupt_ != nullptr && *interrupt_) {
        summary_.interrupted = true;
        return false;
      }
      work.pair = pairs_[next_++];
      if (read(work.pair.first, work.first) && read(work.pair.second, work.second)) return true;
    }
    return false;
  }

  void put(const ImagePairKey& pair, std::vector<KeypointPair> rows) {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++summary_.matched;
    summary_.matches += rows.size();
    complete_.emplace_back(pair, StoredMatches{std::move(rows), {}});
    if (complete_.size() >= kCommitPairs || since_commit_.seconds() > kCommitSeconds) commit();
  }

  /// Stores the rest.
  void finish() {
    const std::lock_guard<std::mutex> lock(mutex_);
    commit();
  }

 private:
  /// @return whether the descriptors of an image can be used
  bool read(std::uint32_t image, cv::Mat& descriptors) {
    if (faulty_.count(image) != 0) return false;
    try {
      descriptors = cache_.get(image);
      return true;
    } catch (const StoreError& error) {
      if (error.kind() != StoreError::Kind::kContent) {
        failed_ = true;
        throw;
      }
      faulty_.insert(image);
      summary_.faulty.emplace_back(error.what());
      return false;
    }
  }

  void commit() {
    try {
      store_.writeMatches(complete_);
    } catch (...) {
      failed_ = true;
      throw;
    }
    complete_.clear();
    since_commit_.restart();
    if (progress_) progress_(summary_.matched, pairs_.size());
  }

  ColmapStore& store_;
  const std::vector<ImagePairKey>& pairs_;
  DescriptorCache cache_;
  const ProgressFunction& progress_;
  const std::atomic<bool>* const interrupt_;
  PairMatchingSummary& summary_;
  std::mutex mutex_;
  std::size_t next_ = 0;
  bool failed_ = false;
  std::set<std::uint32_t> faulty_;
  std::vector<std::pair<ImagePairKey, StoredMatches>> complete_;
  Stopwatch since_commit_;
};

}  // namespace

void PairMatchingOptions::visit(OptionVisitor& visitor) const {
  visitor.number({"ratio", 0, 1, "-",
                  "Matching: largest ratio of the distances of the two nearest descriptors; 1 = no test"},
                 &PairMatchingOptions::ratio);
  visitor.number({"memory_gib", 0, 1e6, "GiB", "Matching: memory for descriptors"},
                 &PairMatchingOptions::memory_gib);
  visitor.flag("again", "Matching: match pairs that have matches already", &PairMatchingOptions::again);
}

std::vector<KeypointPair> matchDescriptors(const cv::Mat& first, const cv::Mat& second, double ratio) {
  if (first.empty() || second.empty()) return {};
  if (ratio < 1) return matchByRatio(first, second, ratio);
  NeighbourSearch search = searchOfBytes();
  search.nearest_query = true;
  const Neighbours nearest = findNeighbours(first, second, search);
  std::vector<KeypointPair> matches;
  for (std::uint32_t i = 0; i < nearest.train.size(); ++i) {
    const std::uint32_t row = nearest.train[i];
    if (row != Neighbours::kNone && nearest.query[row] == i) matches.push_back({i, row});
  }
  return matches;
}

std::vector<ImagePairKey> exhaustivePairs(const std::vector<StoredImage>& images) {
  return sequentialPairs(images, images.size());
}

std::vector<ImagePairKey> sequentialPairs(const std::vector<StoredImage>& images, std::size_t overlap) {
  std::vector<const StoredImage*> sorted;
  for (const StoredImage& image : images) sorted.push_back(&image);
  std::sort(sorted.begin(), sorted.end(),
            [](const StoredImage* a, const StoredImage* b) { return a->name < b->name; });
  std::vector<ImagePairKey> pairs;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    for (std::size_t k = i + 1; k < sorted.size() && k - i <= overlap; ++k) {
      pairs.push_back({std::min(sorted[i]->id, sorted[k]->id), std::max(sorted[i]->id, sorted[k]->id)});
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::vector<ImagePairKey> listedPairs(const std::filesystem::path& file,
                                      const std::vector<StoredImage>& images) {
  std::map<std::string, std::uint32_t> numbers;
  for (const StoredImage& image : images) numbers[image.name] = image.id;
  std::ifstream stream(file);
  if (!stream) {
    throw StoreError(StoreError::Kind::kStorage, file.string() + ": the list of pairs cannot be read");
  }
  std::set<ImagePairKey> pairs;
  std::string line;
  for (std::size_t number = 1; std::getline(stream, line); ++number) {
    std::istringstream words(line);
    std::string names[2], rest;
    if (!(words >> names[0]) || names[0][0] == '#') continue;
    const auto fail = [&](const std::string& fault) {
      throw StoreError(StoreError::Kind::kContent,
                       file.string() + ", line " + std::to_string(number) + ": " + fault);
    };
    if (!(words >> names[1]) || words >> rest) fail("'" + line + "' is not two names of images");
    for (const std::string& name : names) {
      if (numbers.count(name) == 0) fail("there is no image '" + name + "' in the database");
    }
    const std::uint32_t a = numbers[names[0]], b = numbers[names[1]];
    if (a != b) pairs.insert({std::min(a, b), std::max(a, b)});
  }
  return {pairs.begin(), pairs.end()};
}

PairMatchingSummary matchPairs(ColmapStore& store, const std::vector<ImagePairKey>& pairs,
                               const PairMatchingOptions& options, int threads,
                               const std::function<void(std::size_t, std::size_t)>& progress,
                               const std::atomic<bool>* interrupt) {
  options.check();
  PairMatchingSummary summary;
  summary.pairs = pairs.size();
  std::vector<ImagePairKey> missing = pairs;
  if (!options.again) {
    const std::vector<ImagePairKey> present = store.matchedPairs();
    missing.clear();
    std::set_difference(pairs.begin(), pairs.end(), present.begin(), present.end(),
                        std::back_inserter(missing));
  }
  summary.skipped = pairs.size() - missing.size();
  sortByBlocks(missing, options.memory_gib);
  MatchingQueue queue(store, missing, options.memory_gib, progress, interrupt, summary);
  const auto workers = std::min(static_cast<std::size_t>(std::max(threads, 1)), missing.size());
  onThreads(workers, [&] {
    for (MatchingQueue::Work work; queue.take(work);) {
      queue.put(work.pair, matchDescriptors(work.first, work.second, options.ratio));
    }
  });
  queue.finish();
  return summary;
}

}  // namespace corrsel::core
