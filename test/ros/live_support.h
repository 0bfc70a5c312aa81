#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <dynamic_reconfigure/config_tools.h>
#include <gtest/gtest.h>
#include <nodelet/loader.h>
#include <ros/console.h>
#include <ros/ros.h>
#include <sensor_msgs/Image.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <string>
#include <thread>
#include <vector>

#include "corrsel/random.h"
#include "corrsel/ros/conversions.h"
#include "wait_for.h"

namespace corrsel::testing {

using namespace std::chrono_literals;

/// Keeps what arrives on a topic, by stamp.
template <class Message>
class Inbox {
 public:
  using Pointer = boost::shared_ptr<const Message>;
  struct Item {
    Pointer message;
    ros::WallTime arrival;
  };

  Inbox(ros::NodeHandle& nh, const std::string& topic)
      : subscriber_(nh.subscribe<Message>(topic, 1000, &Inbox::receive, this)) {}

  bool connected() const { return subscriber_.getNumPublishers() > 0; }

  /// Null when nothing came in time.
  Pointer wait(const ros::Time& stamp) {
    std::unique_lock<std::mutex> lock(mutex_);
    arrived_.wait_for(lock, kPatience, [&] { return messages_.count(stamp) != 0; });
    const auto found = messages_.find(stamp);
    return found == messages_.end() ? nullptr : found->second;
  }

  bool has(const ros::Time& stamp) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return messages_.count(stamp) != 0;
  }

  /// All messages in the order of arrival.
  std::vector<Item> all() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return items_;
  }

  std::size_t size() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return items_.size();
  }

  /// Lets go of all messages, as a subscriber does that has used them.
  void forget() {
    const std::lock_guard<std::mutex> lock(mutex_);
    messages_.clear();
    items_.clear();
  }

 private:
  void receive(const Pointer& message) {
    const std::lock_guard<std::mutex> lock(mutex_);
    messages_[message->header.stamp] = message;
    items_.push_back({message, ros::WallTime::now()});
    arrived_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable arrived_;
  std::map<ros::Time, Pointer> messages_;
  std::vector<Item> items_;
  ros::Subscriber subscriber_;
};

/// Blocks and discs: many corners, the same on every platform.
inline cv::Mat texture(int width, int height, std::uint64_t seed) {
  core::Random random(seed);
  cv::Mat image(height, width, CV_8UC1, cv::Scalar(128));
  for (int i = 0; i < 300; ++i) {
    const int x = static_cast<int>(random.index(static_cast<std::uint32_t>(width)));
    const int y = static_cast<int>(random.index(static_cast<std::uint32_t>(height)));
    const int size = 4 + static_cast<int>(random.index(24));
    const cv::Scalar grey(random.index(256));
    if (i % 2 == 0) {
      cv::rectangle(image, cv::Rect(x, y, size, size), grey, cv::FILLED);
    } else {
      cv::circle(image, {x, y}, size / 2, grey, cv::FILLED);
    }
  }
  return image;
}

/// A message of its own, whose data is a copy.
inline sensor_msgs::ImagePtr imageMsg(const ros::Time& stamp, const std::string& frame,
                                      const std::string& encoding, const cv::Mat& image) {
  std_msgs::Header header;
  header.stamp = stamp;
  header.frame_id = frame;
  return cv_bridge::CvImage(header, encoding, image).toImageMsg();
}

/// Sets parameters of a nodelet through its set_parameters. Texts "true" and "false" are flags.
/// @return the values of the text parameters that are in force
inline std::map<std::string, std::string> configure(const std::string& nodelet,
                                                    const std::map<std::string, std::string>& texts,
                                                    const std::map<std::string, double>& numbers = {},
                                                    const std::map<std::string, int>& integers = {}) {
  using dynamic_reconfigure::ConfigTools;
  dynamic_reconfigure::Reconfigure call;
  for (const auto& [name, value] : texts) {
    if (value == "true" || value == "false") {
      ConfigTools::appendParameter(call.request.config, name, value == "true");
    } else {
      ConfigTools::appendParameter(call.request.config, name, value);
    }
  }
  for (const auto& [name, value] : numbers) ConfigTools::appendParameter(call.request.config, name, value);
  for (const auto& [name, value] : integers) ConfigTools::appendParameter(call.request.config, name, value);
  const std::string service = nodelet + "/set_parameters";
  EXPECT_TRUE(waitFor([&] { return ros::service::call(service, call); })) << service;
  std::map<std::string, std::string> answer;
  for (const auto& parameter : call.response.config.strs) answer[parameter.name] = parameter.value;
  return answer;
}

