// A matcher as another package could export it, for test_message_matcher.cpp.

#include <pluginlib/class_list_macros.hpp>
#include <string>

#include "corrsel/ros/matcher_plugins.h"

namespace corrsel::testing {

struct OrderOptions : core::OptionSet {
  double probability = 0.5;
  bool broken = false;
  void visit(core::OptionVisitor& visitor) const override {
    visitor.number({"probability", 0, 1, "-", "-"}, &OrderOptions::probability);
    visitor.flag("broken", "-", &OrderOptions::broken);
  }
};

/// Matches feature i with feature i, as a network would return them: with a probability and no distances.
class InOrder : public Matcher {
 public:
  void configure(const core::OptionMap& options) override {
    setOptions(options_, options, "InOrder");
    options_.check();
  }

  core::Correspondences match(const core::Features& left, const core::Features& right) override {
    core::Correspondences matches;
    for (std::size_t i = 0; i < left.keypoints.size() && i < right.keypoints.size(); ++i) {
      matches.add(left.keypoints[i].pt, right.keypoints[i].pt);
      matches.probability.push_back(static_cast<float>(options_.probability));
      matches.left_index.push_back(static_cast<std::uint32_t>(i));
      matches.right_index.push_back(static_cast<std::uint32_t>(i));
    }
    if (options_.broken) matches.probability.push_back(1);
    return matches;
  }

 private:
  OrderOptions options_;
};

}  // namespace corrsel::testing

PLUGINLIB_EXPORT_CLASS(corrsel::testing::InOrder, corrsel::Matcher)
