#include "ros/live/mask_gate.h"

#include <iterator>

namespace corrsel {

void MaskTrack::addImage(Stamp stamp) {
  const auto [image, is_new] = images_.try_emplace(stamp);
  if (!is_new) return;
  decide(image);
  // The oldest one stays, because it may be the keyframe of a sequence.
  if (images_.size() > capacity_) images_.erase(std::next(images_.begin()));
}

void MaskTrack::addMask(Stamp stamp, cv::Mat mask) {
  ++received_;
  const auto known = masks_.find(stamp);
  if (known != masks_.end()) erase(known);
  masks_[stamp] = std::make_shared<Mask>(Mask{std::move(mask), false});
  newest_mask_ = stamp;
  for (auto image = images_.begin(); image != images_.end() && image->first <= stamp; ++image) {
    if (!image->second.decided) decide(image);
  }
  if (masks_.size() > capacity_) erase(masks_.begin());
}

void MaskTrack::decide(Images::iterator image) {
  const auto mask = masks_.lower_bound(image->first);
  if (mask == masks_.end()) return;
  image->second.decided = true;
  const auto next = std::next(image);
  const bool belongs_to_next = next != images_.end() && next->first <= mask->first;
  if (!belongs_to_next && mask->first - image->first <= max_age_) image->second.mask = mask->second;
}

bool MaskTrack::decided(Stamp image) const {
  const auto found = images_.find(image);
  return found != images_.end() && found->second.decided;
}

cv::Mat MaskTrack::maskOf(Stamp image) {
  const auto found = images_.find(image);
  if (found == images_.end() || !found->second.mask) return {};
  found->second.mask->used = true;
  return found->second.mask->pixels;
}

MaskTrack::Masks::iterator MaskTrack::erase(Masks::iterator mask) {
  if (!mask->second->used) ++unused_;
  return masks_.erase(mask);
}

void MaskTrack::forget(Stamp before) {
  images_.erase(images_.begin(), images_.lower_bound(before));
  for (auto mask = masks_.begin(); mask != masks_.end() && mask->first < before;) mask = erase(mask);
}

void MaskTrack::clear() {
  images_.clear();
  for (auto mask = masks_.begin(); mask != masks_.end();) mask = erase(mask);
  newest_mask_.reset();
}

}  // namespace corrsel
