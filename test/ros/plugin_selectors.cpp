// Selectors as another package could export them, good and bad, for test_selector_plugins.cpp.

#include <memory>
#include <pluginlib/class_list_macros.hpp>
#include <stdexcept>
#include <string>

#include "corrsel/selectors/factory.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::testing {

struct SeedOptions : core::OptionSet {
  int seed = 0;
  void visit(core::OptionVisitor& visitor) const override {
    visitor.integer({"seed", 0, 100, "-", "-"}, &SeedOptions::seed);
  }
};

/// Selects every match.
class All : public Selector {
 public:
  std::string name() const override { return "test_selectors/All"; }
  const core::OptionSet& options() const override { return options_; }
  void configure(const core::OptionMap& options) override { setOptions(options_, options, name()); }

 protected:
  void run(const core::Correspondences&, core::Workspace&, core::Selection& result) const override {
    result.mask.assign(result.mask.size(), 1);
  }

 private:
  SeedOptions options_;
};

/// Selects what another selector does, which it makes by itself.
class Wrapping : public All {
 public:
  Wrapping() : inner_(core::createSelector("test_selectors/All")) {}

 protected:
  void run(const core::Correspondences& matches, core::Workspace&, core::Selection& result) const override {
    result = inner_->select(matches);
  }

 private:
  std::unique_ptr<Selector> inner_;
};

class ThrowsError : public All {
 public:
  ThrowsError() { throw std::runtime_error("no licence"); }
};

class ThrowsNumber : public All {
 public:
  ThrowsNumber() { throw 7; }
};

}  // namespace corrsel::testing

PLUGINLIB_EXPORT_CLASS(corrsel::testing::All, corrsel::Selector)
PLUGINLIB_EXPORT_CLASS(corrsel::testing::Wrapping, corrsel::Selector)
PLUGINLIB_EXPORT_CLASS(corrsel::testing::ThrowsError, corrsel::Selector)
PLUGINLIB_EXPORT_CLASS(corrsel::testing::ThrowsNumber, corrsel::Selector)
