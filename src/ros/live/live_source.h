#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>

#include <atomic>
#include <boost/shared_ptr.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace corrsel {

/// Where the items of a LiveStage come from.
class LiveSource {
 public:
  /// Names of the inputs, as the diagnostics show them, and how many messages of each have arrived.
  using Inputs = std::vector<std::pair<std::string, std::size_t>>;

  virtual ~LiveSource() = default;

  /// Idempotent, as unsubscribe() is. The two must not be called at the same time.
  virtual void subscribe() = 0;

  /// Waits for a callback that is running on another thread, so the caller must not hold a lock that the
  /// callback takes. Afterwards no callback comes. May be called from the callback itself.
  virtual void unsubscribe() = 0;

  /// Resolved names of the topics. Any thread.
  virtual std::vector<std::string> topics() const = 0;

  /// Counts since construction. Any thread.
  virtual Inputs inputs() const = 0;

  /// What is wrong with the input since the previous call; empty = nothing. Any thread.
  virtual std::string complaint() { return ""; }
};

/// Every message of one topic is an item.
template <class Message>
class MessageSource : public LiveSource {
 public:
  using Callback = std::function<void(const boost::shared_ptr<const Message>&)>;

  /// Does not subscribe yet. @param on_message  called on the queue of `nh`
  MessageSource(const ros::NodeHandle& nh, const std::string& topic, std::uint32_t queue_size,
                Callback on_message)
      : nh_(nh), topic_(topic), queue_size_(queue_size), on_message_(std::move(on_message)) {}

  void subscribe() override {
    subscriber_ =
        nh_.subscribe<Message>(topic_, queue_size_, [this](const boost::shared_ptr<const Message>& message) {
          ++received_;
          on_message_(message);
        });
  }
  void unsubscribe() override { subscriber_.shutdown(); }
  std::vector<std::string> topics() const override { return {nh_.resolveName(topic_)}; }
  Inputs inputs() const override { return {{topic_, received_}}; }

 private:
  ros::NodeHandle nh_;
  std::string topic_;
  std::uint32_t queue_size_;
  Callback on_message_;
  std::atomic<std::size_t> received_{0};
  ros::Subscriber subscriber_;
};

}  // namespace corrsel
