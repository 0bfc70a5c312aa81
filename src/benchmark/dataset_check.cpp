#include "benchmark/dataset_check.h"

#include <cstddef>
#include <memory>

#include "benchmark/feature_cache.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"

namespace corrsel::core {
namespace {

constexpr char kFeatures[] = "orb+orb";
// As many as are needed to find 25 correct matches of a hard pair, and few enough for some seconds in total.
const AlgorithmOptions kOptions = {{"orb", {{"max_features", "1000"}, {"max_megapixels", "1"}}}};
constexpr std::size_t kCacheBytes = std::size_t{64} << 20U;

}  // namespace

std::vector<TruthWarning> doubtfulTruths(const DatasetReader& reader, int threads) {
  const std::unique_ptr<FeatureExtractor> extractor = createExtractor(kFeatures, kOptions);
  FeatureCache cache(kCacheBytes);
  MatchOptions options;
  options.mutual = true;
  std::vector<TruthCheck> checks;
  for (std::size_t i = 0; i < reader.size(); ++i) {
    ImagePair pair;
    try {
      pair = reader.read(i);
    } catch (const DatasetError&) {  // describe() reports it
      continue;
    }
    if (pair.truth.kind == TruthKind::kNone || pair.truth.kind == TruthKind::kLabels) continue;
    const bool given = pair.given.has_value();
    if (!given) {
      const auto [left, right] = cache.extractPair(*extractor, pair.left, pair.right, threads);
      pair.given = matchFeatures(*left, *right, options, threads);
    }
    for (TruthCheck check : checkTruth(pair.truth, pair.other_readings, *pair.given)) {
      check.id = pair.id;
      check.features = given ? kGivenFeatures : kFeatures;
      checks.push_back(check);
    }
  }
  return truthWarnings(checks);
}

}  // namespace corrsel::core
