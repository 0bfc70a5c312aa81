#include "features/parts/gradient.h"

namespace corrsel::core {

void polarGradients(const float* dx, const float* dy, std::size_t n, float turn, float* length,
                    float* direction) {
  for (std::size_t i = 0; i < n; ++i) {
    length[i] = std::sqrt(dx[i] * dx[i] + dy[i] * dy[i]);
    const float angle = directionOf<FineArctangent>(dx[i], dy[i]);
    direction[i] = (angle >= 1.0F ? 0.0F : angle) * turn;
  }
}

}  // namespace corrsel::core
