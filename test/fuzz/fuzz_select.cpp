// libFuzzer program: selectors on input of every kind, made from the fuzzer's bytes.
// scripts/maintenance/fuzz.sh builds and runs it.
//
// CORRSEL_FUZZ_SELECTOR names the selector, as "name" (its presets are tried as well) or "name:preset"; all
// selectors where it is not set. --list prints the names.

#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "arbitrary.h"
#include "corrsel/motion_labels.h"
#include "corrsel/reference/reference_selectors.h"
#include "corrsel/selectors/factory.h"

namespace {

using namespace corrsel::core;
using namespace corrsel::core::testing;

[[noreturn]] void fail(const std::string& spec, const OptionMap& options, const Correspondences& matches,
                       const std::string& fault) {
  std::cerr << "\n" << spec << " with";
  for (const auto& [name, value] : options) std::cerr << " " << name << "=" << value;
  std::cerr << " on " << matches.size() << " matches: " << fault << std::endl;
  std::abort();
}

/// The selector that the environment or the bytes name, with one of its presets.
std::string drawnSpec(ByteSource& source) {
  static const char* const set = std::getenv("CORRSEL_FUZZ_SELECTOR");
  static const std::vector<std::string> names = selectorNames();
  std::string spec = set ? set : names[source.byte() % names.size()];
  if (spec.find(':') != std::string::npos) return spec;
  const std::vector<std::string> presets = selectorPresets(spec);
  const std::size_t preset = source.byte() % (presets.size() + 1);
  return preset < presets.size() ? spec + ":" + presets[preset] : spec;
}

/// Options that contradict each other are refused; those of the preset then remain.
std::unique_ptr<Selector> drawnSelector(const std::string& spec, OptionMap& options) {
  try {
    return createSelector(spec, options);
  } catch (const std::invalid_argument&) {
    options.clear();
    return createSelector(spec);
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  addReferenceSelectors();
  for (int i = 1; i < *argc; ++i) {
    if (std::string((*argv)[i]) != "--list") continue;
    for (const std::string& name : selectorNames()) std::cout << name << "\n";
    std::exit(0);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ByteSource source(data, size);
  const std::string spec = drawnSpec(source);
  OptionMap options = arbitraryOptions(source, *createSelector(spec));
  const auto selector = drawnSelector(spec, options);
  Correspondences matches = arbitraryMatches(source);
  addArbitraryCameras(source, matches);

  const Selection first = selector->select(matches);
  Selection rated = first;
  addProbability(matches, rated);
  Selection labelled = rated;
  labelMotion(matches, labelled);
  for (const Selection& selection : {first, rated, labelled}) {
    const std::string fault = contractViolation(matches, selection);
    if (!fault.empty()) fail(spec, options, matches, fault);
  }
  const std::string change = difference(first, createSelector(spec, options)->select(matches));
  if (!change.empty()) fail(spec, options, matches, "the second result differs: " + change);
  return 0;
}
