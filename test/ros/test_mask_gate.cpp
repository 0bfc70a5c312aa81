#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "corrsel/random.h"
#include "ros/live/mask_gate.h"

namespace corrsel {
namespace {

constexpr std::int64_t kMillisecond = 1000000;

/// A gate whose clock and stamps are in milliseconds. Pairs have their left stamps as items, and masks are
/// single pixels that hold the number that they were given.
class GateTest : public ::testing::Test {
 protected:
  using Gate = MaskGate<int>;

  void open(bool sequence, double timeout_ms, double max_age_ms) {
    gate_ = std::make_unique<Gate>(MaskGateOptions{sequence, 1e-3 * timeout_ms, 1e-3 * max_age_ms});
  }

  /// What goes on, e.g. "100 l7 r8, 110 l- r9 missing".
  static std::string text(const Gate::Pairs& pairs) {
    const auto number = [](const cv::Mat& mask) {
      return mask.empty() ? std::string("-") : std::to_string(mask.at<int>(0));
    };
    std::string result;
    for (const Gate::Pair& pair : pairs) {
      result += (result.empty() ? "" : ", ") + std::to_string(pair.item) + " l" + number(pair.masks.left) +
                " r" + number(pair.masks.right) + (pair.masks.missing ? " missing" : "");
    }
    return result;
  }

  std::string pair(int left, int right, double now) {
    return text(gate_->addPair(left, left * kMillisecond, right * kMillisecond, 1e-3 * now));
  }
  std::string pair(int stamp, double now) { return pair(stamp, stamp, now); }
  std::string mask(Gate::Side side, int stamp, int number, double now) {
    return text(
        gate_->addMask(side, stamp * kMillisecond, cv::Mat(1, 1, CV_32SC1, cv::Scalar(number)), 1e-3 * now));
  }
  std::string left(int stamp, int number, double now) { return mask(Gate::kLeft, stamp, number, now); }
  std::string right(int stamp, int number, double now) { return mask(Gate::kRight, stamp, number, now); }
  std::string poll(double now) { return text(gate_->poll(1e-3 * now)); }

