#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <map>

#include "core/memory_store.h"
#include "corrsel/database/verification.h"
#include "database/keypoint_cache.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::errorOf;
using testing::MemoryStore;
using testing::mentions;
using testing::twoPlaces;

const PairVerifier& verifier() {
  static const PairVerifier instance = [] {
    PairVerifierOptions options;
    options.selector = "auto:f";  // the fastest one that finds out what the matches show
    return PairVerifier(options);
  }();
  return instance;
}

VerificationOptions onThreads(int threads) {
  VerificationOptions options;
  options.threads = threads;
  return options;
}

void expectSameBits(double a, double b) {
  EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << a << " is not " << b;
}

void expectSame(const VerifiedPair& a, const VerifiedPair& b) {
  EXPECT_EQ(a.pair, b.pair);
  EXPECT_EQ(a.geometry.config, b.geometry.config);
  EXPECT_EQ(a.geometry.inliers, b.geometry.inliers);
  EXPECT_EQ(a.geometry.fundamental, b.geometry.fundamental);
  EXPECT_EQ(a.geometry.homography, b.geometry.homography);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.message, b.message);
  expectSameBits(a.confidence, b.confidence);
  expectSameBits(a.ambiguity, b.ambiguity);
}

void expectSameResults(const MemoryStore& a, const MemoryStore& b) {
  ASSERT_EQ(a.results.size(), b.results.size());
  for (const auto& [pair, result] : a.results) expectSame(result, b.results.at(pair));
}

/// What one thread finds.
const MemoryStore& reference() {
  static const MemoryStore store = [] {
    MemoryStore verified = twoPlaces();
    verifyPairs(verified, verifier(), {});
    return verified;
  }();
  return store;
}

TEST(Verification, PairsOfOnePlaceAreAccepted) {
  ASSERT_EQ(reference().results.size(), 45u);
  for (const auto& [pair, result] : reference().results) {
    const bool same_place = (pair.first + pair.second) % 2 == 0;
    EXPECT_EQ(result.geometry.config != TwoViewConfig::kUndefined, same_place)
        << pair.first << " " << pair.second << " " << result.message;
    EXPECT_EQ(result.putative, same_place ? 90u : 30u);
  }
}

TEST(Verification, ResultsAreTheSameForAnyNumberOfThreads) {
  for (int threads : {2, 4, 9}) {
    MemoryStore store = twoPlaces();
    const VerificationSummary summary = verifyPairs(store, verifier(), onThreads(threads));
    expectSameResults(store, reference());
    EXPECT_TRUE(std::is_sorted(store.order.begin(), store.order.end()));
    EXPECT_EQ(summary.pairs, 45u);
    EXPECT_EQ(summary.verified, 45u);
    EXPECT_EQ(summary.accepted, 20u);
    EXPECT_EQ(summary.configs[0], 25u);
    EXPECT_EQ(std::accumulate(summary.configs.begin(), summary.configs.end(), std::size_t{0}), 45u);
  }
}

TEST(Verification, OnlyAWindowOfPairsIsReadAhead) {
  MemoryStore store = twoPlaces(10, 30);
  VerificationOptions options = onThreads(2);
  options.commit_pairs = 7;
  verifyPairs(store, verifier(), options);
  EXPECT_EQ(store.match_reads, 190u);
  EXPECT_LE(store.most_unwritten, 2 * 64u + 7);
  EXPECT_LE(*std::max_element(store.transactions.begin(), store.transactions.end()), 7u);
  EXPECT_GE(store.transactions.size(), 28u);
}

TEST(Verification, TransactionsEndAfterATime) {
  MemoryStore store = twoPlaces();
  VerificationOptions options;
  options.commit_seconds = 0;
  verifyPairs(store, verifier(), options);
  EXPECT_GT(store.transactions.size(), 10u);
}

TEST(KeypointCache, KeepsWhatWasUsedLastWithinItsBound) {
  const MemoryStore store = twoPlaces(3, 1000);
  KeypointCache large(store, SIZE_MAX);
  const std::size_t size = (large.get(1), large.bytes());
  ASSERT_GE(size, 8000u);
  KeypointCache cache(store, 3 * size);
  const std::size_t before = store.keypoint_reads;
  for (std::uint32_t image : {1, 2, 3, 1, 4, 1, 3}) {  // 4 drops 2
    EXPECT_EQ(cache.get(image)->positions, store.stored_keypoints.at(image).positions);
    EXPECT_LE(cache.bytes(), 3 * size);
  }
  EXPECT_EQ(store.keypoint_reads - before, 4u);
  cache.get(2);
  EXPECT_EQ(store.keypoint_reads - before, 5u);
}

TEST(KeypointCache, HoldsTheLastImageWhateverItsSize) {
  const MemoryStore store = twoPlaces(2, 1000);
  KeypointCache cache(store, 0);
  const auto first = cache.get(1);
  cache.get(2);
  cache.get(2);
  EXPECT_EQ(store.keypoint_reads, 2u);
  EXPECT_EQ(first->positions.size(), 1000u);
}

