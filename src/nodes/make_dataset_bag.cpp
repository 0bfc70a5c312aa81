#include <exception>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "corrsel/datasets/reader.h"
#include "datasets/dataset_report.h"
#include "ros/bags/dataset_bag.h"

namespace {

constexpr int kOk = 0, kProblems = 1, kUsageError = 2;

struct Arguments {
  std::string dataset, path, output;
  corrsel::DatasetBagOptions bag;
  int seed = 0;
  bool check = false;
  bool help = false;
};

std::string usage() {
  return "Writes a dataset as a bag that the benchmark and the nodelets read.\n"
         "\n"
         "make_dataset_bag --dataset NAME --path FOLDER --output FILE.bag [options]\n"
         "make_dataset_bag --dataset NAME --path FOLDER --check\n"
         "\n"
         "  --dataset NAME   " +
         corrsel::core::joinList(corrsel::core::datasetNames()) +
         ";\n"
         "                   or a name of your own: the layout is then recognised from the files\n"
         "  --path FOLDER    where the dataset lies\n"
         "  --output FILE    the bag to write; replaced where it exists\n"
         "  --check          only say what the folder holds, lacks and which pairs are broken; no bag\n"
         "  --compressed     images as PNG (smaller, slower) instead of raw\n"
         "  --period S       seconds between two pairs, default 0.5\n"
         "  --seed N         for datasets that generate pairs, default 0\n"
         "  --help           this text\n"
         "\n"
         "Exit code: 0 = all pairs written (--check: no pair is broken), 1 = problems, listed, 2 = wrong "
         "usage.\n";
}

/// Throws std::invalid_argument.
Arguments parse(const std::vector<std::string>& words) {
  Arguments arguments;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    const auto value = [&]() -> const std::string& {
      if (i + 1 >= words.size()) throw std::invalid_argument(word + " needs a value");
      return words[++i];
    };
    if (word == "--help" || word == "-h") {
      arguments.help = true;
    } else if (word == "--dataset") {
      arguments.dataset = value();
    } else if (word == "--path") {
      arguments.path = value();
    } else if (word == "--output") {
      arguments.output = value();
    } else if (word == "--check") {
      arguments.check = true;
    } else if (word == "--compressed") {
      arguments.bag.compressed = true;
    } else if (word == "--period") {
      arguments.bag.period = corrsel::core::parseNumber(value(), "--period");
    } else if (word == "--seed") {
      arguments.seed = corrsel::core::parseInteger(value(), "--seed");
    } else if (word.compare(0, 2, "__") != 0) {  // names that roslaunch adds
      throw std::invalid_argument("unknown argument '" + word + "'");
    }
  }
  if (arguments.help) return arguments;
  for (const auto& [name, text] :
       {std::pair{"--dataset", &arguments.dataset}, std::pair{"--path", &arguments.path},
        std::pair{"--output", &arguments.output}}) {
    const bool wanted = text != &arguments.output || !arguments.check;
    if (wanted && text->empty()) throw std::invalid_argument(std::string(name) + " is missing");
  }
  return arguments;
}

int run(const Arguments& arguments) {
  const std::unique_ptr<corrsel::core::DatasetReader> reader =
      corrsel::core::openDataset(arguments.dataset, arguments.path, arguments.seed);
  const corrsel::core::DatasetReport report = corrsel::core::describe(*reader);
  std::cout << report.text() << std::flush;
  if (arguments.check) return report.problems.empty() ? kOk : kProblems;
  std::vector<std::string> problems;
  const auto progress = [](std::size_t done, std::size_t total, const corrsel::core::PairId& id) {
    std::cout << done << "/" << total << " " << id.text() << std::endl;
  };
  const std::size_t written =
      corrsel::writeDatasetBag(*reader, arguments.output, arguments.bag, progress, &problems);
  for (const std::string& problem : problems) std::cerr << "problem: " << problem << "\n";
  std::cout << written << " of " << reader->size() << " pairs written"
            << (written > 0 ? " to " + arguments.output : ", no bag made") << std::endl;
  return problems.empty() && written > 0 ? kOk : kProblems;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Arguments arguments = parse({argv + 1, argv + argc});
    if (arguments.help) {
      std::cout << usage();
      return kOk;
    }
    return run(arguments);
  } catch (const std::invalid_argument& error) {
    std::cerr << "make_dataset_bag: " << error.what() << "\n\n" << usage();
    return kUsageError;
  } catch (const std::exception& error) {
    std::cerr << "make_dataset_bag: " << error.what() << "\n";
    return kProblems;
  }
}
