#include <future>
#include <stdexcept>

#include "corrsel/features/extractor.h"
#include "corrsel/features/orb.h"
#include "corrsel/features/sift.h"
#include "corrsel/text.h"

namespace corrsel::core {
namespace {

struct Entry {
  std::string name;
  std::unique_ptr<FeatureExtractor> (*create)(const OptionMap& options, const std::string& context);
};

template <class E, class O>
Entry entry(const std::string& name) {
  return {name, [](const OptionMap& options, const std::string& context) {
            O values;
            setOptions(values, options, context);
            try {
              return std::unique_ptr<FeatureExtractor>(std::make_unique<E>(values));
            } catch (const std::invalid_argument& error) {
              throw std::invalid_argument(context + ": " + error.what());
            }
          }};
}

/// The one place where a combination is announced.
const std::vector<Entry>& entries() {
  static const std::vector<Entry> table = {
      entry<SiftExtractor, SiftOptions>("sift+sift"),
      entry<OrbExtractor, OrbOptions>("orb+orb"),
  };
  return table;
}

}  // namespace

std::unique_ptr<FeatureExtractor> createExtractor(const std::string& name, const OptionMap& options) {
  for (const Entry& candidate : entries()) {
    if (candidate.name == name) return candidate.create(options, name.substr(0, name.find('+')));
  }
  throw std::invalid_argument("unknown features '" + name + "'; valid: " + joinList(extractorNames()));
}

std::vector<std::string> extractorNames() {
  std::vector<std::string> names;
  for (const Entry& candidate : entries()) names.push_back(candidate.name);
  return names;
}

std::pair<Features, Features> extractPair(const FeatureExtractor& extractor, const cv::Mat& left,
                                          const cv::Mat& right, int threads) {
  if (threads <= 1) return {extractor.extract(left), extractor.extract(right)};
  auto other = std::async(std::launch::async, [&extractor, &right] { return extractor.extract(right); });
  Features first = extractor.extract(left);
  return {std::move(first), other.get()};
}

}  // namespace corrsel::core
