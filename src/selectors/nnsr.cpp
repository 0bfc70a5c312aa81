#include "corrsel/selectors/nnsr.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/text.h"
#include "selectors/parts/otsu.h"

namespace corrsel::core {
namespace {

constexpr int kOtsuBins = 256;  // over [0, 1]

}  // namespace

void NnsrOptions::visit(OptionVisitor& visitor) const {
  visitor.number({"fallback", 0, 1, "-", "Ratio threshold where Otsu's method is undefined"},
                 &NnsrOptions::fallback);
  visitor.number({"min_threshold", 0, 1, "-", "Otsu's threshold is raised to at least this ratio"},
                 &NnsrOptions::min_threshold);
  visitor.number({"max_threshold", 0, 1, "-", "Otsu's threshold is lowered to at most this ratio"},
                 &NnsrOptions::max_threshold);
  visitConfidence(visitor);
}

void NnsrOptions::check() const {
  OptionSet::check();
  if (min_threshold > max_threshold) {
    throw std::invalid_argument("option min_threshold = " + formatNumber(min_threshold) +
                                " is larger than max_threshold = " + formatNumber(max_threshold));
  }
}

Presets NnsrSelector::presets() const {
  return {{"lowe", {{"min_threshold", "0.8"}, {"max_threshold", "0.8"}}}};
}

std::string NnsrSelector::missingInput(const Correspondences& matches) const {
  if (matches.empty() || (!matches.distance.empty() && !matches.second_distance.empty())) return "";
  return std::string("nnsr needs the column ") + (matches.distance.empty() ? "distance" : "second_distance");
}

void NnsrSelector::run(const Correspondences& matches, Workspace&, Selection& result) const {
  const std::size_t n = matches.size();
  result.score.assign(n, 0.0F);
  std::vector<double> ratios(n, std::numeric_limits<double>::quiet_NaN()), defined(n);
  std::size_t n_defined = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double first = matches.distance[i], second = matches.second_distance[i];
    if (!(second > 0 && std::isfinite(second)) || !(first >= 0)) continue;
    const double ratio = first / second;
    // A first neighbour farther than the second is no nearest neighbour.
    if (!(ratio <= 1)) continue;
    ratios[i] = ratio;
    defined[n_defined++] = ratio;
    result.score[i] = static_cast<float>(1.0 - ratio);
  }
  defined.resize(n_defined);
  const std::optional<double> otsu = otsuThreshold(defined, 0.0, 1.0, kOtsuBins);
  double threshold = options_.fallback;
  if (otsu) {
    threshold = std::clamp(*otsu, options_.min_threshold, options_.max_threshold);
    result.message = "the threshold is " + formatNumber(threshold);
  } else if (n > 0) {
    result.message = "Otsu's method is undefined for these ratios, so the threshold is fallback = " +
                     formatNumber(threshold);
  }
  for (std::size_t i = 0; i < n; ++i) result.mask[i] = ratios[i] <= threshold ? 1 : 0;
  result.iterations = 1;
}

}  // namespace corrsel::core
