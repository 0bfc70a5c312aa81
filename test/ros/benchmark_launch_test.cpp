// The programs as users start them: make_dataset_bag, benchmark with and without roslaunch, exit codes and
// folders.

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "base/text.h"
#include "benchmark/tables.h"
#include "corrsel/Progress.h"
#include "corrsel/Score.h"
#include "corrsel/random.h"
#include "corrsel/selectors/factory.h"
#include "shell.h"
#include "test_paths.h"

namespace corrsel {
namespace {

using testing::Output;
using testing::shell;

// Every selector, and every one but nnsr after nnsr.
std::size_t selections() { return 2 * core::usualSelectorNames().size() - 1; }

namespace fs = std::filesystem;

std::string readAll(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// pairs.csv without its time columns.
std::vector<std::string> timelessRows(const fs::path& folder) {
  std::vector<std::string> rows;
  const fs::path file = folder / "pairs.csv";
  if (!fs::exists(file) || fs::is_empty(file)) return rows;  // the run is about to write it
  const std::size_t first_time = core::pairsTableIn(file.string()).indexOf("detect_s");
  std::ifstream in(file);
  std::string format;
  std::getline(in, format);
  for (std::string line; std::getline(in, line);) {
    std::vector<std::string> fields = core::parseCsvLine(line);
    fields.resize(first_time);
    rows.push_back(core::joinList(fields, ","));
  }
  return rows;
}

class BenchmarkLaunch : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    root_ = fs::temp_directory_path() / ("corrsel_launch_" + std::to_string(getpid()));
    fs::remove_all(root_);
    fs::create_directories(root_ / "data");
    writeScene("data", "one");
    setenv("XDG_CACHE_HOME", (root_ / "cache").c_str(), 1);
    setenv("ROS_HOME", (root_ / "ros_home").c_str(), 1);
  }
  static void TearDownTestSuite() { fs::remove_all(root_); }

  /// A scene in the form of the VGG dataset: six images, five homographies.
  static void writeScene(const std::string& data_root, const std::string& name, std::uint64_t seed = 3) {
    const fs::path folder = root_ / data_root / "vgg" / name;
    fs::create_directories(folder);
    core::Random random(seed);
    cv::Mat image(240, 320, CV_8UC3, cv::Scalar::all(40));
    for (int k = 0; k < 200; ++k) {
      const auto y = static_cast<int>(random.index(240)), x = static_cast<int>(random.index(320));
      const double red = random.uniform(60, 255), green = random.uniform(60, 255),
                   blue = random.uniform(60, 255);
      const int radius = 2 + static_cast<int>(random.index(9));
      cv::circle(image, {x, y}, radius, cv::Scalar(blue, green, red), -1);
    }
    cv::imwrite((folder / "img1.ppm").string(), image);
    for (int k = 2; k <= 6; ++k) {
      const cv::Matx33d h(1 - 0.01 * k, 0.01 * k, 2.0 * k, -0.01 * k, 1, 3.0 * k, 0, 0, 1);
      cv::Mat warped;
      cv::warpPerspective(image, warped, h, image.size());
      cv::imwrite((folder / ("img" + std::to_string(k) + ".ppm")).string(), warped);
      std::ofstream out(folder / ("H1to" + std::to_string(k) + "p"));
      for (int row = 0; row < 3; ++row) out << h(row, 0) << " " << h(row, 1) << " " << h(row, 2) << "\n";
    }
  }

  /// The benchmark on the scene of the test, unless the arguments name other data.
  static std::string benchmark(const std::string& arguments) {
    const auto unless = [&arguments](const std::string& name, const std::string& value) {
      return arguments.find(name) == std::string::npos ? name + " " + value + " " : "";
    };
    return "rosrun corrsel benchmark " + unless("--dataset", "vgg") +
           unless("--data_root", (root_ / "data").string()) + arguments;
  }

