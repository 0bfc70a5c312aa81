// Prints means with their bootstrap intervals. The report calls this program, so that the interval is
// defined in the library only.

#include <cmath>
#include <exception>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "base/text.h"
#include "corrsel/evaluation/statistics.h"
#include "programs/command_line.h"

namespace {

namespace core = corrsel::core;

const corrsel::CommandLineTable& argumentTable() {
  static const corrsel::CommandLineTable table = {
      "mean_intervals",
      "Reads lines of numbers, separated by blanks, from the standard input. For each line it prints the "
      "mean of the "
      "numbers and the lower and the upper bound of the mean's 95 % bootstrap interval.",
      {},
      {},
      "exit code: 0 = done, 2 = a line that is not a list of numbers, or wrong arguments\n"};
  return table;
}

std::vector<double> numbersOf(const std::string& line, int number) {
  const std::string where = "line " + std::to_string(number);
  std::istringstream words(line);
  std::vector<double> values;
  for (std::string word; words >> word;) {
    values.push_back(core::parseNumber(word, where));
    if (!std::isfinite(values.back())) {
      throw std::invalid_argument(where + ": '" + word +
                                  "' has no finite mean with other numbers; leave it out");
    }
  }
  if (values.empty()) throw std::invalid_argument(where + " has no numbers: give at least one");
  return values;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (corrsel::parseCommandLine(argumentTable(), {argv + 1, argv + argc}).help) {
      std::cout << corrsel::helpText(argumentTable());
      return 0;
    }
    int number = 0;
    for (std::string line; std::getline(std::cin, line);) {
      const std::vector<double> values = numbersOf(line, ++number);
      const core::Interval interval = core::bootstrapMean(values, core::kBootstrapSeed);
      std::cout << core::formatNumber(core::mean(values)) << " " << core::formatNumber(interval.low) << " "
                << core::formatNumber(interval.high) << std::endl;
    }
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "mean_intervals: " << error.what() << std::endl;
  }
  return 2;
}
