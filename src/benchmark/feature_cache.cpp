#include "benchmark/feature_cache.h"

#include <cstring>

namespace corrsel::core {
namespace {

std::size_t rowBytes(const cv::Mat& image) { return static_cast<std::size_t>(image.cols) * image.elemSize(); }

bool samePixels(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  for (int y = 0; y < a.rows; ++y) {
    if (std::memcmp(a.ptr(y), b.ptr(y), rowBytes(a)) != 0) return false;
  }
  return true;
}

std::size_t bytesOf(const cv::Mat& image, const Features& features) {
  return image.total() * image.elemSize() + features.keypoints.capacity() * sizeof(cv::KeyPoint) +
         features.frames.capacity() * sizeof(AffineFrame) +
         features.descriptors.total() * features.descriptors.elemSize();
}

}  // namespace

Checksum checksumOf(const cv::Mat& image) {
  Checksum checksum;
  checksum.addUnit(static_cast<std::uint64_t>(image.rows));
  checksum.addUnit(static_cast<std::uint64_t>(image.cols));
  for (int y = 0; y < image.rows; ++y) {
    const std::uint8_t* row = image.ptr(y);
    std::uint64_t word = 0;
    for (std::size_t i = 0; i + sizeof word <= rowBytes(image); i += sizeof word) {
      std::memcpy(&word, row + i, sizeof word);
      checksum.addUnit(word);
    }
  }
  return checksum;
}

std::shared_ptr<const Features> FeatureCache::find(const FeatureExtractor& extractor, const cv::Mat& image,
                                                   std::uint64_t hash) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    if (entry->extractor != &extractor || entry->hash != hash || !samePixels(entry->image, image)) continue;
    entries_.splice(entries_.begin(), entries_, entry);
    ++hits_;
    return entry->features;
  }
  ++misses_;
  return nullptr;
}

void FeatureCache::add(const FeatureExtractor& extractor, const cv::Mat& image, std::uint64_t hash,
                       const std::shared_ptr<const Features>& features) {
  const std::size_t bytes = bytesOf(image, *features);
  if (bytes > max_bytes_) return;
  Entry entry{&extractor, hash, image.clone(), features, bytes};
  const std::lock_guard<std::mutex> lock(mutex_);
  while (bytes_ + bytes > max_bytes_) {
    bytes_ -= entries_.back().bytes;
    entries_.pop_back();
  }
  entries_.push_front(std::move(entry));
  bytes_ += bytes;
}

std::pair<std::shared_ptr<const Features>, std::shared_ptr<const Features>> FeatureCache::extractPair(
    const FeatureExtractor& extractor, const cv::Mat& left, const cv::Mat& right, int threads) {
  const std::uint64_t left_hash = checksumOf(left).value(), right_hash = checksumOf(right).value();
  auto first = find(extractor, left, left_hash), second = find(extractor, right, right_hash);
  const bool new_left = first == nullptr, new_right = second == nullptr;
  if (new_left && new_right) {
    auto [a, b] = core::extractPair(extractor, left, right, threads);
    first = std::make_shared<const Features>(std::move(a));
    second = std::make_shared<const Features>(std::move(b));
  } else if (new_left) {
    first = std::make_shared<const Features>(extractor.extract(left, threads));
  } else if (new_right) {
    second = std::make_shared<const Features>(extractor.extract(right, threads));
  }
  if (new_right) add(extractor, right, right_hash, second);
  if (new_left) add(extractor, left, left_hash, first);
  return {first, second};
}

std::size_t FeatureCache::bytes() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return bytes_;
}

std::size_t FeatureCache::hits() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return hits_;
}

std::size_t FeatureCache::misses() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return misses_;
}

}  // namespace corrsel::core