  static fs::path root_;
};

fs::path BenchmarkLaunch::root_;

TEST_F(BenchmarkLaunch, LaunchWritesACompleteFolderAndPublishes) {
  ros::NodeHandle node;
  std::atomic<int> scores{0};
  std::atomic<bool> finished{false};
  const auto on_score = [&scores](const ScoreConstPtr& score) {
    if (!score->selector.empty() && score->dataset == "vgg") ++scores;
  };
  const auto on_progress = [&finished](const ProgressConstPtr& progress) {
    if (progress->state == "finished" && progress->pairs_done == 5) finished = true;
  };
  const ros::Subscriber score = node.subscribe<Score>("/benchmark/score", 10000, on_score);
  const ros::Subscriber progress = node.subscribe<Progress>("/benchmark/progress", 1000, on_progress);
  ros::AsyncSpinner spinner(1);
  spinner.start();
  const fs::path run = root_ / "launched";
  // Relative paths start from where the user is, not from ROS_HOME, where roslaunch starts nodes.
  const Output output =
      shell("cd " + root_.string() +
            " && roslaunch corrsel benchmark.launch dataset:=vgg data_root:=data output_dir:=launched");
  EXPECT_NE(output.text.find("Highest mean F in percent (tau = 5 px)"), std::string::npos) << output.text;
  EXPECT_NE(output.text.find("vgg, orb+orb, after nnsr  "), std::string::npos) << output.text;
  EXPECT_EQ(output.text.find("median ms"), std::string::npos) << output.text;
  EXPECT_NE(output.text.find("report.py --all --no-page " + run.string()), std::string::npos) << output.text;
  EXPECT_NE(output.text.find("report.html"), std::string::npos) << output.text;
  for (const char* file : {"config.yaml", "environment.json", "pairs.csv", "summary.csv", "summary.json",
                           "report.html", "failures.csv", "images/index.csv"}) {
    EXPECT_TRUE(fs::exists(run / file)) << file;
  }
  EXPECT_NE(readAll(run / "summary.json").find("\"complete\": true"), std::string::npos);
  // 5 pairs x 2 features x selections().
  EXPECT_EQ(timelessRows(run).size(), 1U + 5 * 2 * selections());
  EXPECT_EQ(scores, static_cast<int>(5 * 2 * selections()));
  EXPECT_TRUE(finished);
}

TEST_F(BenchmarkLaunch, LaunchFilesRefuseWhatTheyDoNotDeclare) {
  struct Case {
    std::string arguments, error;
  };
  const std::vector<Case> cases = {
      {"benchmark.launch dataroot:=/x",
       "benchmark.launch: unknown argument 'dataroot:=/x'; did you mean 'data_root'?"},
      {"benchmark.launch seed:=1 seed:=2",
       "benchmark.launch: seed is given twice, as '1' and as '2'; give it once"},
      {"live.launch left_imge:=/cam/left",
       "live.launch: unknown argument 'left_imge:=/cam/left'; did you mean 'left_image'?"},
      {"sequence.launch imag:=/cam", "sequence.launch: unknown argument 'imag:=/cam'; did you mean 'image'?"},
      {"replay.launch bga:=/x.bag", "replay.launch: unknown argument 'bga:=/x.bag'; did you mean 'bag'?"},
      {"view.launch titel:=x", "view.launch: unknown argument 'titel:=x'; did you mean 'title'?"},
  };
  for (const Case& c : cases) {
    const Output output = shell("roslaunch corrsel " + c.arguments);
    EXPECT_EQ(output.code, 1) << output.text;
    EXPECT_NE(output.text.find(c.error), std::string::npos) << output.text;
    EXPECT_EQ(output.text.find("started with pid"), std::string::npos) << output.text;
  }
  // Where another file includes one of these, the arguments of the command line are its own.
  std::ofstream(root_ / "view.launch")
      << "<launch>\n  <arg name=\"camera\"/>\n  <include file=\"$(find corrsel)/launch/"
         "view.launch\" pass_all_args=\"true\"/>\n</launch>\n";
  const Output included = shell("roslaunch --nodes " + (root_ / "view.launch").string() + " camera:=/cam");
  EXPECT_EQ(included.code, 0) << included.text;
  EXPECT_NE(included.text.find("/match_view"), std::string::npos) << included.text;
}

TEST_F(BenchmarkLaunch, TheSecondOneUnderAMasterTakesAnotherName) {
  const auto is_registered = [](const std::string& name) {
    ros::V_string nodes;
    ros::master::getNodes(nodes);
    return std::find(nodes.begin(), nodes.end(), name) != nodes.end();
  };
  const std::string first_run = (root_ / "named_first").string();
  Output first;
  std::thread runner([&] {
    first = shell("exec " + benchmark("--report false --repetitions 1000 --output_dir " + first_run));
  });
  for (int k = 0; k < 6000 && !is_registered("/benchmark"); ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const std::string note =
      "note: another node is called /benchmark, so this one is called /benchmark_2 and publishes "
      "/benchmark_2/progress and /benchmark_2/score";
  const auto common = [](const std::string& name) {
    return "--report false --features orb+orb --selectors gms --output_dir " + (root_ / name).string();
  };
  const Output second = shell(benchmark(common("named_second")));
  EXPECT_EQ(second.code, 0) << second.text;
  EXPECT_NE(second.text.find(note), std::string::npos) << second.text;
  // roslaunch gives it the name of the first one.
  const Output launched = shell(
      "roslaunch corrsel benchmark.launch dataset:=vgg report:=false features:=orb+orb selectors:=gms "
      "data_root:=" +
      (root_ / "data").string() + " output_dir:=" + (root_ / "named_launched").string());
  EXPECT_NE(launched.text.find(note), std::string::npos) << launched.text;
  EXPECT_TRUE(fs::exists(root_ / "named_launched" / "summary.json")) << launched.text;
  const Output chosen = shell(benchmark(common("named_chosen") + " __name:=mine"));
  EXPECT_EQ(chosen.code, 0) << chosen.text;
  EXPECT_EQ(chosen.text.find("this one is called"), std::string::npos) << chosen.text;
  // The first one is at work all the time, under its name.
  EXPECT_TRUE(is_registered("/benchmark"));
  shell("pkill -INT -f -- 'benchmark .*--output_dir " + first_run + "'");
  runner.join();
  EXPECT_EQ(first.code, 130) << first.text;
  const Output next = shell(benchmark(common("named_next")));
  EXPECT_EQ(next.text.find("this one is called"), std::string::npos) << next.text;
}

TEST_F(BenchmarkLaunch, ACrashedOneLeavesItsNameFree) {
  const std::string run = (root_ / "crashed").string();
  std::thread killer([&run] {
    for (int k = 0; k < 3000 && timelessRows(run).size() < 2; ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    shell("pkill -KILL -f -- '--output_dir " + run + "'");
  });
  EXPECT_NE(shell("exec " + benchmark("--report false --output_dir " + run)).code, 0);
  killer.join();
  const Output nodes = shell("rosnode list");
  ASSERT_NE(nodes.text.find("/benchmark\n"), std::string::npos) << nodes.text;
  const Output next =
      shell(benchmark("--report false --features orb+orb --selectors gms --output_dir " + run + "_next"));
  EXPECT_EQ(next.code, 0) << next.text;
  EXPECT_EQ(next.text.find("this one is called"), std::string::npos) << next.text;
}

TEST_F(BenchmarkLaunch, WhatLimitsTheComparisonIsPrintedWithTheWinners) {
  const fs::path pairs = root_ / "odd" / "pairs", scene = root_ / "data" / "vgg" / "one",
                 run = root_ / "odd_run";
  const cv::Mat left = cv::imread((scene / "img1.ppm").string(), cv::IMREAD_GRAYSCALE),
                right = cv::imread((scene / "img2.ppm").string(), cv::IMREAD_GRAYSCALE);
  for (const char* name : {"deep", "blank_left", "blank_right", "good", "broken"}) {
    const fs::path folder = pairs / name;
    fs::create_directories(folder);
    for (const auto& [image, side] :
         {std::pair{left, std::string("left")}, std::pair{right, std::string("right")}}) {
      cv::Mat stored = image.clone();
      if (name == "blank_" + side) stored.setTo(50);
      if (name == std::string("deep")) stored.convertTo(stored, CV_16U, 16);
      cv::imwrite((folder / (side + ".png")).string(), stored);
    }
    std::ofstream out(folder / "H.txt");
    if (name != std::string("broken")) out << readAll(scene / "H1to2p");
  }
  const std::string command = "rosrun corrsel benchmark --dataset pairs --data_root " +
                              (root_ / "odd").string() +
                              " --features orb+orb --preselection none --report false --options "
                              "orb.max_megapixels=0.05 --output_dir " +
                              run.string();
  const Output output = shell(command);
  EXPECT_EQ(output.code, 1) << output.text;
  const auto occurrences = [&output](const std::string& part) {
    std::size_t count = 0;
    for (std::size_t at = 0; (at = output.text.find(part, at)) != std::string::npos; ++at) ++count;
    return count;
  };
  EXPECT_EQ(
      occurrences("pairs, orb+orb: 3 of 5 pairs are not in the means: 1 has no features in the left image, 1 "
                  "has no features in the right image, 1 failed (failures.csv)."),
      1U)
      << output.text;
  // When it is noticed, and below the winners.
  EXPECT_EQ(occurrences("images of 16 bits that use 12 of them (values up to "), 2U) << output.text;
  EXPECT_GT(occurrences((pairs / "deep").string()), 0U) << output.text;
  EXPECT_EQ(occurrences("large images are reduced before the features orb+orb are found in them: "), 2U)
      << output.text;
  // The bag is in the cache now; the remark on its images is made again.
  const Output again = shell("rm -r " + run.string() + "; " + command + " --verbose true");
  EXPECT_NE(again.text.find("note: pairs: images of 16 bits"), std::string::npos) << again.text;
  EXPECT_NE(again.text.find("pairs, orb+orb, no preselection, tau = 5 px"), std::string::npos) << again.text;
  EXPECT_NE(again.text.find("median ms"), std::string::npos) << again.text;
}

TEST_F(BenchmarkLaunch, WithoutMasterDeterministicForAnyThreads) {
  const std::string no_master = "ROS_MASTER_URI=http://localhost:1 ";
  const std::string common = "--report false --features orb+orb --output_dir ";
  const Output one = shell(no_master + benchmark("--threads 1 " + common + (root_ / "t1").string()));
  const Output two = shell(no_master + benchmark("--threads 2 " + common + (root_ / "t2").string()));
  EXPECT_EQ(one.code, 0) << one.text;
  EXPECT_EQ(two.code, 0) << two.text;
  EXPECT_EQ(timelessRows(root_ / "t1").size(), 1U + 5 * selections());
  EXPECT_EQ(timelessRows(root_ / "t1"), timelessRows(root_ / "t2"));
}

TEST_F(BenchmarkLaunch, KilledAndResumedEqualsUncut) {
  const std::string common = "--report false --output_dir ";
  ASSERT_EQ(shell(benchmark(common + (root_ / "uncut").string())).code, 0);
  const fs::path cut = root_ / "cut";
  std::thread killer([&cut] {
    // SIGKILL as soon as the first pairs are on disk.
    for (int k = 0; k < 3000 && timelessRows(cut).size() < 100; ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    shell("pkill -KILL -f -- '--output_dir " + cut.string() + "'");
  });
  const Output killed = shell("exec " + benchmark(common + cut.string()));
  killer.join();
  EXPECT_NE(killed.code, 0);
  const std::size_t before = timelessRows(cut).size();
  EXPECT_GT(before, 1U);
  EXPECT_LT(before, timelessRows(root_ / "uncut").size());
  const Output resumed = shell(benchmark("--resume true " + common + cut.string()));
  EXPECT_EQ(resumed.code, 0) << resumed.text;
  EXPECT_EQ(timelessRows(cut), timelessRows(root_ / "uncut"));
}

TEST_F(BenchmarkLaunch, CtrlCLeavesValidFiles) {
  const fs::path run = root_ / "interrupted";
  std::thread interrupter([&run] {
    for (int k = 0; k < 3000 && timelessRows(run).size() < 100; ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    shell("pkill -INT -f -- 'benchmark .*--output_dir " + run.string() + "'");
  });
  const Output output = shell("exec " + benchmark("--report false --output_dir " + run.string()));
  interrupter.join();
  EXPECT_EQ(output.code, 130) << output.text;
  EXPECT_NE(output.text.find("resume:=true"), std::string::npos) << output.text;
  EXPECT_NE(readAll(run / "summary.json").find("\"interrupted\": true"), std::string::npos);
}

TEST_F(BenchmarkLaunch, BadArgumentsAreNamed) {
  struct Case {
    std::string arguments;
    std::vector<std::string> parts;
  };
  const std::vector<Case> cases = {
      {"--selectors magic", {"'magic'", "gms", "lpm"}},
      {"--selectors gsm", {"unknown selector 'gsm'; did you mean 'gms'?"}},
      {"--selectors lpm:v9", {"'v9'", "v2"}},
      {"--features sift", {"unknown features 'sift'; did you mean 'sift+sift'?"}},
      {"--experiment papre", {"unknown experiment 'papre'; did you mean 'paper'?"}},
      {"--features surf+surf", {"'surf+surf'", "orb+orb"}},
      {"--dataset imagenet", {"'imagenet'", "adelaidermf"}},
      {"--options gms.alpha=-3", {"alpha = -3", "[0, 100]"}},
      {"--options gms.alpa=3", {"unknown option gms.alpa; did you mean 'alpha'?"}},
      {"--options gms.alpha=3,gms.alpha=4", {"gms.alpha is given twice, as '3' and as '4'; give it once"}},
      {"--tolerances 1,x", {"tolerances", "'x'"}},
      {"--tolerances 0", {"tolerances: 0 px is outside (0, 1000] px; each must be above 0"}},
      {"--tolerances nan", {"tolerances: 'nan' is not a number"}},
      {"--tolerances 2,2", {"tolerances: 2 px is given twice; give it once"}},
      {"--tolerances 2,1", {"tolerances: 1 px comes after 2 px; give them in ascending order"}},
      {"--tolerances ,", {"tolerances is empty"}},
      {"--threads -1", {"threads = -1 is outside [0, 1024]"}},
      {"--threads 1e10", {"--threads: '1e10' is not a whole number in the range of int"}},
      {"--repetitions 0", {"repetitions = 0 is outside [1, 1000]"}},
      {"--ground_truth_tolerance inf", {"ground_truth_tolerance = inf is outside [0, 1000]"}},
      {"--max_pairs -1", {"max_pairs = -1 is outside"}},
      {"--seed ''", {"--seed: '' is not a number"}},
      {"--seed 1 --seed 2", {"--seed is given twice, as '1' and as '2'; give it once"}},
      {"seed:=1 --seed 2", {"--seed is given twice, as '1' and as '2'; give it once"}},
      {"--nonsense 1", {"'--nonsense'", "--data_root", "--help"}},
      {"dataroot:=/x", {"unknown argument 'dataroot:=/x'; did you mean '--data_root'?"}},
      {"--dataset vgf", {"unknown dataset 'vgf'", "did you mean 'vgg'?", "holds the folders vgg; known"}},
      {"--dataset hpatches", {"dataset 'hpatches'", "holds the folders vgg"}},
      {"--data_root " + (root_ / "data" / "vgg").string(), {"is a dataset itself"}},
      {"--experiment overall --dataset '' --data_root " + (root_ / "data" / "vgg").string(),
       {"none of the datasets of experiment 'overall'", "holds the folders one"}},
      {"--resume true", {"output_dir"}},
      {"--data_root /does/not/exist", {"/does/not/exist/vgg"}},
      {"--output_dir /proc/none", {"/proc/none", "output_dir"}},
  };
  for (const Case& c : cases) {
    const Output output = shell(benchmark(c.arguments));
    EXPECT_EQ(output.code, 2) << c.arguments << "\n" << output.text;
    for (const std::string& part : c.parts) {
      EXPECT_NE(output.text.find(part), std::string::npos) << c.arguments << "\n" << output.text;
    }
  }
}

TEST_F(BenchmarkLaunch, FolderOfAnotherConfigurationIsRefused) {
  const std::string common =
      "--report false --max_pairs 1 --features orb+orb --output_dir " + (root_ / "mine").string();
  ASSERT_EQ(shell(benchmark(common)).code, 0);
  const Output other = shell(benchmark("--seed 4 --resume true " + common));
  EXPECT_EQ(other.code, 2);
  EXPECT_NE(other.text.find("seed: '0' -> '4'"), std::string::npos) << other.text;
}

TEST_F(BenchmarkLaunch, HoleInTheDatasetIsNamedAndTheRestIsRun) {
  const fs::path data = root_ / "holed";
  fs::create_directories(data);
  fs::copy(root_ / "data" / "vgg", data / "vgg", fs::copy_options::recursive);
  fs::remove(data / "vgg" / "one" / "img4.ppm");
  const fs::path run = root_ / "holed_run";
  const Output output = shell(benchmark("--data_root " + data.string() +
                                        " --report false --features orb+orb --output_dir " + run.string()));
  EXPECT_EQ(output.code, 1) << output.text;
  EXPECT_NE(output.text.find("img4"), std::string::npos) << output.text;
  const std::string failures = readAll(run / "failures.csv");
  EXPECT_NE(failures.find("img4"), std::string::npos);
  EXPECT_NE(failures.find("vgg,one,1-4,"), std::string::npos) << failures;
  EXPECT_EQ(timelessRows(run).size(), 1U + 4 * selections());

  const fs::path bag = root_ / "holed.bag";
  const Output made = shell("rosrun corrsel make_dataset_bag --dataset vgg --path " +
                            (data / "vgg").string() + " --output " + bag.string());
  EXPECT_EQ(made.code, 1) << made.text;
  EXPECT_NE(made.text.find("4 of 5 pairs written"), std::string::npos) << made.text;
}

TEST_F(BenchmarkLaunch, BagsAreRunAndBrokenOnesRefused) {
  const fs::path bag = root_ / "one.bag";
  const Output made = shell("rosrun corrsel make_dataset_bag --compressed --dataset vgg --path " +
                            (root_ / "data" / "vgg").string() + " --output " + bag.string());
  ASSERT_EQ(made.code, 0) << made.text;
  const std::string start = "rosrun corrsel benchmark --report false --features orb+orb --bag ";
  const Output run = shell(start + bag.string() + " --output_dir " + (root_ / "bag_run").string());
  EXPECT_EQ(run.code, 0) << run.text;
  EXPECT_EQ(timelessRows(root_ / "bag_run").size(), 1U + 5 * selections());
  const Output info = shell("rosbag info " + bag.string());
  EXPECT_NE(info.text.find("corrsel/GroundTruth"), std::string::npos) << info.text;

  fs::resize_file(bag, fs::file_size(bag) / 2);
  const Output truncated = shell(start + bag.string() + " --output_dir " + (root_ / "truncated").string());
  EXPECT_EQ(truncated.code, 2) << truncated.text;
  EXPECT_NE(truncated.text.find("rosbag reindex"), std::string::npos) << truncated.text;
}

TEST_F(BenchmarkLaunch, PresetRunsItsCellsAndSaysSoInTheReport) {
  const fs::path run = root_ / "preset";
  const Output output =
      shell("rosrun corrsel benchmark experiment:=preselected dataset:=vgg features:=orb+orb data_root:=" +
            (root_ / "data").string() + " output_dir:=" + run.string());
  EXPECT_EQ(output.code, 0) << output.text;
  EXPECT_EQ(timelessRows(run).size(), 1U + 5 * selections());
  const std::string config = readAll(run / "config.yaml");
  EXPECT_NE(config.find("experiment: preselected"), std::string::npos) << config;
  EXPECT_NE(config.find("cells: [orb+orb/none, orb+orb/nnsr]"), std::string::npos) << config;
  EXPECT_NE(readAll(run / "report.html").find("After preselection"), std::string::npos);
  EXPECT_FALSE(fs::is_empty(run / "figures"));
  EXPECT_GT(readAll(run / "stages.csv").size(), 100U);
}

TEST_F(BenchmarkLaunch, PairsOfDifferentScenesAreRunMergedAndReported) {
  writeScene("scenes", "one");
  writeScene("scenes", "two", 4);
  const std::string common =
      "rosrun corrsel benchmark --experiment unrelated --dataset vgg --features orb+orb "
      "--selectors ransac,gms --tolerances 5 --max_pairs 4 --data_root " +
      (root_ / "scenes").string() + " --output_dir ";
  const fs::path whole = root_ / "unrelated", merged = root_ / "unrelated_merged";
  const Output output = shell(common + whole.string());
  EXPECT_EQ(output.code, 0) << output.text;
  std::map<std::string, std::size_t> rows;
  for (const std::string& line : timelessRows(whole)) ++rows[core::parseCsvLine(line)[0]];
  EXPECT_EQ(rows, (std::map<std::string, std::size_t>{
                      {"dataset", 1U}, {"vgg", 4U * 3}, {"unrelated_vgg", 4U * 3}}));
  const std::string report = readAll(whole / "report.html");
  EXPECT_NE(report.find("Pairs of different scenes, orb+orb."), std::string::npos);
  EXPECT_NE(report.find("unrelated_vgg (4 pairs)"), std::string::npos);

  std::string parts;
  for (const char* part : {"1", "2"}) {
    const fs::path folder = root_ / ("unrelated_part" + std::string(part));
    const Output shard = shell(common + folder.string() + " --report false --shard " + part + "/2");
    EXPECT_EQ(shard.code, 0) << shard.text;
    parts += (parts.empty() ? "" : ",") + folder.string();
  }
  const Output merge = shell(common + merged.string() + " --report false --merge " + parts);
  EXPECT_EQ(merge.code, 0) << merge.text;
  EXPECT_EQ(timelessRows(merged), timelessRows(whole));
}

TEST_F(BenchmarkLaunch, GuideIsPrintedAndSelectorsAreTimed) {
  const fs::path run = root_ / "guide";
  const Output output = shell(
      benchmark("--experiment guide --features orb+orb --max_pairs 1 --selectors nnsr,gms --output_dir " +
                run.string()));
  EXPECT_EQ(output.code, 0) << output.text;
  EXPECT_NE(output.text.find("Superior"), std::string::npos) << output.text;
  EXPECT_TRUE(fs::exists(run / "guide.csv"));
  std::ifstream in(run / "scaling.csv");
  std::size_t lines = 0;
  for (std::string line; std::getline(in, line); ++lines) EXPECT_EQ(core::parseCsvLine(line).size(), 7U);
  EXPECT_GE(lines, 1U + 3 * 5 * 10);
}

TEST_F(BenchmarkLaunch, ShardsMadeSideBySideMergeIntoTheUncutRun) {
  const std::string common = "--features orb+orb --output_dir ";
  ASSERT_EQ(shell(benchmark(common + (root_ / "one_run").string() + " --report false")).code, 0);
  std::string command;
  for (const char* part : {"1", "2", "3"}) {
    command += benchmark("--report false --shard " + std::string(part) + "/3 " + common +
                         (root_ / ("shard" + std::string(part))).string()) +
               " & ";
  }
  const Output shards = shell(command + "wait");
  std::string list;
  std::size_t pairs = 0;
  for (const char* part : {"3", "1", "2"}) {
    const fs::path folder = root_ / ("shard" + std::string(part));
    pairs += (timelessRows(folder).size() - 1) / selections();
    EXPECT_NE(readAll(folder / "summary.json").find("\"complete\": true"), std::string::npos) << shards.text;
    list += (list.empty() ? "" : ",") + folder.string();
  }
  EXPECT_EQ(pairs, 5U);
  const fs::path merged = root_ / "merged";
  const Output output = shell(benchmark("--merge " + list + " " + common + merged.string()));
  EXPECT_EQ(output.code, 0) << output.text;
  EXPECT_EQ(timelessRows(merged), timelessRows(root_ / "one_run"));
  const auto untimed = [](const fs::path& folder) {
    std::vector<std::string> rows;
    std::ifstream in(folder / "summary.csv");
    for (std::string line; std::getline(in, line);) {
      std::vector<std::string> fields = core::parseCsvLine(line);
      fields.resize(13);
      rows.push_back(core::joinList(fields, ","));
    }
    return rows;
  };
  EXPECT_EQ(untimed(merged), untimed(root_ / "one_run"));
  EXPECT_TRUE(fs::exists(merged / "report.html"));

  const Output refused = shell(benchmark("--seed 3 --report false --merge " + list + " " + common +
                                         (root_ / "merged_otherwise").string()));
  EXPECT_EQ(refused.code, 2) << refused.text;
  EXPECT_NE(refused.text.find("seed: '0' -> '3'"), std::string::npos) << refused.text;
  EXPECT_FALSE(fs::exists(root_ / "merged_otherwise"));
}

/// All files below a folder.
std::set<std::string> filesBelow(const fs::path& folder) {
  std::set<std::string> files;
  if (!fs::exists(folder)) return files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    files.insert(entry.path().string());
  }
  return files;
}

TEST_F(BenchmarkLaunch, DryRunTellsWhatTheRunWouldDoAndLeavesNothing) {
  const fs::path run = root_ / "dry", temporary = root_ / "dry_temporary";
  fs::create_directories(temporary);
  const std::string environment =
      "TMPDIR=" + temporary.string() + " XDG_CACHE_HOME=" + (root_ / "dry_cache").string() + " ";
  const std::string arguments =
      "--features orb+orb --tolerances 3,5 --repetitions 2 --output_dir " + run.string();
  const std::set<std::string> before = filesBelow(root_);
  const Output output = shell(environment + benchmark(arguments + " --dry_run"));
  EXPECT_EQ(output.code, 0) << output.text;
  EXPECT_EQ(filesBelow(root_), before);
  EXPECT_NE(output.text.find("vgg: found 1 sequence, 5 pairs, none of them broken"), std::string::npos)
      << output.text;
  EXPECT_NE(output.text.find("no problems were found"), std::string::npos) << output.text;
  std::istringstream lines(output.text);
  std::string name, pairs, made;
  for (std::string line; std::getline(lines, line) && name != "sum";) {
    std::istringstream(line) >> name >> pairs >> made;
  }
  EXPECT_EQ(pairs, "5");
  EXPECT_EQ(made, std::to_string(5 * selections() * 2));

  // The second of two parts has the pairs 2 and 4; roslaunch passes the argument on.
  const Output part =
      shell(environment + "roslaunch corrsel benchmark.launch dataset:=vgg features:=orb+orb data_root:=" +
            (root_ / "data").string() + " shard:=2/2 dry_run:=true output_dir:=" + run.string());
  EXPECT_TRUE(std::regex_search(part.text, std::regex("\nvgg +2 "))) << part.text;
  EXPECT_FALSE(fs::exists(run));
}

TEST_F(BenchmarkLaunch, DryRunCountsTheMatches) {
  const fs::path run = root_ / "dry_matches";
  /// Size of the folder, bytes.
  const auto folderWith = [&](const std::string& forms) {
    const Output output =
        shell(benchmark("--features orb+orb --preselection none --selectors gms --output_dir " +
                        run.string() + " --dry_run " + forms));
    EXPECT_EQ(output.code, 0) << output.text;
    std::smatch found;
    // pairs, selections, time and folder
    const std::regex line("\nvgg +5 +10 +[\\d:]+ +([\\d.]+) ([KM]?)i?B");
    if (!std::regex_search(output.text, found, line)) {
      ADD_FAILURE() << output.text;
      return 0.0;
    }
    const double unit = found[2] == "M" ? 1 << 20 : found[2] == "K" ? 1 << 10 : 1;
    return core::parseNumber(found[1], "folder") * unit;
  };
  const double without = folderWith(""), csv = folderWith("--save_matches csv");
  EXPECT_GT(csv, 2 * without);
  EXPECT_FALSE(fs::exists(run));
}

TEST_F(BenchmarkLaunch, DryRunPrintsEveryProblemOfTheData) {
  writeScene("faulty", "one");
  writeScene("faulty", "two", 4);
  const fs::path folder = root_ / "faulty" / "vgg" / "one", other = root_ / "faulty" / "vgg" / "two";
  fs::remove(folder / "img2.ppm");
  std::ofstream(folder / "img3.ppm") << "no image";
  std::ofstream(folder / "H1to4p") << "1 0 0 0 1 0 0 0";
  // Images and homographies of the other scene are good, but for one image of another size.
  cv::Mat image = cv::imread((other / "img5.ppm").string());
  cv::resize(image, image, {160, 120});
  cv::imwrite((other / "img5.ppm").string(), image);
  std::ofstream(folder / "H1to6p") << "1 0 5000 0 1 0 0 0 1";
  const fs::path run = root_ / "dry_faulty";
  const Output output =
      shell("rosrun corrsel benchmark dataset:=vgg features:=orb+orb selectors:=gms data_root:=" +
            (root_ / "faulty").string() + " dry_run:=true output_dir:=" + run.string());
  EXPECT_EQ(output.code, 1) << output.text;
  EXPECT_FALSE(fs::exists(run));
  for (const std::string& expected :
       {"broken: vgg/one/1-2: " + (folder / "img2").string() + ": the image is missing",
        "broken: vgg/one/1-3: " + (folder / "img3.ppm").string() + ": the image cannot be decoded",
        "broken: vgg/one/1-4: " + (folder / "H1to4p").string() + ": holds 8 numbers where a homography has 9",
        std::string("odd: vgg/one/1-6: the homography maps 0 % of the left image into the right one"),
        std::string("odd: vgg/two/1-5: the right image has 160x120 px"),
        std::string("\n5 problems, see above")}) {
    EXPECT_NE(output.text.find(expected), std::string::npos) << expected << "\nis not in:\n" << output.text;
  }
  const Output missing =
      shell("rosrun corrsel benchmark dataset:=vgg,symbench data_root:=" + (root_ / "data").string() +
            " features:=orb+orb selectors:=gms dry_run:=true");
  EXPECT_EQ(missing.code, 2) << missing.text;
  EXPECT_NE(missing.text.find("unusable: "), std::string::npos) << missing.text;
  EXPECT_NE(missing.text.find("vgg: found 1 sequence"), std::string::npos) << missing.text;
}

TEST_F(BenchmarkLaunch, NamesAreTextNotPathsOrMarkup) {
  const std::string dataset = "my <b>set & \"co", scene = "s, 'one' <em>";
  const fs::path data = root_ / "evil";
  fs::create_directories(data / dataset);
  fs::copy(root_ / "data" / "vgg" / "one", data / dataset / scene, fs::copy_options::recursive);
  const fs::path outer = root_ / "evil_out";
  const Output output =
      shell("rosrun corrsel benchmark --max_pairs 1 --features orb+orb --data_root " + data.string() +
            " --dataset '" + dataset + "' --output_dir " + (outer / "run").string());
  EXPECT_EQ(output.code, 0) << output.text;
  EXPECT_FALSE(core::readResults((outer / "run").string()).empty());
  const std::string report = readAll(outer / "run" / "report.html");
  EXPECT_EQ(report.find("<b>set"), std::string::npos);
  EXPECT_EQ(report.find("<em>"), std::string::npos);
  EXPECT_NE(report.find("my &lt;b&gt;set &amp; &#34;co"), std::string::npos);
  std::size_t beside = 0;
  for (const auto& entry : fs::directory_iterator(outer)) beside += entry.path().filename() != "run";
  EXPECT_EQ(beside, 0U);

  const Output path = shell("rosrun corrsel benchmark --data_root " + data.string() + " --dataset ../data");
  EXPECT_EQ(path.code, 2) << path.text;
  EXPECT_NE(path.text.find("'../data'"), std::string::npos) << path.text;
}

TEST_F(BenchmarkLaunch, OwnBagWithoutTheNamedTopicsListsWhatItHas) {
  const fs::path bag = root_ / "own.bag";
  ASSERT_EQ(shell("rosrun corrsel make_dataset_bag --dataset vgg --path " +
                  (root_ / "data" / "vgg").string() + " --output " + bag.string())
                .code,
            0);
  const std::string start =
      "rosrun corrsel benchmark --report false --features orb+orb --bag " + bag.string();
  const Output missing = shell(start + " --left /cam0/image_raw --right /cam1/image_raw --output_dir " +
                               (root_ / "no_topics").string());
  EXPECT_FALSE(fs::exists(root_ / "no_topics"));
  EXPECT_EQ(missing.code, 2) << missing.text;
  for (const char* part : {"/cam0/image_raw", "/left/image (sensor_msgs/Image)", "/ground_truth"}) {
    EXPECT_NE(missing.text.find(part), std::string::npos) << missing.text;
  }
  const Output named =
      shell(start + " --left /left/image --right /right/image --output_dir " + (root_ / "own").string());
  EXPECT_EQ(named.code, 0) << named.text;
  EXPECT_EQ(timelessRows(root_ / "own").size(), 1U + 5 * selections());
  const Output without_bag = shell("rosrun corrsel benchmark --left /left/image");
  EXPECT_EQ(without_bag.code, 2) << without_bag.text;
  EXPECT_NE(without_bag.text.find("without a bag"), std::string::npos) << without_bag.text;
}

TEST_F(BenchmarkLaunch, OwnStereoBagIsRankedByItsCalibration) {
  const std::string data = testing::realDataDir() + "/kitti_stereo";
  if (!fs::is_directory(data)) GTEST_SKIP() << "no data in " << data;
  const fs::path bag = root_ / "kitti.bag", run = root_ / "kitti_run";
  const Output made =
      shell("rosrun corrsel kitti_to_bag.py '" + data + "' --every 12 --output " + bag.string());
  ASSERT_EQ(made.code, 0) << made.text;
  const Output output =
      shell("cd " + root_.string() +
            " && roslaunch corrsel benchmark.launch bag:=kitti.bag left:=/stereo/left/image_raw "
            "right:=/stereo/right/image_raw features:=orb+orb preselection:=none tolerances:=1,2,3 "
            "ground_truth_tolerance:=3 output_dir:=kitti_run");
  EXPECT_NE(readAll(run / "summary.json").find("\"complete\": true"), std::string::npos) << output.text;
  EXPECT_NE(readAll(run / "config.yaml").find("left: /stereo/left/image_raw"), std::string::npos);
  const std::string note =
      "evaluated with camera_info on /stereo/left/camera_info and /stereo/right/camera_info (tolerances 1, "
      "2, 3 "
      "px; "
      "inliers within 3 px): an outlier near its epipolar line counts as correct, so precision is an "
      "upper bound";
  EXPECT_NE(output.text.find(note), std::string::npos) << output.text;
  EXPECT_NE(readAll(run / "report.html").find(note), std::string::npos);
  std::map<std::string, double> f;  // by selector, tau = 3 px
  std::ifstream in(run / "summary.csv");
  for (std::string line; std::getline(in, line);) {
    const std::vector<std::string> fields = core::parseCsvLine(line);
    if (fields.at(4) == "3" && !fields.at(8).empty()) f[fields[3]] = core::parseNumber(fields[8], "f_paper");
  }
  EXPECT_EQ(f.size(), core::usualSelectorNames().size());
  EXPECT_GT(f["usac"], 0.9);
  EXPECT_LT(f["keep_all"], f["usac"]);
}

}  // namespace
}  // namespace corrsel

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "benchmark_launch_test");
  const ros::NodeHandle node;
  return RUN_ALL_TESTS();
}
