#pragma once

#include <memory>
#include <string>

#include "ros/bags/bag_source.h"
#include "ros/bags/bag_topics.h"

namespace corrsel {

/// Opens a bag as the kind of source that its topics and the named topics call for:
/// - RecordedMatchesSource if the topic of the matches is named, or if the bag has matches and no image;
/// - OwnBagSource if another topic is named, or if the bag has camera_info for both images and neither ground
///   truth nor matches;
/// - DatasetBagSource otherwise.
/// Throws core::DatasetError that names the cause and the remedy, and what the sources throw.
std::unique_ptr<BagSource> openBag(const std::string& path, const BagTopics& topics = {});

}  // namespace corrsel
