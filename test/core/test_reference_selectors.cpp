#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "corrsel/reference/reference_selectors.h"
#include "corrsel/selectors/factory.h"
#include "corrsel/selectors/keep_all.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

std::string refusal(const std::string& spec) {
  return errorOf<std::invalid_argument>([&] { createSelector(spec); });
}

std::vector<std::string> namesOfGroup(SelectorGroup group) {
  std::vector<std::string> names;
  for (const SelectorFactory& selector : builtInSelectors()) {
    if (selector.group() == group) names.push_back(selector.name());
  }
  return names;
}

/// One test, because what it adds stays for the process.
TEST(ReferenceSelectors, AreThereOnceAProgramHasAddedThem) {
  const std::vector<std::string> core = selectorNames();
  EXPECT_TRUE(namesOfGroup(SelectorGroup::kReference).empty());
  for (const std::string spec : {"lap", "tlinkage:motions", "icf[epsilon=8]"}) {
    EXPECT_TRUE(contains(refusal(spec), "addReferenceSelectors()")) << refusal(spec);
  }
  EXPECT_FALSE(contains(refusal("lapp"), "addReferenceSelectors()"));

  std::vector<std::string> asked;
  setSelectorLoader([&asked](const std::string& name) {
    asked.push_back(name);
    return std::make_unique<KeepAllSelector>();
  });
  EXPECT_EQ(findSelector("lap").group(), SelectorGroup::kReference);
  EXPECT_EQ(refusal("lap"), "");
  EXPECT_NE(refusal("lapp"), "");
  EXPECT_EQ(asked, std::vector<std::string>{"corrsel/lap"}) << "only names of the library become plug-ins";

  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) threads.emplace_back(addReferenceSelectors);
  for (std::thread& thread : threads) thread.join();
  addReferenceSelectors();

  const std::vector<std::string> added = namesOfGroup(SelectorGroup::kReference);
  EXPECT_EQ(added.size(), 12U);
  EXPECT_EQ(selectorNames().size(), core.size() + added.size());
  EXPECT_EQ(selectorNames().back(), "keep_all");
  for (const std::string& name : added) {
    EXPECT_TRUE(isReferenceName(name)) << "the error of a program without the library does not know " << name;
    EXPECT_EQ(createSelector(name)->name(), name);
  }
  EXPECT_EQ(asked.size(), 1U) << "what has been added is not loaded";
  setSelectorLoader({});
  for (const std::string& name : core) EXPECT_FALSE(isReferenceName(name)) << name;
}

}  // namespace
}  // namespace corrsel::core
