#include <stdexcept>

#include "corrsel/datasets/adelaide_rmf.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/datasets/sample.h"
#include "corrsel/datasets/symbench.h"
#include "corrsel/datasets/vgg.h"
#include "corrsel/text.h"

namespace corrsel::core {
namespace {

using Reader = std::unique_ptr<DatasetReader>;

struct Entry {
  const char* name;
  Reader (*open)(const std::string& path, int seed);
};

const Entry kDatasets[] = {
    {"adelaidermf",
     [](const std::string& path, int) -> Reader { return std::make_unique<AdelaideRmfReader>(path); }},
    {"sample",
     [](const std::string& path, int seed) -> Reader { return std::make_unique<SampleReader>(path, seed); }},
    {"symbench",
     [](const std::string& path, int) -> Reader { return std::make_unique<SymbenchReader>(path); }},
    {"vgg", [](const std::string& path, int) -> Reader { return std::make_unique<VggReader>(path); }},
};

}  // namespace

std::unique_ptr<DatasetReader> openDataset(const std::string& name, const std::string& path, int seed) {
  for (const Entry& entry : kDatasets) {
    if (name == entry.name) return entry.open(path, seed);
  }
  throw std::invalid_argument("unknown dataset '" + name + "'; valid: " + joinList(datasetNames()));
}

std::vector<std::string> datasetNames() {
  std::vector<std::string> names;
  for (const Entry& entry : kDatasets) names.push_back(entry.name);
  return names;
}

}  // namespace corrsel::core
