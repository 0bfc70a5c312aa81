#include <gtest/gtest.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "corrsel/evaluation/metrics.h"
#include "ros/live/nodelet_parameters.h"
#include "ros/live/parameters.h"
#include "test_paths.h"

namespace corrsel {
namespace {

core::OptionField fieldOf(const core::OptionSet& set, const std::string& name) {
  for (const core::OptionField& field : core::optionFields(set)) {
    if (field.name == name) return field;
  }
  throw std::invalid_argument("no parameter " + name);
}

std::string assign(core::OptionSet& set, const std::string& name, const XmlRpc::XmlRpcValue& value) {
  return assignParameter(value, fieldOf(set, name), set);
}

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(NodeletParameters, EveryNodeletIsDescribedOnceAndItsDefaultsAreValid) {
  std::ifstream file(testing::sourceDir() + "/nodelet_plugins.xml");
  const std::string plugins(std::istreambuf_iterator<char>(file), {});
  std::size_t declared = 0;
  for (std::size_t at = plugins.find("<class "); at != std::string::npos;
       at = plugins.find("<class ", at + 1)) {
    ++declared;
  }
  const auto nodelets = nodeletParameters();
  EXPECT_EQ(nodelets.size(), declared);
  for (const auto& [name, parameters] : nodelets) {
    EXPECT_TRUE(holds(plugins, "\"corrsel/" + name + "\"")) << name;
    EXPECT_NO_THROW(parameters->check()) << name;
    std::set<std::string> names;
    for (const core::OptionField& field : core::optionFields(*parameters)) {
      EXPECT_TRUE(names.insert(field.name).second) << name << " has " << field.name << " twice";
      EXPECT_FALSE(field.description.empty()) << field.name;
    }
    EXPECT_FALSE(names.empty()) << name;
  }
}

TEST(NodeletParameters, OpticalFlowNeedsASequence) {
  FeatureMatcherParameters pairs, sequence;
  const std::string refusal = assign(pairs, "tracker", "flow");
  for (const char* part : {"tracker", "flow", "sequence", "descriptors"}) {
    EXPECT_TRUE(holds(refusal, part)) << refusal;
  }
  EXPECT_EQ(pairs.tracker, FeatureMatcherParameters::Tracker::kDescriptors);
  EXPECT_EQ(assign(sequence, "mode", "sequence"), "");
  EXPECT_EQ(assign(sequence, "tracker", "flow"), "");
  EXPECT_EQ(sequence.tracker, FeatureMatcherParameters::Tracker::kFlow);
}

TEST(NodeletParameters, GoodValuesAreTaken) {
  FeatureMatcherParameters images;
  EXPECT_EQ(assign(images, "mode", "sequence"), "");
  EXPECT_EQ(images.mode, FeatureMatcherParameters::Mode::kSequence);
  EXPECT_EQ(assign(images, "approximate_sync", XmlRpc::XmlRpcValue(true)), "");
  EXPECT_TRUE(images.approximate_sync);
  EXPECT_EQ(assign(images, "approximate_sync_max_interval", 1), "");  // YAML writes 1.0 as 1
  EXPECT_EQ(images.approximate_sync_max_interval, 1.0);
  EXPECT_EQ(assign(images, "queue_size", 7.0), "");
  EXPECT_EQ(images.queue_size, 7);
  EXPECT_EQ(assign(images, "image_transport", "theora"), "");
  EXPECT_EQ(images.image_transport, "theora");
}

TEST(NodeletParameters, NumbersOutOfRangeAreSetToTheNearestLimit) {
  FeatureMatcherParameters matcher;
  std::string text = assign(matcher, "pending", -3);
  EXPECT_TRUE(holds(text, "is outside [1, 1000] and is set to the nearest limit; 1 is used")) << text;
  EXPECT_EQ(matcher.pending, 1);
  text = assign(matcher, "warn_drop_ratio", 1e300);
  EXPECT_TRUE(holds(text, "is outside [0, 1]")) << text;
  EXPECT_EQ(matcher.warn_drop_ratio, 1.0);
  text = assign(matcher, "threads", 2.4);
  EXPECT_TRUE(holds(text, "is rounded: expected a whole number")) << text;
  EXPECT_EQ(matcher.threads, 2);
}

TEST(NodeletParameters, ValuesOfTheWrongKindAreIgnored) {
  FeatureMatcherParameters images;
  std::string text = assign(images, "mode", "triple");
  for (const char* part : {"is ignored", "triple", "pair", "sequence", "pair is used"}) {
    EXPECT_TRUE(holds(text, part)) << text;
  }
  EXPECT_EQ(images.mode, FeatureMatcherParameters::Mode::kPair);
  text = assign(images, "mode", 3);
  EXPECT_TRUE(holds(text, "is ignored: expected a text; pair is used")) << text;
  text = assign(images, "use_mask", "yes");
  EXPECT_TRUE(holds(text, "is ignored: expected true or false; false is used")) << text;
  EXPECT_FALSE(images.use_mask);
  text = assign(images, "queue_size", "many");
  EXPECT_TRUE(holds(text, "is ignored: expected a number in [1, 1000]; 5 is used")) << text;
  EXPECT_EQ(images.queue_size, 5);
  text = assign(images, "approximate_sync_max_interval", std::nan(""));
  EXPECT_TRUE(holds(text, "is ignored")) << text;
  EXPECT_EQ(images.approximate_sync_max_interval, 0.0);
}

TEST(NodeletParameters, ClassesOfMasksAreAListOfLabels) {
  SelectorParameters selector;
  EXPECT_TRUE(selector.maskClassList().empty());
  EXPECT_EQ(assign(selector, "mask_classes", "11, 12, 65535"), "");
  EXPECT_EQ(selector.maskClassList(), (std::vector<int>{11, 12, 65535}));
  for (const char* bad : {"11, car", "-1", "65536", "1.5"}) {
    const std::string text = assign(selector, "mask_classes", bad);
    EXPECT_TRUE(holds(text, "is ignored")) << text;
    EXPECT_EQ(selector.maskClassList().size(), 3u);
  }
  EXPECT_EQ(assign(selector, "mask_mode", "stamped"), "");
  EXPECT_EQ(selector.mask_mode, MaskMode::kStamped);
}

TEST(NodeletParameters, TolerancesAreAListOfPositiveNumbers) {
  EvaluatorParameters evaluator;
  EXPECT_EQ(evaluator.toleranceList(), core::EvaluationOptions().tolerances);
  XmlRpc::XmlRpcValue list;
  list.setSize(2);
  list[0] = 1.5;
  list[1] = 4;
  EXPECT_EQ(assign(evaluator, "tolerances", list), "");
  EXPECT_EQ(evaluator.toleranceList(), (std::vector<double>{1.5, 4}));
  EXPECT_EQ(assign(evaluator, "tolerances", "2, 3"), "");
  EXPECT_EQ(evaluator.toleranceList(), (std::vector<double>{2, 3}));

  XmlRpc::XmlRpcValue negative = list, texts = list, none;
  negative[1] = -4.0;
  texts[0] = "one";
  none.setSize(0);
  for (const XmlRpc::XmlRpcValue& bad :
       {negative, texts, none, XmlRpc::XmlRpcValue("two"), XmlRpc::XmlRpcValue("")}) {
    const std::string text = assign(evaluator, "tolerances", bad);
    EXPECT_TRUE(holds(text, "is ignored")) << text;
    EXPECT_TRUE(holds(text, "2, 3 is used")) << text;
    EXPECT_EQ(evaluator.toleranceList(), (std::vector<double>{2, 3}));
  }
}

}  // namespace
}  // namespace corrsel
