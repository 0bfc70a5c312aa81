#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "corrsel/ros/selector_plugins.h"
#include "corrsel/selectors/factory.h"
#include "test_paths.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

/// The entry of one class in a plug-in file.
std::string entry(const std::string& attributes) {
  return "<class " + attributes + " base_class_type=\"corrsel::Selector\"/>";
}

std::string library(const std::string& path, const std::string& classes) {
  return "<library path=\"" + path + "\">" + classes + "</library>";
}

const std::string kLibrary = "lib/libplugin_selectors";

std::string refusal(const std::string& spec, const core::OptionMap& options = {}) {
  try {
    core::createSelector(spec, options);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Packages of its own beside corrsel; the library of plugin_selectors.cpp is where catkin puts it.
class SelectorPlugins : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("corrsel_plugins_" + std::to_string(getpid()));
    fs::remove_all(root_);
    fs::create_directories(root_);
    setenv("ROS_HOME", (root_ / "ros_home").c_str(), 1);
    setenv("ROS_PACKAGE_PATH", (root_.string() + ":" + testing::sourceDir()).c_str(), 1);
    setenv("CMAKE_PREFIX_PATH", testing::develDir().c_str(), 1);
    std::string classes;
    for (const char* name : {"All", "Wrapping", "ThrowsError", "ThrowsNumber"}) {
      classes +=
          entry("name=\"test_selectors/" + std::string(name) + "\" type=\"corrsel::testing::" + name + "\"");
    }
    addPackage("test_selectors", library(kLibrary, classes));
    enableSelectorPlugins();
  }
  void TearDown() override {
    core::setSelectorLoader({});
    fs::remove_all(root_);
  }

  /// @return its plug-in file
  std::string addPackage(const std::string& name, const std::string& plugins) const {
    fs::create_directories(root_ / name);
    std::ofstream(root_ / name / "package.xml")
        << "<package format=\"2\"><name>" << name
        << "</name><version>1.0.0</version><description>-</description>"
        << "<maintainer email=\"a@b.example\">a</maintainer><license>BSD</license><depend>corrsel</depend>"
        << "<export><corrsel plugin=\"${prefix}/plugins.xml\"/></export></package>";
    std::ofstream(root_ / name / "plugins.xml") << plugins;
    return (root_ / name / "plugins.xml").string();
  }

  fs::path root_;
};

TEST_F(SelectorPlugins, FindsMakesAndListsThem) {
  EXPECT_EQ(selectorPlugins(),
            (std::vector<std::string>{"test_selectors/All", "test_selectors/ThrowsError",
                                      "test_selectors/ThrowsNumber", "test_selectors/Wrapping"}));
  EXPECT_TRUE(selectorPluginProblems().empty());
  core::Correspondences matches;
  matches.add({1, 2}, {3, 4});
  for (const char* name : {"test_selectors/All", "test_selectors/Wrapping"}) {
    const auto selector = core::createSelector(name, {{"seed", "7"}});
    EXPECT_EQ(core::listOptions(selector->options()).at(0).value, "7");
    EXPECT_EQ(selector->select(matches).n_selected, 1u);
  }
  EXPECT_EQ(refusal("test_selectors/All", {{"sead", "7"}}),
            "unknown option test_selectors/All.sead; did you mean 'seed'? valid: seed");
}

TEST_F(SelectorPlugins, ThoseOfCorrselHaveShortNames) {
  for (const std::string name : {"lap", "tlinkage:motions", "corrsel/lap"}) {
    const std::string own = name == "corrsel/lap" ? "lap" : name.substr(0, name.find(':'));
    EXPECT_EQ(core::createSelector(name)->name(), own);
  }
  const std::string text = refusal("lap", {{"lamda", "1"}});
  EXPECT_NE(text.find("unknown option lap.lamda; did you mean 'lambda'"), std::string::npos) << text;
}

TEST_F(SelectorPlugins, BadOnesAreErrorsOnly) {
  EXPECT_EQ(refusal("test_selectors/ThrowsError"), "test_selectors/ThrowsError: no licence");
  EXPECT_EQ(refusal("test_selectors/ThrowsNumber"),
            "test_selectors/ThrowsNumber: its class threw something that is not a std::exception");
}

TEST_F(SelectorPlugins, UnknownOnesListTheKnown) {
  EXPECT_EQ(refusal("test_selectors/Al"),
            "unknown selector 'test_selectors/Al'; did you mean 'test_selectors/All'? selectors of other "
            "packages: test_selectors/All, "
            "test_selectors/ThrowsError, test_selectors/ThrowsNumber, test_selectors/Wrapping");
}

TEST_F(SelectorPlugins, SeesPackagesThatAppearLater) {
  EXPECT_TRUE(contains(refusal("later/All"), "unknown selector 'later/All'"));
  addPackage("later", library(kLibrary, entry("name=\"later/All\" type=\"corrsel::testing::All\"")));
  EXPECT_EQ(core::createSelector("later/All")->name(), "test_selectors/All");
}

