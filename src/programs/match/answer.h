#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/selection.h"

namespace corrsel {

/// One of two images.
struct MatchedImage {
  std::string file;
  cv::Mat pixels;
  std::size_t features = 0;
};

/// What corrsel_match found out about two images.
struct MatchAnswer {
  MatchedImage left, right;
  std::string features, selector;  ///< as they were given
  core::Correspondences matches;
  core::Selection selection;
  double read_seconds = 0, features_seconds = 0, match_seconds = 0, select_seconds = 0;  ///< wall times
};

/// The answer for people, in lines.
std::string textOf(const MatchAnswer& answer);

/// The line that follows where files were written.
std::string writtenLine(const std::vector<std::string>& files);

/// The answer as one JSON object (docs/doors.md lists its keys).
std::string jsonOf(const MatchAnswer& answer);

}  // namespace corrsel
