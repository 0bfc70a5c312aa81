// corrsel_benchmark: the benchmark without ROS. It reads folders of datasets and writes the folder of a run.

#include "programs/benchmark/run.h"

int main(int argc, char** argv) {
  corrsel::BenchmarkFront front;
  return corrsel::runBenchmark({argv + 1, argv + argc}, front);
}
