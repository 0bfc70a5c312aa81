#include <gtest/gtest.h>

#include <thread>

#include "corrsel/workspace.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

struct Counted {
  static int alive;
  Counted() { ++alive; }
  ~Counted() { --alive; }
  int value = 0;
};
int Counted::alive = 0;

struct Other {
  int value = 0;
};

TEST(Workspace, KeepsOnePartOfEveryType) {
  Workspace workspace;
  workspace.part<Counted>().value = 3;
  workspace.part<Other>().value = 4;
  EXPECT_EQ(workspace.part<Counted>().value, 3);
  EXPECT_EQ(workspace.part<Other>().value, 4);
  EXPECT_EQ(Counted::alive, 1);
}

TEST(Workspace, FreesItsPartsOnReleaseAndAtItsEnd) {
  {
    Workspace workspace;
    workspace.part<Counted>().value = 3;
    workspace.release();
    EXPECT_EQ(Counted::alive, 0);
    EXPECT_EQ(workspace.part<Counted>().value, 0);
    EXPECT_EQ(Counted::alive, 1);
  }
  EXPECT_EQ(Counted::alive, 0);
}

TEST(Workspace, EveryThreadHasOne) {
  Workspace* other = nullptr;
  std::thread([&] { other = &Workspace::ofThread(); }).join();
  EXPECT_NE(other, &Workspace::ofThread());
  EXPECT_EQ(&Workspace::ofThread(), &Workspace::ofThread());
}

TEST(Workspace, MovesWithItsParts) {
  Workspace first;
  first.part<Other>().value = 5;
  Workspace second = std::move(first);
  EXPECT_EQ(second.part<Other>().value, 5);
}

/// Selects by another selector, in the workspace that it is given.
class Wrapper : public Selector {
 public:
  std::string name() const override { return "wrapper"; }
  const OptionSet& options() const override { return inner_->options(); }
  mutable Workspace* used = nullptr;

 protected:
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override {
    used = &workspace;
    result = inner_->select(matches, workspace);
  }

 private:
  std::unique_ptr<Selector> inner_ = createSelector("gms");
};

TEST(Workspace, ServesTheSelectorsInsideOfASelectorToo) {
  const Correspondences m = homographyScene({300, 0.6, 1.0, 1}).matches;
  const Wrapper wrapper;
  Workspace workspace;
  const Selection own = wrapper.select(m, workspace);
  EXPECT_EQ(wrapper.used, &workspace);
  EXPECT_EQ(wrapper.select(m).mask, own.mask);
  EXPECT_EQ(wrapper.used, &Workspace::ofThread());
}

TEST(Workspace, OneServesAllSelectorsAndChangesNothing) {
  Workspace workspace;
  for (const int round : {0, 1, 2}) {
    for (const std::string& name : selectorNames()) {
      SCOPED_TRACE(name + ", round " + std::to_string(round));
      Scene scene = homographyScene({std::size_t(500 - 100 * round), 0.6, 1.0, std::uint64_t(round + 1)});
      addFrames(scene);
      const auto selector = createSelector(name);
      if (needsCameras(*selector)) {
        scene = stereoScene({std::size_t(500 - 100 * round), 0.6, 0.5, std::uint64_t(round + 1)});
        addStereoCameras(scene);
      }
      const Selection expected = selector->select(scene.matches);
      const Selection s = selector->select(scene.matches, workspace);
      EXPECT_EQ(s.status, Status::kOk);
      EXPECT_EQ(s.mask, expected.mask);
      EXPECT_EQ(s.score, expected.score);
      EXPECT_EQ(s.message, expected.message);
      if (round == 1) workspace.release();
    }
  }
}

}  // namespace
}  // namespace corrsel::core
