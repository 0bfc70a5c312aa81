#include "measurement.h"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/calib3d.hpp>
#include <stdexcept>

#include "base/stopwatch.h"
#include "corrsel/evaluation/statistics.h"
#include "corrsel/selectors/factory.h"
#include "opencv_version.h"

namespace corrsel::performance {
namespace {

// USAC_ACCURATE of OpenCV 4.6 throws std::bad_alloc at 50000 matches and crashes the program at 100000.
constexpr std::size_t kMaxAccurate = 40000;

struct Contestant {
  std::shared_ptr<const std::vector<Scene>> inputs;
  Call call;
  int batch = 1;  // calls per repetition
  int every = 1;  // takes part in every so many rounds
  std::vector<double> milliseconds;
};

void evaluate(const std::vector<Scene>& truth, Measurement& result) {
  std::vector<double> precision, recall, f;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    double selected = 0, inliers = 0, correct = 0;
    for (std::size_t i = 0; i < truth[k].inlier.size(); ++i) {
      const bool chosen = i < result.masks[k].size() && result.masks[k][i];
      selected += chosen;
      inliers += truth[k].inlier[i];
      correct += chosen && truth[k].inlier[i];
    }
    precision.push_back(selected > 0 ? 100 * correct / selected : 0);
    recall.push_back(100 * correct / inliers);
    f.push_back(200 * correct / (selected + inliers));
  }
  result.precision = core::mean(precision);
  result.recall = core::mean(recall);
  result.f = core::mean(f);
}

template <typename Work>
double secondsOf(bool wall_time, const Work& work) {
  const ProcessorTime processor;
  const core::Stopwatch wall;
  work();
  return wall_time ? wall.seconds() : processor.seconds();
}

/// Matchers are timed on descriptors instead, which have no inlier ratio.
bool hasScenes(const Method& method) { return !std::isnan(method.scene.inlier_ratio); }

/// The scenes of a method; matchers have one that is empty.
std::shared_ptr<const std::vector<Scene>> inputsOf(const Method& method) {
  if (method.calibrated) return scenes(*method.calibrated, method.scenes);
  if (hasScenes(method)) return scenes(method.scene, method.scenes);
  return std::make_shared<const std::vector<Scene>>(1);
}

/// Everything before the timed rounds.
void warmUp(const Method& method, Contestant& contestant, Measurement& result) {
  contestant.inputs = inputsOf(method);
  const std::vector<Scene>& inputs = *contestant.inputs;
  contestant.call = method.prepare(inputs);
  double seconds = 0;
  const auto timed = [&](std::size_t k) {
    Mask mask;
    seconds = secondsOf(method.wall_time, [&] { mask = contestant.call(k); });
    return mask;
  };
  for (std::size_t k = 0; k < inputs.size(); ++k) result.masks.push_back(timed(k));
  if (hasScenes(method)) evaluate(inputs, result);
  // The only call so far may have been slower than those to come: look again where that is cheap.
  if (seconds < kSlowCall) timed(0);
  contestant.batch = int(std::ceil(kMinSeconds / std::max(seconds, 1e-7)));
  contestant.every = seconds < kSlowCall ? 1 : kRepetitions / kSlowRepetitions;
}

Mask bytes(const cv::Mat& mask, std::size_t n) {
  return mask.empty() ? Mask(n, 0) : Mask(mask.ptr<std::uint8_t>(), mask.ptr<std::uint8_t>() + n);
}

}  // namespace

void Method::setScene(const core::CalibratedSceneSpec& spec) {
  scene = {MatchSceneKind::kSpace, spec.n, spec.inlier_ratio};
  calibrated = spec;
}

double ProcessorTime::now() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

