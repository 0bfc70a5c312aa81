#include "corrsel/correspondences.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "base/gather.h"
#include "base/text.h"

namespace corrsel::core {
namespace {

/// A sentence that names the first value that is no probability; empty if there is none.
std::string faultOfProbabilities(const std::vector<float>& values) {
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (std::isnan(values[row]) || (values[row] >= 0 && values[row] <= 1)) continue;
    return "column probability holds " + formatNumber(values[row]) + " in row " + std::to_string(row) +
           ", expected 0 to 1, or NaN where it is not known";
  }
  return "";
}

/// What check() of an optional value finds wrong; empty if nothing is.
template <class T>
std::string faultOf(const char* name, const std::optional<T>& value) {
  try {
    if (value) value->check();
  } catch (const std::invalid_argument& error) {
    return std::string(name) + "." + error.what();
  }
  return "";
}

}  // namespace

void Correspondences::add(const cv::Point2f& left, const cv::Point2f& right) {
  left_x.push_back(left.x);
  left_y.push_back(left.y);
  right_x.push_back(right.x);
  right_y.push_back(right.y);
}

std::string Correspondences::inconsistency() const {
  const std::size_t n = size();
  const auto wrong = [n](const char* column, std::size_t length, bool optional) -> std::string {
    if (length == n || (optional && length == 0)) return "";
    return std::string("column ") + column + " has " + std::to_string(length) + " elements, left_x has " +
           std::to_string(n);
  };
  for (const std::string& text :
       {wrong("left_y", left_y.size(), false), wrong("right_x", right_x.size(), false),
        wrong("right_y", right_y.size(), false), wrong("distance", distance.size(), true),
        wrong("second_distance", second_distance.size(), true),
        wrong("probability", probability.size(), true), wrong("left_frame", left_frame.size(), true),
        wrong("right_frame", right_frame.size(), true), wrong("left_index", left_index.size(), true),
        wrong("right_index", right_index.size(), true)}) {
    if (!text.empty()) return text;
  }
  for (const std::string& text :
       {faultOfProbabilities(probability), faultOf("left_camera", left_camera),
        faultOf("right_camera", right_camera), faultOf("prior", prior), faultOf("guess", guess)}) {
    if (!text.empty()) return text;
  }
  return "";
}

Correspondences Correspondences::subset(const std::vector<std::uint32_t>& rows) const {
  Correspondences result;
  gather(*this, rows, result);
  gather(left_index, rows, result.left_index);
  gather(right_index, rows, result.right_index);
  return result;
}

std::vector<std::uint32_t> selectedRows(const std::vector<std::uint8_t>& mask) {
  std::vector<std::uint32_t> rows;
  rows.reserve(mask.size() - static_cast<std::size_t>(std::count(mask.begin(), mask.end(), 0)));
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i]) rows.push_back(static_cast<std::uint32_t>(i));
  }
  return rows;
}

}  // namespace corrsel::core
