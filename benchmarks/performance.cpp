// Times every selector beside what users would pick instead; see docs/performance.md.
#include <benchmark/benchmark.h>

#include <cstring>
#include <fstream>
#include <iostream>
#include <opencv2/core/utility.hpp>

#include "hard_models.h"
#include "suite.h"

namespace {

using namespace corrsel::performance;

constexpr const char* kUsage =
    "performance [--all] [--filter REGEX] [--csv FILE] [--markdown FILE] [--benchmark_...]\n"
    "  --all            full grid of sizes and inlier ratios instead of the comparisons with targets\n"
    "  --filter REGEX   only the comparisons whose name matches, e.g. '^gms'; --benchmark_list_tests lists "
    "them\n"
    "  --csv FILE       all rows, with the machine\n"
    "  --markdown FILE  tables; between the marks where FILE has them, as docs/performance.md\n"
    "Exit code 0 only where everything was measured, masks agree and all targets are met.\n";

struct Arguments {
  bool all = false;
  std::string csv, markdown, command = "scripts/performance.sh";
  std::vector<std::string> rest;  // for Google Benchmark
};

Arguments parse(int argc, char** argv) {
  Arguments result;
  result.rest.push_back(argv[0]);
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const auto value = [&] {
      if (i + 1 >= argc) throw std::invalid_argument(argument + " needs a value");
      return std::string(argv[++i]);
    };
    if (argument == "--all") {
      result.all = true;
      result.command += " --all";
    } else if (argument == "--csv") {
      result.csv = value();
    } else if (argument == "--markdown") {
      result.markdown = value();
    } else if (argument == "--filter") {
      result.rest.push_back("--benchmark_filter=" + value());
      result.command += " --filter '" + std::string(argv[i]) + "'";
    } else {
      result.rest.push_back(argument);
    }
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
  if (argc > 1 && (std::strcmp(argv[1], "--help") == 0 || std::strcmp(argv[1], "-h") == 0)) {
    std::cout << kUsage;
    return 0;
  }
  try {
    return runAll(parse(argc, argv));
  } catch (const std::exception& error) {
    std::cerr << "performance: " << error.what() << "\n";
    return 2;
  }
}
