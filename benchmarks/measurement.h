#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "corrsel/options.h"
#include "scenes.h"

namespace corrsel::performance {

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

/// Processor time of the whole process, all threads: what other programs take from the wall time does not
/// count, and threads would not help.
class ProcessorTime {
 public:
  ProcessorTime() : start_(now()) {}
  /// Seconds since construction.
  double seconds() const { return now() - start_; }

 private:
  static double now();
  double start_;
};

/// One call of a method on the scene of the given number. Matchers give their outcome's bytes as the mask.
using Call = std::function<Mask(std::size_t scene)>;

/// A selector or the matcher of this package, or what it is compared with.
struct Method {
  std::string name;
  SceneSpec scene;
  std::size_t scenes = 1;  ///< timed on so many scenes in turn
  /// Makes everything that is not to be timed, then gives the call. May throw; the text is reported.
  std::function<Call(const std::vector<Scene>&)> prepare;
  bool same_mask = false;  ///< must select exactly what the first method of the comparison selects
  bool wall_time = false;  ///< instead of processor time: for what several threads gain
};

/// What was measured of one method; times are NaN where it failed.
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
inline constexpr double kSlowCall = 0.5;    ///< s; slower calls are repeated less often
inline constexpr double kShortest = 0.001;  ///< s; shorter calls are repeated within one repetition

/// Times all methods in turn, again and again, so that whatever else the machine does meets all of them
/// alike. Each has one call per scene beforehand, which gives masks and quality.
std::vector<Measurement> measure(const std::vector<Method>& methods);

/// A selector of this package.
Method selector(const std::string& spec, const SceneSpec& scene, std::size_t scenes,
                const core::OptionMap& options = {});

/// A function from matches to a mask.
Method function(const std::string& name, const SceneSpec& scene, std::size_t scenes,
                Mask (*call)(const core::Correspondences&), bool same_mask);

/// cv::findHomography or cv::findFundamentalMat.
struct OpenCvOptions {
  int method = 0;  ///< cv::RANSAC, cv::USAC_DEFAULT...
  double threshold = 3;
  int max_iterations = 10000;
  double confidence = 0.99;
};
Method openCv(const std::string& name, const SceneSpec& scene, std::size_t scenes,
              const OpenCvOptions& options);

/// Samples that cv::findHomography(RANSAC) draws on this scene: its stopping rule with the inliers it
/// reports.
int samplesOfOpenCv(const Scene& scene, const OpenCvOptions& options);

}  // namespace corrsel::performance
