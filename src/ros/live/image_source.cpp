#include "ros/live/image_source.h"

#include <stdexcept>
#include <utility>

#include "ros/live/pair_synchronizer.h"
#include "ros/live/sequence_input.h"

namespace corrsel {

std::unique_ptr<ImageSource> openImageSource(const ros::NodeHandle& nh, const ros::NodeHandle& pnh,
                                             ImageSource::Callback on_set) {
  const auto mode = pnh.param<std::string>("mode", "pair");
  if (mode == "pair") return std::make_unique<PairSynchronizer>(nh, pnh, std::move(on_set));
  if (mode == "sequence") return std::make_unique<SequenceInput>(nh, pnh, std::move(on_set));
  throw std::invalid_argument("parameter " + pnh.resolveName("mode") + " = '" + mode +
                              "' is unknown; use pair or sequence");
}

}  // namespace corrsel
