#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::core {

/// Takes rows of a column and keeps the memory of the target. An empty column stays empty.
template <class T>
void gather(const std::vector<T>& from, const std::vector<std::uint32_t>& rows, std::vector<T>& to) {
  to.resize(from.empty() ? 0 : rows.size());
  for (std::size_t i = 0; i < to.size(); ++i) to[i] = from[rows[i]];
}

/// Takes rows of all columns except the feature numbers, and keeps the memory of the target.
inline void gather(const Correspondences& from, const std::vector<std::uint32_t>& rows, Correspondences& to) {
  gather(from.left_x, rows, to.left_x);
  gather(from.left_y, rows, to.left_y);
  gather(from.right_x, rows, to.right_x);
  gather(from.right_y, rows, to.right_y);
  gather(from.distance, rows, to.distance);
  gather(from.second_distance, rows, to.second_distance);
  gather(from.probability, rows, to.probability);
  gather(from.left_frame, rows, to.left_frame);
  gather(from.right_frame, rows, to.right_frame);
  to.left_size = from.left_size;
  to.right_size = from.right_size;
  to.left_camera = from.left_camera;
  to.right_camera = from.right_camera;
  to.prior = from.prior;
  to.guess = from.guess;
}

}  // namespace corrsel::core