TEST(Verification, KeypointsAreKeptWithinTheBound) {
  MemoryStore large = twoPlaces(), small = twoPlaces();
  VerificationOptions options;
  verifyPairs(large, verifier(), options);
  EXPECT_EQ(large.keypoint_reads, 10u);
  options.memory_gib = 0;
  verifyPairs(small, verifier(), options);
  EXPECT_GT(small.keypoint_reads, 45u);
  expectSameResults(large, small);
}

TEST(Verification, PairsThatAreStoredAreSkipped) {
  MemoryStore store = reference();
  store.results.erase({2, 4});
  store.configurations.erase({2, 4});
  VerificationOptions options = onThreads(2);
  VerificationSummary summary = verifyPairs(store, verifier(), options);
  EXPECT_EQ(summary.skipped, 44u);
  EXPECT_EQ(summary.verified, 1u);
  EXPECT_EQ(summary.pairs, 45u);
  expectSameResults(store, reference());
  EXPECT_EQ(verifyPairs(store, verifier(), options).skipped, 45u);
  options.again = true;
  summary = verifyPairs(store, verifier(), options);
  EXPECT_EQ(summary.skipped, 0u);
  EXPECT_EQ(summary.verified, 45u);
}

TEST(Verification, PairsOfOtherSettingsAreVerified) {
  MemoryStore store = reference();
  PairVerifierOptions other;
  other.selector = "auto:f";
  other.min_matches = 20;
  EXPECT_EQ(verifyPairs(store, PairVerifier(other), {}).verified, 45u);
}

TEST(Verification, TheGivenPairsOnly) {
  MemoryStore store = twoPlaces();
  VerificationOptions options = onThreads(2);
  options.pairs = {{1, 3}, {2, 3}, {2, 4}};
  const VerificationSummary summary = verifyPairs(store, verifier(), options);
  EXPECT_EQ(summary.pairs, 3u);
  EXPECT_EQ(summary.accepted, 2u);
  EXPECT_EQ(store.order, options.pairs);
  options.pairs = {{2, 4}, {1, 3}};
  EXPECT_TRUE(mentions(errorOf([&] { verifyPairs(store, verifier(), options); }), {"ascending"}));
}

TEST(Verification, AnInterruptedRunStoresWhatIsCompleteAndContinues) {
  MemoryStore whole = twoPlaces(10, 30);
  verifyPairs(whole, verifier(), {});
  for (int threads : {1, 2}) {
    MemoryStore store = twoPlaces(10, 30);  // 190 pairs; two threads read fewer than 140 ahead
    VerificationOptions options = onThreads(threads);
    options.commit_pairs = 4;
    std::atomic<bool> interrupt{false};
    std::size_t seen = 0;
    const auto each = [&](const VerifiedPair&) { interrupt = ++seen >= 8; };
    const VerificationSummary summary = verifyPairs(store, verifier(), options, each, {}, &interrupt);
    EXPECT_TRUE(summary.interrupted);
    EXPECT_GE(store.results.size(), 8u);
    EXPECT_LT(store.results.size(), 190u);
    EXPECT_EQ(store.results.size(), summary.verified);
    const std::vector<ImagePairKey> pairs = store.pairs();
    EXPECT_TRUE(std::equal(store.order.begin(), store.order.end(), pairs.begin()));
    EXPECT_EQ(verifyPairs(store, verifier(), options).skipped, summary.verified);
    expectSameResults(store, whole);
  }
}

TEST(Verification, AnInterruptBeforeTheStartVerifiesNothing) {
  MemoryStore store = twoPlaces();
  const std::atomic<bool> interrupt{true};
  const VerificationSummary summary = verifyPairs(store, verifier(), onThreads(2), {}, {}, &interrupt);
  EXPECT_TRUE(summary.interrupted);
  EXPECT_EQ(summary.verified, 0u);
  EXPECT_TRUE(store.results.empty());
}

TEST(Verification, FaultyPairsAreNamedAndNotStored) {
  MemoryStore store = twoPlaces();
  store.broken_images = {10};
  store.broken_pairs = {{1, 3}};
  store.stored_matches[{1, 99}].rows.resize(20);
  store.stored_matches[{2, 4}].rows[5] = {5, 150};  // beyond the keypoints
  VerificationOptions options = onThreads(2);
  options.pairs = store.pairs();
  options.pairs.push_back({11, 12});
  std::map<ImagePairKey, std::string> faults;
  std::vector<ImagePairKey> order;
  const VerificationSummary summary =
      verifyPairs(store, verifier(), options, [&](const VerifiedPair& result) {
        order.push_back(result.pair);
        if (result.faulty) faults[result.pair] = result.message;
      });
  EXPECT_EQ(order, options.pairs);
  EXPECT_EQ(summary.faulty, 13u);
  EXPECT_EQ(summary.verified, 34u);
  ASSERT_EQ(faults.size(), 13u);
  EXPECT_EQ((faults[{1, 3}]), "matches of the pair");
  EXPECT_EQ((faults[{3, 10}]), "keypoints of image 10");
  EXPECT_TRUE(mentions(faults[{1, 99}], {"1 and 99", "no image 99", "remove"}));
  EXPECT_TRUE(mentions(faults[{2, 4}], {"150"}));
  EXPECT_TRUE(mentions(faults[{11, 12}], {"no image 11"}));
  EXPECT_EQ(store.results.size(), 34u);
  for (const auto& [pair, message] : faults) EXPECT_EQ(store.results.count(pair), 0u);
  for (const auto& [pair, result] : store.results) expectSame(result, reference().results.at(pair));
}

