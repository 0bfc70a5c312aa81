#pragma once

#include <string>
#include <vector>

#include "arguments.h"
#include "process_meter.h"
#include "reconfigurer.h"
#include "record.h"

namespace corrsel::load_test {

/// Measurements between two points in time.
struct Interval {
  double begin = 0.0, end = 0.0;  ///< s since the start of the test
  double cpu_ratio = 0.0;         ///< processor seconds per second; NaN = not measured
  double resident_mib = 0.0;      ///< mean; NaN = not measured
};

std::string intervalHeader();

/// One line of the table. @param pairs  of the whole test
std::string intervalLine(const Interval& interval, const std::vector<PairRecord>& pairs);

/// All measurements of a test.
struct Result {
  std::vector<PairRecord> pairs;
  Record::Counts counts;
  std::vector<Interval> intervals;
  Reconfigurer::Calls calls;
  std::vector<std::string> ended;  ///< nodes whose process ended
};

/// The memory of the last interval against that of the interval in which a sixth of the test was over, as a
/// share; NaN with fewer than two intervals.
double memoryGrowth(const std::vector<Interval>& intervals);

std::string summary(const Result& result);

/// Returns one sentence for every exceeded limit and every error.
std::vector<std::string> problems(const Result& result, const Arguments& arguments);

/// One line per pair. Throws std::runtime_error where the file cannot be written.
void writeCsv(const std::string& path, const std::vector<PairRecord>& pairs);

}  // namespace corrsel::load_test