TEST_F(SelectorPlugins, SaysWhatIsMissing) {
  const std::string not_built =
      addPackage("not_built", library("lib/libnot_built", entry("name=\"not_built/A\" type=\"A\"")));
  std::string text = refusal("not_built/A");
  EXPECT_TRUE(contains(text, "selector 'not_built/A' is declared in " + not_built +
                                 ", but its library cannot be loaded: build that package and source"))
      << text;
  // pluginlib's own reason follows. Old versions do not name the file.
  EXPECT_TRUE(contains(text, "ibrary corresponding to plugin not_built/A") || contains(text, "libnot_built"))
      << text;

  const std::string no_library =
      addPackage("bad", library("lib/libbad_file", entry("name=\"bad/A\" type=\"A\"")));
  fs::create_directories(root_ / "prefix" / "lib");
  std::ofstream(root_ / "prefix" / "lib" / "libbad_file.so") << "no library";
  setenv("CMAKE_PREFIX_PATH", (root_ / "prefix").c_str(), 1);
  text = refusal("bad/A");
  EXPECT_TRUE(contains(text, no_library) && contains(text, "libbad_file.so")) << text;

  setenv("CMAKE_PREFIX_PATH", testing::develDir().c_str(), 1);
  addPackage("other_type", library(kLibrary, entry("name=\"other_type/A\" type=\"corrsel::testing::Any\"")));
  text = refusal("other_type/A");
  EXPECT_TRUE(contains(text, "PLUGINLIB_EXPORT_CLASS") && contains(text, "corrsel::testing::Any")) << text;
}

TEST_F(SelectorPlugins, LeavesOutWhatItCannotOffer) {
  const std::string all = "type=\"corrsel::testing::All\"";
  const std::string no_path =
      addPackage("no_path", "<library>" + entry("name=\"no_path/A\" " + all) + "</library>");
  const std::string no_xml = addPackage("no_xml", "<library");
  const std::string other_root = addPackage("other_root", "<plugins/>");
  const std::string no_type = addPackage("no_type", library(kLibrary, entry("name=\"no_type/A\"")));
  const std::string no_file = addPackage("no_file", "");
  fs::remove(no_file);
  const std::string names = addPackage(
      "names",
      "<class_libraries>" +
          library(kLibrary, entry("name=\"All\" " + all) + entry(all) + entry("name=\"names/A:b\" " + all) +
                                entry("name=\"names/a/b\" " + all) + entry("name=\"names/\" " + all)) +
          library(kLibrary, entry("name=\"names/Good\" " + all) +
                                "<class name=\"names/Nodelet\" type=\"A\" base_class_type=\"nodelet::"
                                "Nodelet\"/>") +
          "</class_libraries>");
  const std::string first = addPackage("first", library(kLibrary, entry("name=\"twice/A\" " + all)));
  const std::string second = addPackage("second", library(kLibrary, entry("name=\"twice/A\" " + all)));
  const std::string third = addPackage(
      "third", library(kLibrary, entry("name=\"third/A\" " + all) + entry("name=\"third/A\" " + all)));

  const std::vector<std::string> offered = selectorPlugins();
  EXPECT_EQ(offered,
            (std::vector<std::string>{"names/Good", "test_selectors/All", "test_selectors/ThrowsError",
                                      "test_selectors/ThrowsNumber", "test_selectors/Wrapping"}));
  std::string problems;
  for (const std::string& problem : selectorPluginProblems()) problems += problem + "\n";
  for (const std::string& expected :
       {no_path + ": a library has no 'path'", no_xml + " is missing or no XML",
        other_root + ": the outermost element must be", no_type + ": a class has no 'type'",
        no_file + " is missing or no XML", "'All' in " + names + " is left out",
        "'corrsel::testing::All' in " + names + " is left out", "'names/A:b' in " + names + " is left out",
        "'names/a/b' in " + names + " is left out", "'names/' in " + names + " is left out",
        "'twice/A' is left out: it is declared in " + first + " and in " + second,
        "'third/A' is left out: it is declared twice in " + third}) {
    EXPECT_TRUE(contains(problems, expected)) << expected << "\nnot in:\n" << problems;
  }
  // Who asks for one of them learns why it is not there, and the good ones work on.
  EXPECT_TRUE(contains(refusal("twice/A"), first + " and in " + second));
  EXPECT_EQ(core::createSelector("names/Good")->name(), "test_selectors/All");
}

TEST_F(SelectorPlugins, WorksFromManyThreads) {
  std::vector<std::thread> threads;
  std::atomic<int> selected{0};
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&selected, t] {
      core::Correspondences matches;
      matches.add({1, 2}, {3, 4});
      for (int k = 0; k < 50; ++k) {
        enableSelectorPlugins();
        const auto selector = core::createSelector(k % 2 ? "test_selectors/All" : "test_selectors/Wrapping");
        selected += static_cast<int>(selector->select(matches).n_selected);
        if (t == 0 && k % 25 == 0) selectorPlugins();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(selected, 200);
}

/// Ended after main(): its code must still be there.
std::unique_ptr<core::Selector> last;

TEST_F(SelectorPlugins, SelectorsMayOutliveEverythingElse) {
  last = core::createSelector("test_selectors/Wrapping");
}

}  // namespace
}  // namespace corrsel
