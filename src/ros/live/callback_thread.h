#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

namespace corrsel {

/// A callback queue with a thread that calls one callback at a time: what a nodelet uses instead of its
/// manager's queues. Those do not survive the nodelet where it is unloaded while a callback runs: the last
/// reference to it then goes on a worker's thread, after its queues, and its subscribers, publishers and
/// services still hold pointers to them (nodelet 1.10). And a manager whose threads are all busy with other
/// nodelets does not hold up this one.
class CallbackThread {
 public:
  CallbackThread() : spinner_(1, &queue_) { spinner_.start(); }

  /// The same handle with callbacks on this thread. What is made with it must be destroyed before this
  /// object.
  ros::NodeHandle handle(const ros::NodeHandle& nh) {
    ros::NodeHandle result(nh);
    result.setCallbackQueue(&queue_);
    return result;
  }

  /// Waits for a callback that is running; afterwards there are no more. Not to be called from a callback.
  void stop() { spinner_.stop(); }

 private:
  ros::CallbackQueue queue_;
  ros::AsyncSpinner spinner_;  ///< last: it uses the queue
};

}  // namespace corrsel
