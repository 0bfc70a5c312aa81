#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "corrsel/options.h"
#include "scenes.h"

namespace corrsel::performance {

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

/// Processor time of the whole process, summed over its threads. The load of other programs does not change
/// it, and neither does a second thread.
class ProcessorTime {
 public:
  ProcessorTime() : start_(now()) {}
  /// Seconds since construction.
  double seconds() const { return now() - start_; }

 private:
  static double now();
  double start_;
};

/// One call of a method on the scene with the given number. Matchers return the bytes of their result as the
/// mask.
using Call = std::function<Mask(std::size_t scene)>;

/// A selector or the matcher of this package, or the function that it is compared with.
struct Method {
  std::string name;
  SceneSpec scene;
  std::size_t scenes = 1;  ///< number of scenes on which it is timed in turn
  /// Prepares everything that is not timed and returns the call. The text of an exception is reported.
  std::function<Call(const std::vector<Scene>&)> prepare;
  bool same_mask = false;  ///< must select exactly what the first method of the comparison selects
  bool wall_time = false;  ///< instead of processor time; for comparisons of thread counts
  /// Scenes of calibrated cameras instead; `scene` holds what the tables show of them.
  std::optional<core::CalibratedSceneSpec> calibrated = {};

  void setScene(const core::CalibratedSceneSpec& spec);
};

/// The measurements of one method; times are NaN where it failed.
struct Measurement {
  std::string name;
  std::string failure;                 ///< why there is no time
  double milliseconds = kNotMeasured;  ///< median
  double lower_quartile = kNotMeasured, upper_quartile = kNotMeasured;
  int repetitions = 0;
  double precision = kNotMeasured, recall = kNotMeasured,
         f = kNotMeasured;  ///< percent, mean over the scenes
  std::vector<Mask> masks;  ///< one per scene
};

inline constexpr int kRepetitions = 20, kSlowRepetitions = 4;
inline constexpr double kSlowCall = 0.5;      ///< s; slower calls are repeated less often
inline constexpr double kMinSeconds = 0.001;  ///< s; shorter calls are repeated within one repetition

/// Times all methods in turn, again and again, so that a disturbance of the machine affects all of them
/// alike. Before that, each method is called once per scene, which gives the masks and the quality.
std::vector<Measurement> measure(const std::vector<Method>& methods);

/// A selector of this package.
Method selector(const std::string& spec, const SceneSpec& scene, std::size_t scenes,
                const core::OptionMap& options = {});

/// A function from matches to a mask.
Method function(const std::string& name, const SceneSpec& scene, std::size_t scenes,
                Mask (*call)(const core::Correspondences&), bool same_mask);

/// cv::findHomography or cv::findFundamentalMat.
struct OpenCvOptions {
  int method = 0;  ///< cv::RANSAC, CORRSEL_USAC(DEFAULT)...
  double threshold = 3;
  int max_iterations = 10000;
  double confidence = 0.99;
};
Method openCv(const std::string& name, const SceneSpec& scene, std::size_t scenes,
              const OpenCvOptions& options);

/// Number of samples that cv::findHomography(RANSAC) draws on this scene, from its stopping rule and the
/// inliers that it reports.
int samplesOfOpenCv(const Scene& scene, const OpenCvOptions& options);

}  // namespace corrsel::performance
