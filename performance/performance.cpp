// Times features, matching and every selector beside their alternatives; see docs/performance.md.
#include <benchmark/benchmark.h>

#include <fstream>
#include <iostream>
#include <opencv2/core/utility.hpp>

#include "hard_models.h"
#include "pictures.h"
#include "programs/command_line.h"
#include "suite.h"

namespace {

using namespace corrsel::performance;

const corrsel::CommandLineTable& argumentTable() {
  static const corrsel::CommandLineTable table = {
      "performance",
      "Times features, matching and every selector beside their alternatives, e.g. OpenCV's functions. "
      "Arguments of Google Benchmark "
      "(--benchmark_...) are "
      "passed on to it.",
      {},
      {
          {"all", "", "", "full grid of sizes and inlier ratios instead of the comparisons with targets"},
          {"filter", "REGEX", "",
           "only the comparisons whose name matches, e.g. '^gms'; --benchmark_list_tests lists them"},
          {"samples", "FOLDER", "", "sample photographs, as scripts/fetch_samples.sh collects them"},
          {"data_root", "FOLDER", "", "features are timed on images of its datasets vgg and kitti_stereo"},
          {"csv", "FILE", "", "file for all rows, with the machine"},
          {"markdown", "FILE", "", "file for the tables"},
      },
      "exit code: 0 = everything was measured, masks agree and all targets are met, 1 = not so, 2 = wrong "
      "arguments\n"};
  return table;
}

struct Arguments {
  bool all = false;
  std::string csv, markdown, command = "scripts/maintenance/performance.sh";
  std::vector<std::string> rest;  // for Google Benchmark
};

Arguments argumentsOf(const corrsel::ArgumentValues& values, const std::vector<std::string>& rest) {
  Arguments result;
  result.rest = rest;
  result.csv = values.text("csv");
  result.markdown = values.text("markdown");
  setPictureFolders({values.text("samples"), values.text("data_root")});
  if (values.given("data_root")) result.command += " --data_root FOLDER";
  result.all = values.isOn("all");
  if (result.all) result.command += " --all";
  if (values.given("filter")) {
    result.rest.push_back("--benchmark_filter=" + values.text("filter"));
    result.command += " --filter '" + values.text("filter") + "'";
  }
  return result;
}

/// Prints the rows of every comparison as soon as it is done.
class TableReporter : public benchmark::BenchmarkReporter {
 public:
  explicit TableReporter(Report& report) : report_(report) {}
  bool ReportContext(const Context&) override {
    std::cout << Report::machine() << "\n\n" << Report::consoleHeader() << std::flush;
    return true;
  }
  void ReportRuns(const std::vector<Run>&) override { std::cout << report_.newLines() << std::flush; }

 private:
  Report& report_;
};

template <class Action>
void registerOnce(const std::string& name, const Action& action) {
  benchmark::RegisterBenchmark(name.c_str(), [action](benchmark::State& state) {
    for (auto _ : state) action();
  })->Iterations(1);
}

int runAll(const Arguments& arguments) {
  std::vector<char*> pointers;
  for (const std::string& argument : arguments.rest) pointers.push_back(const_cast<char*>(argument.c_str()));
  int count = int(pointers.size());
  benchmark::Initialize(&count, pointers.data());
  if (benchmark::ReportUnrecognizedArguments(count, pointers.data())) return 2;

  cv::setNumThreads(1);
  Report report;
  const std::vector<Comparison> list = comparisons(arguments.all);
  for (const Comparison& comparison : list) {
    registerOnce(comparison.name, [&comparison, &report] { run(comparison, report); });
  }
  for (const double inlier_ratio : {0.05, 0.07}) {
    const std::string name = "hard/eps:" + shortNumber(inlier_ratio).substr(0, 4);
    registerOnce(
        name, [=, &report, &arguments] { runHardModels(inlier_ratio, arguments.all ? 2 : 5, name, report); });
  }
  TableReporter reporter(report);
  if (benchmark::RunSpecifiedBenchmarks(&reporter) == 0) return 2;

  std::cout << "\n" << report.targets() << std::flush;
  if (!arguments.csv.empty()) {
    std::ofstream out(arguments.csv);
    report.writeCsv(out);
    if (!out.flush()) throw std::runtime_error("cannot write " + arguments.csv);
  }
  if (!arguments.markdown.empty()) writeMarkdown(arguments.markdown, report.markdown(arguments.command));
  return report.good() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    std::vector<std::string> rest = {argv[0]};
    const corrsel::ArgumentValues values =
        corrsel::parseCommandLine(argumentTable(), {argv + 1, argv + argc}, &rest);
    if (values.help) {
      std::cout << corrsel::helpText(argumentTable());
      return 0;
    }
    return runAll(argumentsOf(values, rest));
  } catch (const std::exception& error) {
    std::cerr << "performance: " << error.what() << "\n";
    return 2;
  }
}
