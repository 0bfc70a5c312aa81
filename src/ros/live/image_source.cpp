#include "ros/live/image_source.h"

#include <utility>

#include "ros/live/image_subscriber.h"
#include "ros/live/pair_synchronizer.h"
#include "ros/live/sequence_input.h"

namespace corrsel {

std::unique_ptr<ImageSource> openImageSource(const ros::NodeHandle& nh, const ros::NodeHandle& pnh,
                                             const FeatureMatcherParameters& parameters,
                                             ImageSource::Callback on_set) {
  FeatureMatcherParameters usable = parameters;
  usable.image_transport = usableTransport(pnh, parameters.image_transport);
  if (parameters.mode == FeatureMatcherParameters::Mode::kSequence) {
    return std::make_unique<SequenceInput>(nh, pnh, usable, std::move(on_set));
  }
  return std::make_unique<PairSynchronizer>(nh, pnh, usable, std::move(on_set));
}

}  // namespace corrsel
