#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "programs/command_line.h"
#include "programs/launch_arguments.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

class LaunchArguments : public ::testing::Test {
 protected:
  LaunchArguments() {
    fs::create_directories(folder_ / "launch");
    fs::create_directories(folder_ / "other");
    std::ofstream(file_) << "<launch>\n"
                            "  <!-- <arg name=\"commented\" default=\"\"/> -->\n"
                            "  <arg name=\"data_root\" default=\"\" doc=\"a\"/>\n"
                            "  <arg default='1' name='seed'/>\n"
                            "  <arg name=\"fixed\" value=\"2\"/>\n"
                            "  <include file=\"x\"><arg name=\"inner\" value=\"1\"/></include>\n"
                            "</launch>\n";
    std::ofstream(folder_ / "other" / "one.launch") << "<launch/>\n";
  }
  ~LaunchArguments() override { fs::remove_all(folder_); }

  Words given(const Words& words) const {
    return launchArguments(words, folder_.string(), "corrsel", file_.string());
  }

  std::string errorOf(const Words& arguments) const {
    Words words = {"/usr/bin/python3", "/usr/bin/roslaunch", "corrsel", "one.launch"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    try {
      given(words);
    } catch (const UsageError& error) {
      return error.what();
    }
    return "";
  }

  const fs::path folder_ =
      fs::temp_directory_path() / ("corrsel_launch_arguments_" + std::to_string(getpid()));
  const fs::path file_ = folder_ / "launch" / "one.launch";
};

TEST_F(LaunchArguments, UnknownOnesAreToldWithTheNearest) {
  EXPECT_EQ(errorOf({"dataroot:=/x"}),
            "unknown argument 'dataroot:=/x'; did you mean 'data_root'? valid: data_root, seed");
  EXPECT_EQ(errorOf({"seed:=1", "nonsense:="}), "unknown argument 'nonsense:='; valid: data_root, seed");
  // Comments, fixed values and arguments of included files cannot be set.
  for (const char* name : {"commented", "fixed", "inner"}) {
    EXPECT_EQ(errorOf({name + std::string(":=1")}).find("unknown argument '" + std::string(name)), 0U)
        << name;
  }
}

TEST_F(LaunchArguments, TwoValuesAreRefused) {
  EXPECT_EQ(errorOf({"seed:=1", "data_root:=a:=b", "seed:=2"}),
            "seed is given twice, as '1' and as '2'; give it once");
}

TEST_F(LaunchArguments, ValidOnesAreReturned) {
  for (const Words& start :
       {Words{"roslaunch", "corrsel", "one.launch"},
        Words{"python3", "/opt/ros/bin/roslaunch", "--screen", "-p", "11411", "corrsel", "one.launch"},
        Words{"roslaunch", "launch/one.launch"}, Words{"roslaunch", file_.string()}}) {
    Words words = start;
    words.insert(words.end(), {"seed:=3", "__name:=x", "_rate:=1", "--log", "data_root:=/a b"});
    EXPECT_EQ(given(words), (Words{"seed:=3", "data_root:=/a b"})) << start.back();
    words.emplace_back("sed:=1");
    EXPECT_THROW(given(words), UsageError) << start.back();
  }
}

TEST_F(LaunchArguments, ArgumentsOfOtherFilesAreNotChecked) {
  for (const Words& words : {
           Words{"roslaunch", "my_robot", "one.launch",
                 "camera:=a"},  // a file of the same name that includes it
           Words{"roslaunch", "other/one.launch", "camera:=a"},
           Words{"roslaunch", "corrsel", "two.launch", "camera:=a"},
           Words{"roslaunch", "launch/one.launch", "two.launch", "camera:=a"},  // arguments go to both
           Words{"/usr/bin/rostest", "corrsel", "one.launch", "camera:=a"},
           Words{"python3", "start.py", "camera:=a"},
           Words{},
       }) {
    EXPECT_EQ(given(words), Words{});
  }
}

TEST_F(LaunchArguments, FilesThatCannotBeReadAreNamed) {
  EXPECT_THROW(launchArguments({}, "/", "corrsel", (folder_ / "none.launch").string()),
               std::invalid_argument);
}

}  // namespace
}  // namespace corrsel