std::vector<Measurement> measure(const std::vector<Method>& methods) {
  std::vector<Measurement> results(methods.size());
  std::vector<Contestant> contestants(methods.size());
  for (std::size_t i = 0; i < methods.size(); ++i) {
    results[i].name = methods[i].name;
    try {
      warmUp(methods[i], contestants[i], results[i]);
    } catch (const std::exception& error) {
      results[i].failure = error.what();
      if (i == 0) return results;
    }
  }
  for (int round = 0; round < kRepetitions; ++round) {
    for (std::size_t i = 0; i < methods.size(); ++i) {
      Contestant& contestant = contestants[i];
      if (!results[i].failure.empty() || round % contestant.every != 0) continue;
      const std::size_t scene = std::size_t(round) % methods[i].scenes;
      try {
        const double seconds = secondsOf(methods[i].wall_time, [&] {
          for (int call = 0; call < contestant.batch; ++call) contestant.call(scene);
        });
        contestant.milliseconds.push_back(1e3 * seconds / contestant.batch);
      } catch (const std::exception& error) {
        results[i].failure = error.what();
      }
    }
  }
  for (std::size_t i = 0; i < methods.size(); ++i) {
    if (!results[i].failure.empty()) continue;
    results[i].repetitions = int(contestants[i].milliseconds.size());
    results[i].milliseconds = core::quantile(contestants[i].milliseconds, 0.5);
    results[i].lower_quartile = core::quantile(contestants[i].milliseconds, 0.25);
    results[i].upper_quartile = core::quantile(contestants[i].milliseconds, 0.75);
  }
  return results;
}

Method selector(const std::string& spec, const SceneSpec& scene, std::size_t scenes,
                const core::OptionMap& options) {
  return {spec, scene, scenes, [spec, options](const std::vector<Scene>& inputs) -> Call {
            const std::shared_ptr<const core::Selector> made =
                core::createSelector(spec, options, {{"threads", "1"}});
            return [made, &inputs](std::size_t k) { return made->select(inputs[k].matches).mask; };
          }};
}

Method function(const std::string& name, const SceneSpec& scene, std::size_t scenes,
                Mask (*call)(const core::Correspondences&), bool same_mask) {
  return {name, scene, scenes,
          [call](const std::vector<Scene>& inputs) -> Call {
            return [call, &inputs](std::size_t k) { return call(inputs[k].matches); };
          },
          same_mask};
}

Method openCv(const std::string& name, const SceneSpec& scene, std::size_t scenes,
              const OpenCvOptions& options) {
  const bool plane = scene.kind == MatchSceneKind::kPlane;
  return {name, scene, scenes, [options, plane](const std::vector<Scene>& inputs) -> Call {
            if (options.method < 0) throw std::runtime_error("not run, needs OpenCV 4.5");
            if (options.method == CORRSEL_USAC(ACCURATE) && inputs[0].left.size() > kMaxAccurate) {
              throw std::runtime_error("not run, crashes in OpenCV 4.6");
            }
            return [options, plane, &inputs](std::size_t k) {
              const Scene& scene = inputs[k];
              cv::Mat mask;
              if (plane) {
                cv::findHomography(scene.left, scene.right, options.method, options.threshold, mask,
                                   options.max_iterations, options.confidence);
              } else {
#if CORRSEL_OPENCV_AT_LEAST(4, 5)
                cv::findFundamentalMat(scene.left, scene.right, options.method, options.threshold,
                                       options.confidence, options.max_iterations, mask);
#else  // there the number of iterations is fixed
                cv::findFundamentalMat(scene.left, scene.right, options.method, options.threshold,
                                       options.confidence, mask);
#endif
              }
              return bytes(mask, scene.left.size());
            };
          }};
}

int samplesOfOpenCv(const Scene& scene, const OpenCvOptions& options) {
  cv::Mat mask;
  cv::findHomography(scene.left, scene.right, options.method, options.threshold, mask, options.max_iterations,
                     options.confidence);
  const double ratio = cv::countNonZero(mask) / double(scene.left.size());
  const double needed = std::log1p(-options.confidence) / std::log1p(-std::pow(ratio, 4));
  return int(std::lround(std::min(needed, double(options.max_iterations))));
}

}  // namespace corrsel::performance
