#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

namespace corrsel {

/// A callback queue with a thread that calls one callback at a time. A nodelet uses it instead of the queues
/// of its manager, for two reasons. The manager's queues do not outlive a nodelet that is unloaded while a
/// callback runs: the last reference to the nodelet is then released on a worker's thread, after its queues
/// are gone, and its subscribers, publishers and services still hold pointers to them (nodelet 1.10). And a
/// manager whose threads are all busy with other nodelets does not delay this one.
class CallbackThread {
 public:
  CallbackThread() : spinner_(1, &queue_) { spinner_.start(); }

  /// The same handle with callbacks on this thread. Everything that is made with it must be destroyed before
  /// this object.
  ros::NodeHandle handle(const ros::NodeHandle& nh) {
    ros::NodeHandle result(nh);
    result.setCallbackQueue(&queue_);
    return result;
  }

  /// Waits for a callback that is running; afterwards no callback comes. Must not be called from a callback.
  void stop() { spinner_.stop(); }

 private:
  ros::CallbackQueue queue_;
  ros::AsyncSpinner spinner_;  ///< last: it uses the queue
};

}  // namespace corrsel
