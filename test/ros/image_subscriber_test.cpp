// Images of one topic: when the plug-in of a transport is loaded, and subscribing again. What else an
// ImageSubscriber does is tested by image_source_test.cpp.

#include "ros/live/image_subscriber.h"

#include <gtest/gtest.h>
#include <link.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/Image.h>

#include <boost/make_shared.hpp>
#include <cstddef>
#include <string>

#include "wait_for.h"

namespace corrsel {
namespace {

/// Whether this process has loaded the library of image_transport's own plug-ins.
bool pluginsAreLoaded() {
  const auto is_it = [](dl_phdr_info* library, std::size_t, void*) {
    return std::string(library->dlpi_name).find("libimage_transport_plugins") != std::string::npos ? 1 : 0;
  };
  return dl_iterate_phdr(is_it, nullptr) != 0;
}

// One test, because the library stays in the process once it has been loaded.
TEST(ImageSubscriber, LoadsItsPluginBeforeItSubscribes) {
  ros::NodeHandle nh;
  ros::CallbackQueue queue;
  nh.setCallbackQueue(&queue);
  const ros::Publisher publisher = nh.advertise<sensor_msgs::Image>("image", 10);
  ASSERT_FALSE(pluginsAreLoaded());

  std::size_t received = 0;
  const auto count = [&received](const sensor_msgs::ImageConstPtr&) { ++received; };
  ImageSubscriber images(nh, ros::NodeHandle("~"), "raw", "image", 10, count);
  EXPECT_TRUE(pluginsAreLoaded());
  EXPECT_EQ(publisher.getNumSubscribers(), 0u);
  EXPECT_EQ(images.publishers(), 0u);

  for (std::size_t round = 1; round <= 3; ++round) {
    images.subscribe();
    ASSERT_TRUE(testing::waitFor(
        queue, [&] { return publisher.getNumSubscribers() == 1 && images.publishers() == 1; }));
    publisher.publish(boost::make_shared<sensor_msgs::Image>());
    EXPECT_TRUE(testing::waitFor(queue, [&] { return received == round; }));
    images.unsubscribe();
    EXPECT_TRUE(testing::waitFor(queue, [&] { return publisher.getNumSubscribers() == 0; }));
    EXPECT_EQ(images.publishers(), 0u);
  }
}

TEST(ImageSubscriber, ATransportThatCannotBeLoadedIsAnError) {
  EXPECT_THROW(ImageSubscriber(ros::NodeHandle(), ros::NodeHandle("~"), "carrier_pigeon", "image", 1, {}),
               pluginlib::PluginlibException);
}

}  // namespace
}  // namespace corrsel

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "image_subscriber_test");
  const ros::NodeHandle alive;  // the node must not shut down between tests
  return RUN_ALL_TESTS();
}
