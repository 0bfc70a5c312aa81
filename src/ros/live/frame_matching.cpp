#include "ros/live/frame_matching.h"

#include <boost/make_shared.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/stopwatch.h"

namespace corrsel {

boost::shared_ptr<Correspondences> matchFrames(const FrameFeatures& left, const FrameFeatures& right,
                                               const Matching& matching, double conversion_seconds,
                                               PairInfo info, core::Correspondences* kept) {
  core::Stopwatch watch;
  std::optional<core::MotionGuess> guess;
  if (matching.guess) {
    guess = matching.guess(left, right, info);
    info.seconds.wait += watch.restart();
  }
  auto [matches, verdict] = matching.match(left, right, guess);
  const std::string inconsistency = matches.inconsistency();
  if (!inconsistency.empty()) throw std::runtime_error("the matcher returned matches whose " + inconsistency);
  matches.left_camera = left.camera;
  matches.right_camera = right.camera;
  matches.guess = guess;
  info.guess = verdict;
  info.seconds.match = watch.restart();
  info.n_left_features = static_cast<std::uint32_t>(left.features.keypoints.size());
  info.n_right_features = static_cast<std::uint32_t>(right.features.keypoints.size());
  if (kept != nullptr) *kept = matches;
  auto message = boost::make_shared<Correspondences>(toMsg(std::move(matches), info));
  message->seconds.publish = conversion_seconds + watch.seconds();
  return message;
}

boost::shared_ptr<Correspondences> SequenceMatching::add(std::shared_ptr<const core::Features> features,
                                                         const std::optional<core::Camera>& camera,
                                                         const core::SequenceOptions& options,
                                                         const Matching& matching, double conversion_seconds,
                                                         PairInfo info) {
  const std::uint64_t id = info.header.stamp.toNSec();
  sequence_.setOptions(options);
  const core::Sequence::Frame* reference = sequence_.reference();
  if (reference != nullptr &&
      (reference->features->image_size != features->image_size || reference->id > id)) {
    sequence_.reset();
    reference = nullptr;
  }
  boost::shared_ptr<Correspondences> message;
  core::Correspondences matches;
  if (reference != nullptr) {
    info.right_stamp.fromNSec(reference->id);
    info.right_frame_id = info.header.frame_id;
    info.right_quality = reference->quality;
    message = matchFrames({*features, camera}, {*reference->features, reference->camera}, matching,
                          conversion_seconds, info, &matches);
  }
  sequence_.add({id, std::move(features), camera, info.left_quality}, matches);
  return message;
}

}  // namespace corrsel