/// The warnings and errors that this process logs while the object exists, those of its nodelets included.
class Log {
 public:
  std::size_t count(const std::string& part) const {
    const std::vector<std::string> lines = recorder().since(begin_);
    return static_cast<std::size_t>(std::count_if(lines.begin(), lines.end(), [&](const std::string& line) {
      return line.find(part) != std::string::npos;
    }));
  }

  std::string text() const {
    std::string text;
    for (const std::string& line : recorder().since(begin_)) text += line + "\n";
    return text;
  }

 private:
  class Recorder : public ros::console::LogAppender {
   public:
    Recorder() { ros::console::register_appender(this); }

    void log(ros::console::Level level, const char* text, const char*, const char*, int) override {
      if (level < ros::console::levels::Warn) return;
      const std::lock_guard<std::mutex> lock(mutex_);
      lines_.emplace_back(text);
    }

    std::vector<std::string> since(std::size_t begin) const {
      const std::lock_guard<std::mutex> lock(mutex_);
      return {lines_.begin() + static_cast<std::ptrdiff_t>(begin), lines_.end()};
    }

    std::size_t size() const {
      const std::lock_guard<std::mutex> lock(mutex_);
      return lines_.size();
    }

   private:
    mutable std::mutex mutex_;
    std::vector<std::string> lines_;
  };

  /// One for the whole process, never removed: the rosconsole of Debian 11 crashes at the next message after
  /// deregister_appender() and another register_appender().
  static Recorder& recorder() {
    static auto* const recorder = new Recorder;
    return *recorder;
  }

  const std::size_t begin_ = recorder().size();
};

/// The newest status of every name on /diagnostics.
class Diagnostics {
 public:
  explicit Diagnostics(ros::NodeHandle& nh)
      : subscriber_(nh.subscribe("/diagnostics", 1000, &Diagnostics::receive, this)) {}

  struct Status {
    int level = -1;  ///< -1: none came yet
    std::string message;
    std::map<std::string, std::string> values;

    double number(const std::string& key) const {
      const auto found = values.find(key);
      return found == values.end() ? std::nan("") : std::atof(found->second.c_str());
    }
  };

  /// @param node  resolved name of the node
  Status of(const std::string& node, const std::string& task) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = statuses_.find(node.substr(1) + ": " + task);  // without the first slash
    return found == statuses_.end() ? Status() : found->second;
  }

  std::string text() {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::string text;
    for (const auto& [name, status] : statuses_) {
      text += name + ": " + std::to_string(status.level) + " " + status.message + "\n";
      for (const auto& [key, value] : status.values) text += "    " + key + " = " + value + "\n";
    }
    return text;
  }

 private:
  void receive(const diagnostic_msgs::DiagnosticArrayConstPtr& msg) {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const diagnostic_msgs::DiagnosticStatus& status : msg->status) {
      Status& mine = statuses_[status.name];
      mine = {status.level, status.message, {}};
      for (const auto& value : status.values) mine.values[value.key] = value.value;
    }
  }

  std::mutex mutex_;
  std::map<std::string, Status> statuses_;
  ros::Subscriber subscriber_;
};

/// Nodelets in this process, as a manager would run them: with callback queues and worker threads of their
/// own.
class Nodelets {
 public:
  Nodelets() : loader_(false) {}

  /// Exceptions are logged, as the manager's load service does.
  bool load(const std::string& name, const std::string& type) {
    try {
      return loader_.load(name, type, {}, {});
    } catch (const std::exception& error) {
      ROS_ERROR_STREAM(name << ": " << error.what());
      return false;
    }
  }

  bool unload(const std::string& name) { return loader_.unload(name); }

 private:
  nodelet::Loader loader_;
};

}  // namespace corrsel::testing
