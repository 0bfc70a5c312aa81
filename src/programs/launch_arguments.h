#pragma once

#include <string>
#include <vector>

namespace corrsel {

/// The arguments `name:=value` that a roslaunch command line gives to a launch file. roslaunch itself ignores
/// names that the file does not declare, and takes the last of several values.
/// @param words        of the command line, as in /proc/PID/cmdline
/// @param folder       where the command was started; relative paths begin there
/// @param package      that launch_file belongs to
/// @param launch_file  absolute path
/// @return empty where the command line does not start exactly this file: where another file includes it
/// (roslaunch refuses unknown names there), or where the program is not roslaunch Throws UsageError for a
/// name that the launch file does not declare (with the nearest and all valid ones), or that is given twice,
/// and std::invalid_argument where the launch file cannot be read.
std::vector<std::string> launchArguments(const std::vector<std::string>& words, const std::string& folder,
                                         const std::string& package, const std::string& launch_file);

}  // namespace corrsel