  std::unique_ptr<Gate> gate_;
};

TEST_F(GateTest, LateMasksFindTheirPair) {
  open(false, 200, 0);
  EXPECT_EQ(pair(100, 1000), "");
  EXPECT_EQ(pair(133, 1033), "");
  EXPECT_EQ(left(100, 1, 1050), "");
  EXPECT_EQ(right(100, 2, 1060), "100 l1 r2");
  EXPECT_EQ(right(133, 4, 1090), "");
  EXPECT_EQ(left(133, 3, 1091), "133 l3 r4");
  const Gate::Counts counts = gate_->counts();
  EXPECT_EQ(counts.masks, 4u);
  EXPECT_EQ(counts.masks_unused, 0u);
  EXPECT_EQ(counts.pairs_masked, 2u);
  EXPECT_EQ(counts.pairs_unmasked, 0u);
}

TEST_F(GateTest, EarlyMasksAreKeptForTheirPair) {
  open(false, 200, 0);
  for (int i = 1; i <= 20; ++i) {
    EXPECT_EQ(left(100 * i, i, 1000 + i), "");
    EXPECT_EQ(right(100 * i, 100 + i, 1000 + i), "");
  }
  EXPECT_EQ(pair(300, 2000), "300 l3 r103");
  EXPECT_EQ(pair(2000, 2001), "2000 l20 r120");
  EXPECT_EQ(gate_->counts().masks_unused, 36u);
}

TEST_F(GateTest, APairGoesOnAfterTheTimeout) {
  open(false, 200, 0);
  EXPECT_EQ(pair(100, 1000), "");
  EXPECT_EQ(left(100, 1, 1010), "");
  EXPECT_EQ(pair(150, 1050), "");
  EXPECT_EQ(poll(1199.9), "");
  EXPECT_EQ(poll(1200.1), "100 l1 r- missing") << "the mask that is there is used";
  EXPECT_EQ(right(100, 2, 1210), "") << "too late";
  EXPECT_EQ(poll(1249.9), "");
  EXPECT_EQ(poll(1260), "150 l- r- missing");
  EXPECT_EQ(gate_->counts().pairs_unmasked, 2u);
  EXPECT_EQ(gate_->counts().masks_unused, 1u);
}

TEST_F(GateTest, WithoutATimeoutNothingWaits) {
  open(false, 0, 0);
  EXPECT_EQ(pair(100, 1000), "100 l- r- missing");
  left(200, 1, 1100);
  right(200, 2, 1100);
  EXPECT_EQ(pair(200, 1101), "200 l1 r2");
}

TEST_F(GateTest, ALaterMaskShowsThatAnEarlierPairGetsNone) {
  open(true, 10000, 0);
  gate_->expect(Gate::kLeft, true);
  EXPECT_EQ(pair(133, 100, 1000), "");
  EXPECT_EQ(pair(166, 133, 1033), "");
  EXPECT_EQ(pair(200, 166, 1066), "");
  EXPECT_EQ(pair(233, 200, 1099), "");
  EXPECT_EQ(left(200, 7, 1150), "133 l- r- missing, 166 l- r- missing, 200 l7 r- missing")
      << "no need to wait for the timeout";
  EXPECT_EQ(left(233, 8, 1200), "233 l8 r7");
}

TEST_F(GateTest, AMaskBelongsToTheNewestImageThatIsNotNewer) {
  open(false, 10000, 40);
  gate_->expect(Gate::kRight, false);
  EXPECT_EQ(pair(100, 1000), "");
  EXPECT_EQ(pair(133, 1033), "");
  EXPECT_EQ(pair(166, 1066), "");
  EXPECT_EQ(left(150, 1, 1080), "100 l- r- missing, 133 l1 r-");
  EXPECT_EQ(left(206, 2, 1090), "166 l2 r-") << "40 ms, the limit";
  EXPECT_EQ(pair(300, 1200), "");
  EXPECT_EQ(left(341, 3, 1250), "300 l- r- missing") << "beyond the limit";
  EXPECT_EQ(pair(341, 1260), "341 l3 r-")
      << "equal stamps count, whatever the mask might have been for before";
  EXPECT_EQ(gate_->counts().masks_unused, 0u);
}

TEST_F(GateTest, AMaskOfAnImageThatWasDroppedFindsNoPairWhereStampsMustBeEqual) {
  open(false, 200, 0);
  gate_->expect(Gate::kRight, false);
  EXPECT_EQ(left(90, 1, 1000), "");
  EXPECT_EQ(left(100, 2, 1010), "");
  EXPECT_EQ(left(110, 3, 1020), "");
  EXPECT_EQ(pair(100, 1030), "100 l2 r-");
  EXPECT_EQ(pair(120, 1040), "");
  EXPECT_EQ(left(120, 4, 1050), "120 l4 r-");
  EXPECT_EQ(gate_->counts().masks_unused, 2u);
}

TEST_F(GateTest, ACameraWithoutMasksIsNotWaitedFor) {
  open(false, 200, 0);
  gate_->expect(Gate::kRight, false);
  EXPECT_EQ(pair(100, 1000), "");
  EXPECT_EQ(left(100, 1, 1010), "100 l1 r-") << "no mask is missing";
  gate_->expect(Gate::kLeft, false);
  EXPECT_EQ(pair(200, 1100), "200 l- r- missing") << "no masks at all";
  gate_->expect(Gate::kLeft, true);
  EXPECT_EQ(pair(300, 1200), "");
  gate_->expect(Gate::kLeft, false);
  EXPECT_EQ(poll(1201), "300 l- r- missing") << "the masks ended while it waited";
}

TEST_F(GateTest, MasksOfTheSidesHaveTheStampsOfTheirImages) {
  open(false, 200, 0);
  EXPECT_EQ(pair(100, 103, 1000), "");
  EXPECT_EQ(left(100, 1, 1001), "");
  EXPECT_EQ(right(103, 2, 1002), "100 l1 r2");
}

TEST_F(GateTest, InASequenceTheMaskOfTheEarlierFrameIsThatOfTheRightSide) {
  open(true, 200, 0);
  EXPECT_EQ(left(100, 1, 1000), "") << "the first frame has no pair";
  EXPECT_EQ(pair(133, 100, 1040), "");
  EXPECT_EQ(left(133, 2, 1050), "133 l2 r1");
  EXPECT_EQ(pair(166, 133, 1070), "");
  EXPECT_EQ(poll(1271), "166 l- r2 missing");
  EXPECT_EQ(left(166, 3, 1272), "") << "too late for its own pair";
  EXPECT_EQ(pair(200, 166, 1280), "");
  EXPECT_EQ(left(200, 4, 1290), "200 l4 r3") << "in time for the next one";
}

TEST_F(GateTest, TheMaskOfAKeyframeIsKept) {
  open(true, 200, 0);
  left(100, 1, 1000);
  for (int i = 1; i <= 1000; ++i) {
    EXPECT_EQ(pair(100 + 33 * i, 100, 1000 + 33 * i), "");
    EXPECT_EQ(left(100 + 33 * i, 1 + i, 1001 + 33 * i),
              std::to_string(100 + 33 * i) + " l" + std::to_string(1 + i) + " r1");
  }
  const int newest = 100 + 33 * 1000;
  EXPECT_EQ(pair(newest + 33, newest, 50000), "");
  EXPECT_EQ(left(newest + 33, 2000, 50001), std::to_string(newest + 33) + " l2000 r1001")
      << "the next keyframe";
}

TEST_F(GateTest, WhenTimeGoesBackWaitingPairsGoOnAndMasksAreForgotten) {
  open(false, 10000, 0);
  EXPECT_EQ(pair(900, 1000), "");
  EXPECT_EQ(pair(950, 1050), "");
  EXPECT_EQ(left(900, 1, 1060), "");
  EXPECT_EQ(pair(100, 1100), "900 l1 r- missing, 950 l- r- missing") << "a bag starts again";
  EXPECT_EQ(left(100, 2, 1110), "");
  EXPECT_EQ(right(100, 3, 1120), "100 l2 r3");
  EXPECT_EQ(pair(150, 1150), "");
  EXPECT_EQ(left(50, 4, 1160), "150 l- r- missing") << "the masks start again first";
  EXPECT_EQ(right(50, 5, 1170), "");
  EXPECT_EQ(pair(50, 1180), "50 l4 r5");
}

TEST_F(GateTest, AMaskOfTheLastRoundIsNotTakenForOneOfThisRound) {
  open(false, 10000, 0);
  gate_->expect(Gate::kRight, false);
  for (int i = 1; i <= 3; ++i) {
    EXPECT_EQ(left(100 * i, i, 1000 + i), "");
    EXPECT_EQ(pair(100 * i, 1000 + i), std::to_string(100 * i) + " l" + std::to_string(i) + " r-");
  }
  EXPECT_EQ(pair(100, 1010), "") << "it waits for its own mask";
  EXPECT_EQ(left(100, 11, 1020), "100 l11 r-");
}

TEST_F(GateTest, StampsMayRepeatAndBeZero) {
  open(false, 200, 0);
  gate_->expect(Gate::kRight, false);
  EXPECT_EQ(left(0, 1, 1000), "");
  EXPECT_EQ(pair(0, 1001), "0 l1 r-");
  EXPECT_EQ(pair(0, 1002), "0 l1 r-");
}

TEST_F(GateTest, ClearDropsWhatWaits) {
  open(false, 200, 0);
  EXPECT_EQ(pair(100, 1000), "");
  left(100, 1, 1001);
  gate_->clear();
  EXPECT_EQ(poll(5000), "");
  EXPECT_EQ(pair(50, 5001), "") << "no stamp is earlier than the first one";
}

TEST_F(GateTest, PairsAreNeverReorderedAndEachGoesOnOnce) {
  for (const bool sequence : {false, true}) {
    core::Random random(sequence ? 1 : 2);
    open(sequence, 80, 20);
    std::vector<int> gone;
    std::size_t n_sent = 0;
    int now = 1000, frame = 0, left_mask = 0, right_mask = 0;
    const auto collect = [&gone](const Gate::Pairs& pairs) {
      for (const Gate::Pair& pair : pairs) gone.push_back(pair.item);
    };
    const auto stamp = [](int number) { return std::int64_t{33} * number * kMillisecond; };
    for (int step = 0; step < 20000; ++step) {
      now += static_cast<int>(random.index(12));
      const double time = 1e-3 * now;
      switch (random.index(5)) {
        case 0:
          ++frame;
          ++n_sent;
          if (random.index(500) == 0) frame = 1;  // a loop
          collect(gate_->addPair(static_cast<int>(n_sent), stamp(frame), stamp(frame - (sequence ? 1 : 0)),
                                 time));
          break;
        case 1:
          left_mask += static_cast<int>(random.index(3));
          if (left_mask > frame + 3) left_mask = frame - 2;
          collect(gate_->addMask(Gate::kLeft, stamp(left_mask), cv::Mat::ones(1, 1, CV_32SC1), time));
          break;
        case 2:
          right_mask += static_cast<int>(random.index(3));
          if (right_mask > frame + 3) right_mask = frame - 2;
          collect(gate_->addMask(Gate::kRight, stamp(right_mask), cv::Mat::ones(1, 1, CV_32SC1), time));
          break;
        case 3: {
          const Gate::Side side = random.index(2) == 0 ? Gate::kLeft : Gate::kRight;
          gate_->expect(side, random.index(4) != 0);
          break;
        }
        default:
          collect(gate_->poll(time));
      }
    }
    collect(gate_->poll(1e-3 * now + 1));
    ASSERT_EQ(gone.size(), n_sent);
    EXPECT_GT(n_sent, 1000u);
    for (std::size_t i = 0; i < gone.size(); ++i) ASSERT_EQ(gone[i], static_cast<int>(i) + 1);
    const Gate::Counts counts = gate_->counts();
    EXPECT_EQ(counts.pairs_masked + counts.pairs_unmasked, n_sent);
    EXPECT_GT(counts.pairs_masked, 30u);
    EXPECT_GT(counts.pairs_unmasked, 100u);
  }
}

}  // namespace
}  // namespace corrsel
