#pragma once

#include <rosbag/message_instance.h>
#include <sensor_msgs/CameraInfo.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "corrsel/ground_truth.h"
#include "ros/bags/bag_file.h"
#include "ros/bags/bag_topics.h"

namespace corrsel {

inline constexpr char kInfoType[] = "sensor_msgs/CameraInfo";
inline constexpr char kTruthType[] = "corrsel/GroundTruth";

/// A message, which stays in the bag until it is instantiated, and its stamp in ns.
struct Stamped {
  std::int64_t stamp;
  rosbag::MessageInstance message;
};

/// What a bag holds about the calibration of one camera.
struct Calibration {
  std::string topic;
  std::optional<sensor_msgs::CameraInfo> info;  ///< the first message
  bool changes = false;                         ///< a later message differs from the first one
};

/// One pass through chosen topics of a bag: the messages by their stamps, and the calibrations. Of other
/// messages than camera_info only the header is read.
class BagScan {
 public:
  struct Topic {
    std::string name;
    std::string checksum = "*";  ///< of the messages' definition; messages with another one cannot be read
  };

  /// @param stamped  topics whose messages have a header. @param infos  topics with camera_info
  /// Throws core::DatasetError if the bag is damaged beyond single messages.
  BagScan(const BagFile& file, const std::vector<Topic>& stamped, const std::vector<std::string>& infos);

  /// Readable messages, in the order of the stamps in their headers; equal stamps stay in the order of the
  /// bag. A message without a stamp in its header counts with the time of its recording.
  /// They are moved out, so that a second call returns none.
  std::vector<Stamped> take(const std::string& topic);

  /// Without info where no message can be read.
  const Calibration& calibration(const std::string& topic) const;

  /// Number of messages that cannot be read: those of another version, and those in damaged parts of the bag.
  std::size_t unreadable(const std::string& topic) const;

  /// Appends a note for every topic with messages that could not be read or had no stamp.
  void describe(std::vector<std::string>& notes) const;

 private:
  void add(const rosbag::MessageInstance& message, const std::map<std::string, std::string>& checksums);

  std::map<std::string, std::vector<Stamped>> messages_;
  std::map<std::string, Calibration> calibrations_;
  std::map<std::string, std::size_t> unreadable_, unstamped_;
};

/// For every stamp of one list its partner in another one.
struct Partners {
  std::vector<std::optional<std::size_t>> of;  ///< per stamp of the first list: its partner in the second
  std::int64_t min_difference = std::numeric_limits<std::int64_t>::max();  ///< ns, whether paired or not
  std::size_t size() const;                                                ///< stamps that have a partner
};

std::vector<std::int64_t> stampsOf(const std::vector<Stamped>& messages);

/// Pairs stamps that are nearest to each other and differ by at most `tolerance` [ns]. Both lists are sorted.
/// O(n log m).
Partners partners(const std::vector<std::int64_t>& first, const std::vector<std::int64_t>& second,
                  std::int64_t tolerance);

/// BagTopics::max_stamp_difference in ns.
std::int64_t tolerance(const BagTopics& options);

/// The topic with the ground truth: the named one or the usual one; empty where there is none. A usual topic
/// of another type is noted. Throws core::DatasetError if the bag does not have the named topic.
std::string truthTopic(const BagFile& file, const std::string& named, std::vector<std::string>& notes);

/// The topic with the named camera_info. Throws core::DatasetError if the bag does not have it.
/// @param side  "left" or "right"
std::string namedInfoTopic(const BagFile& file, const std::string& named, const std::string& side);

/// Appends a note if the calibration changes within the bag.
void describeChanges(const Calibration& calibration, std::vector<std::string>& notes);

/// The ground truth in a message. Throws std::invalid_argument for another version of the message, and what
/// fromMsg() throws.
core::GroundTruth readTruth(const rosbag::MessageInstance& message);

/// "0.25 s"
std::string secondsText(std::int64_t nanoseconds);

/// "1 message", "2 messages"
std::string count(std::size_t n, const std::string& noun);

/// "3 of 4 pairs are evaluated with camera_info on LEFT and RIGHT"; empty where it is none.
std::string calibrationText(std::size_t evaluated, std::size_t pairs, const Calibration& left,
                            const Calibration& right);

}  // namespace corrsel
