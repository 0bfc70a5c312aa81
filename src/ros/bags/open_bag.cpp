#include "ros/bags/open_bag.h"

#include <utility>

#include "ros/bags/bag_file.h"
#include "ros/bags/dataset_bag.h"
#include "ros/bags/own_bag.h"
#include "ros/bags/recorded_bag.h"

namespace corrsel {

std::unique_ptr<BagSource> openBag(const std::string& path, const BagTopics& topics) {
  BagFile file(path);
  const bool names_matches = !topics.correspondences.empty();
  if (names_matches || (!topics.nameImages() && RecordedMatchesSource::recognises(file))) {
    return std::make_unique<RecordedMatchesSource>(std::move(file), topics);
  }
  if (topics.nameAnythingButMatches() || OwnBagSource::recognises(file)) {
    return std::make_unique<OwnBagSource>(std::move(file), topics);
  }
  return std::make_unique<DatasetBagSource>(std::move(file));
}

}  // namespace corrsel
