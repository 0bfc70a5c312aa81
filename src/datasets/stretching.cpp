#include "datasets/stretching.h"

#include <opencv2/imgproc.hpp>
#include <utility>

#include "features/parts/grey_image.h"

namespace corrsel::core {

void readStretched(const StoredImage& left, const StoredImage& right, ImagePair& pair) {
  const std::pair<const StoredImage*, cv::Mat*> images[] = {{&left, &pair.left}, {&right, &pair.right}};
  StretchedBits found;
  found.largest = -1;
  for (const auto& [stored, image] : images) {
    *image = stored->read(true);
    if (image->depth() != CV_16U) continue;
    const int largest = largestValue(*image);
    if (largest <= found.largest) continue;
    found.largest = largest;
    found.image = stored->name;
  }
  found.bits = significantBits(found.largest);
  const bool stretch = found.largest >= 0 && found.bits < kMaxBits;
  for (const auto& [stored, image] : images) {
    if (image->depth() == CV_8U) continue;
    *image = stretch && image->depth() == CV_16U ? toEightBits(*image, found.bits) : stored->read(false);
    if (image->channels() == 4) cv::cvtColor(*image, *image, cv::COLOR_BGRA2BGR);
  }
  if (stretch) pair.stretched = found;
}

}  // namespace corrsel::core
