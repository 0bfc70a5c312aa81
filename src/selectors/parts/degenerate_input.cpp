#include "selectors/parts/degenerate_input.h"

#include "base/coordinate_order.h"

namespace corrsel::core {

bool endsAtEqualPoints(const Correspondences& matches, Selection& result) {
  if (!allEqual(matches.left_x, matches.left_y) && !allEqual(matches.right_x, matches.right_y)) return false;
  result.status = Status::kDegenerate;
  result.message = "all points of an image are equal";
  return true;
}

bool endsAtFrames(const Correspondences& matches, std::size_t usable, Selection& result) {
  if (usable == 0) {
    result.status = Status::kDegenerate;
    result.message = "no match has usable frames";
    return true;
  }
  const std::size_t n = matches.size();
  if (n > 1 && endsAtEqualPoints(matches, result)) return true;
  if (usable < n) result.message = std::to_string(n - usable) + " matches have no usable frames";
  return false;
}

std::string missingFrames(const Correspondences& matches, const std::string& selector) {
  if (matches.empty()) return "";
  if (matches.left_frame.empty()) return selector + " needs the local affine frames of the left features";
  if (matches.right_frame.empty()) return selector + " needs the local affine frames of the right features";
  return "";
}

}  // namespace corrsel::core
