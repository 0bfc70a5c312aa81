#include "hard_models.h"

#include <functional>
#include <memory>
#include <opencv2/calib3d.hpp>

#include "corrsel/evaluation/statistics.h"
#include "corrsel/selectors/factory.h"

namespace corrsel::performance {
namespace {

constexpr std::size_t kMatches = 2000;
constexpr int kSeeds = 100, kMaxSamples = 100000;
constexpr double kThreshold = 3, kConfidence = 0.99, kFoundRecall = 0.9;

struct Search {
  std::string name;
  std::function<cv::Matx33d(const Scene&)> model;
  int every = 1;
  int seeds = 0, found = 0;
  std::vector<double> milliseconds = {};

  void run(const Scene& scene) {
    const ProcessorTime watch;
    const cv::Matx33d found_model = model(scene);
    milliseconds.push_back(1e3 * watch.seconds());
    ++seeds;
    found += modelRecall(scene, found_model, kThreshold) >= kFoundRecall;
  }
  double median() const { return core::quantile(milliseconds, 0.5); }
  double rate() const { return 100.0 * found / seeds; }
};

Search ours(const std::string& spec) {
  const std::shared_ptr<const core::Selector> made = core::createSelector(
      spec, {{"threshold", "3"}, {"max_iterations", std::to_string(kMaxSamples)}, {"confidence", "0.99"}},
      {{"threads", "1"}});
  return {spec, [made](const Scene& scene) { return made->select(scene.matches).model; }};
}

cv::Matx33d openCvModel(const Scene& scene) {
  cv::Mat mask;
  const cv::Mat model =
      cv::findHomography(scene.left, scene.right, cv::RANSAC, kThreshold, mask, kMaxSamples, kConfidence);
  return model.empty() ? cv::Matx33d::zeros() : cv::Matx33d(model);
}

Verdict atMost(const std::string& name, const Search& fast, const Search& slow, double share) {
  const double measured = fast.median() / slow.median();
  return {name + ": " + fast.name + " needs " + shortNumber(measured) + " of the time of " + slow.name +
              " (" + shortNumber(fast.median()) + " and " + shortNumber(slow.median()) +
              " ms; asked: at most " + shortNumber(share) + ")",
          measured <= share};
}

}  // namespace

void runHardModels(double inlier_ratio, int peer_every, const std::string& name, Report& report) {
  std::vector<Search> searches;
  try {
    searches = {ours("usac:h"), ours("ransac:h")};
  } catch (const std::invalid_argument& error) {
    return report.addFailure(name, error.what());
  }
  searches.push_back({"cv::findHomography RANSAC", openCvModel, peer_every});
  SceneSpec spec{MatchSceneKind::kPlane, kMatches, inlier_ratio};
  for (int seed = 0; seed < kSeeds; ++seed) {
    spec.seed = std::uint64_t(seed);
    Scene scene = core::makeScene(spec);
    scene.matches.distance.clear();
    scene.matches.second_distance.clear();
    for (Search& search : searches) {
      if (seed % search.every == 0) search.run(scene);
    }
  }
  for (const Search& search : searches) {
    report.add(HardRow{name, search.name, inlier_ratio, search.seeds, search.found, search.median()});
  }
  const Search &usac = searches[0], &ransac = searches[1], &peer = searches[2];
  report.add(Verdict{name + ": usac:h finds " + std::to_string(usac.found) + " of " +
                         std::to_string(usac.seeds) + ", ransac:h " + std::to_string(ransac.found) +
                         " (asked: at most 5 points fewer)",
                     usac.rate() >= ransac.rate() - 5});
  report.add(atMost(name, usac, peer, 0.1));
  report.add(atMost(name, usac, ransac, 0.5));
}

}  // namespace corrsel::performance
