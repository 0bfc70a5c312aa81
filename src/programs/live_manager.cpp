// A nodelet manager that begins with nodelets in it: one process, no loaders, so that one respawn brings
// everything back within a second or two. With loaders it takes until their bonds have noticed the death of
// the manager, and bond_core never notices one that dies between the first and the second heartbeat.

#include <nodelet/loader.h>
#include <ros/ros.h>

#include <iostream>
#include <string>
#include <vector>

int main(int argc, char** argv) {
  ros::init(argc, argv, "corrsel_manager");
  std::vector<std::string> arguments;
  ros::removeROSArgs(argc, argv, arguments);

  nodelet::Loader loader;  // with the services of every manager: load_nodelet, unload_nodelet, list
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    const std::size_t equals = arguments[i].find('=');
    if (equals == std::string::npos || equals == 0) {
      std::cerr << "'" << arguments[i]
                << "' does not read as NAME=PACKAGE/CLASS, e.g. selector=corrsel/Selector\n";
      return 2;
    }
    const std::string name = ros::names::resolve(arguments[i].substr(0, equals)),
                      type = arguments[i].substr(equals + 1);
    if (!loader.load(name, type, {}, {})) {
      ROS_FATAL_STREAM("cannot load the nodelet "
                       << type << " as " << name
                       << ". The lines above give the reason, unless its start threw an exception: the "
                          "library of nodelets does not log those.");
      return 1;
    }
  }
  ros::spin();
  return 0;
}