TEST(Verification, PairsWithoutMatchesAreFaulty) {
  MemoryStore store = twoPlaces();
  store.stored_matches.erase({1, 2});
  VerificationOptions options;
  options.pairs = {{1, 2}};
  std::string message;
  const VerificationSummary summary =
      verifyPairs(store, verifier(), options, [&](const VerifiedPair& result) { message = result.message; });
  EXPECT_EQ(summary.faulty, 1u);
  EXPECT_EQ(message, "no matches of the pair");
}

TEST(Verification, AStrictRunStopsAtTheFirstFault) {
  for (int threads : {1, 4}) {
    MemoryStore store = twoPlaces();
    store.broken_pairs = {{2, 5}, {3, 4}};
    VerificationOptions options = onThreads(threads);
    options.strict = true;
    std::vector<ImagePairKey> order;
    const VerificationSummary summary = verifyPairs(
        store, verifier(), options, [&](const VerifiedPair& result) { order.push_back(result.pair); });
    EXPECT_EQ(summary.faulty, 1u);
    EXPECT_EQ(summary.verified, 11u);  // of image 1, and 2 with 3 and 4
    EXPECT_EQ(store.results.size(), 11u);
    EXPECT_EQ(order.back(), (ImagePairKey{2, 5}));
    EXPECT_FALSE(summary.interrupted);
  }
}

TEST(Verification, AFullDiskEndsTheRunAndKeepsWhatWasCommitted) {
  for (int threads : {1, 4}) {
    MemoryStore store = twoPlaces();
    store.full_after = 2;
    VerificationOptions options = onThreads(threads);
    options.commit_pairs = 5;
    options.commit_seconds = std::numeric_limits<double>::infinity();
    const auto run = [&] { verifyPairs(store, verifier(), options); };
    EXPECT_EQ(errorOf<StoreError>(run), "the disk is full");
    EXPECT_EQ(store.results.size(), 10u);
    store.full_after = SIZE_MAX;
    EXPECT_EQ(verifyPairs(store, verifier(), options).skipped, 10u);
    expectSameResults(store, reference());
  }
}

TEST(Verification, ADryRunWritesNothing) {
  MemoryStore store = twoPlaces();
  VerificationOptions options = onThreads(2);
  options.dry_run = true;
  std::size_t seen = 0;
  const VerificationSummary summary =
      verifyPairs(store, verifier(), options, [&](const VerifiedPair& result) {
        expectSame(result, reference().results.at(result.pair));
        ++seen;
      });
  EXPECT_EQ(seen, 45u);
  EXPECT_EQ(summary.accepted, 20u);
  EXPECT_TRUE(store.transactions.empty());
}

TEST(Verification, ProgressBeginsAtNoneAndEndsAtAll) {
  MemoryStore store = twoPlaces();
  VerificationOptions options = onThreads(2);
  options.commit_pairs = 10;
  std::vector<VerificationProgress> states;
  verifyPairs(store, verifier(), options, {}, [&](const VerificationProgress& p) { states.push_back(p); });
  ASSERT_GE(states.size(), 6u);
  EXPECT_EQ(states.front().done, 0u);
  EXPECT_EQ(states.back().done, 45u);
  EXPECT_EQ(states.back().accepted, 20u);
  for (const VerificationProgress& state : states) EXPECT_EQ(state.total, 45u);
}

TEST(Verification, AnEmptyStoreIsNoFault) {
  MemoryStore store;
  const VerificationSummary summary = verifyPairs(store, verifier(), onThreads(2));
  EXPECT_EQ(summary.pairs, 0u);
  EXPECT_FALSE(summary.interrupted);
}

TEST(Verification, OptionsOutOfRangeAreNamed) {
  MemoryStore store = twoPlaces();
  VerificationOptions options = onThreads(0);
  const auto run = [&] { verifyPairs(store, verifier(), options); };
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>(run), {"threads", "at least 1", "0"}));
  options = {};
  options.memory_gib = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>(run), {"memory_gib"}));
  options = {};
  options.commit_pairs = 0;
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>(run), {"commit_pairs", "at least 1"}));
  for (const double seconds : {-1.0, std::numeric_limits<double>::quiet_NaN()}) {
    options = {};
    options.commit_seconds = seconds;
    EXPECT_TRUE(mentions(errorOf<std::invalid_argument>(run), {"commit_seconds", "at least 0"}));
  }
}

}  // namespace
}  // namespace corrsel::core
