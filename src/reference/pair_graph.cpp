#include "reference/pair_graph.h"

#include <algorithm>
#include <cmath>

namespace corrsel::core {
namespace {

constexpr float kSamePoint = 1;  // px

}  // namespace

void PairGraph::build(const PairColumns& m, std::size_t n, int k) {
  nodes_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const float a = m.a11[i], b = m.a12[i], c = m.a21[i], d = m.a22[i], det = a * d - b * c;
    nodes_[i] = {{m.left_x[i], m.left_y[i]},
                 {m.right_x[i], m.right_y[i]},
                 {a, b, c, d},
                 {d / det, -b / det, -c / det, a / det}};
  }
  degree_ = n == 0 ? 0 : std::min<std::size_t>(static_cast<std::size_t>(k), n - 1);
  lists_.resize(n * (degree_ + 1));
  if (degree_ == 0) return;
  const int asked = static_cast<int>(degree_) + 1;
  // Matches are numbered by x, cells along their first coordinate. With x and y exchanged both orders agree,
  // which keeps what is used together in the cache.
  index_.build(m.left_y, m.left_x, n, asked);
  index_.nearestToAll(m.left_y, m.left_x, n, asked, lists_.data());
  // The match itself is taken out of every list; of a crowd at one place it may be missing.
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t* const list = lists_.data() + i * (degree_ + 1);
    const std::uint32_t* const self = std::find(list, list + degree_, static_cast<std::uint32_t>(i));
    std::uint32_t* const out = lists_.data() + i * degree_;
    std::copy(self + 1, list + degree_ + 1, std::copy(list, self, out));
  }
}

void PairGraph::errors(std::size_t match, float* out) const {
  const Node i = nodes_[match];
  const std::uint32_t* const list = neighbours(match);
  // The neighbours' values side by side: left and right offset, map and inverse map.
  float u[2][kMaxNeighbours], v[2][kMaxNeighbours], a[4][kMaxNeighbours], b[4][kMaxNeighbours];
  for (std::size_t k = 0; k < degree_; ++k) {
    const Node& j = nodes_[list[k]];
    u[0][k] = j.left[0] - i.left[0];
    u[1][k] = j.left[1] - i.left[1];
    v[0][k] = j.right[0] - i.right[0];
    v[1][k] = j.right[1] - i.right[1];
    for (std::size_t e = 0; e < 4; ++e) {
      a[e][k] = j.map[e];
      b[e][k] = j.inverse[e];
    }
  }
  const auto squaredError = [](float m11, float m12, float m21, float m22, float x, float y, float to_x,
                               float to_y) {
    const float dx = m11 * x + m12 * y - to_x, dy = m21 * x + m22 * y - to_y;
    return dx * dx + dy * dy;
  };
  for (std::size_t k = 0; k < degree_; ++k) {
    const float ux = u[0][k], uy = u[1][k], vx = v[0][k], vy = v[1][k];
    const float by_i = squaredError(i.map[0], i.map[1], i.map[2], i.map[3], ux, uy, vx, vy);
    const float by_j = squaredError(a[0][k], a[1][k], a[2][k], a[3][k], ux, uy, vx, vy);
    const float back_i = squaredError(i.inverse[0], i.inverse[1], i.inverse[2], i.inverse[3], vx, vy, ux, uy);
    const float back_j = squaredError(b[0][k], b[1][k], b[2][k], b[3][k], vx, vy, ux, uy);
    const float sum = (std::sqrt(by_i) + std::sqrt(by_j)) + (std::sqrt(back_i) + std::sqrt(back_j));
    const float nearest = std::min(ux * ux + uy * uy, vx * vx + vy * vy);
    out[k] = nearest <= kSamePoint * kSamePoint ? kNoEdge : sum / 4;
  }
}

}  // namespace corrsel::core
