#include "ros/live/pair_synchronizer.h"

#include <message_filters/sync_policies/approximate_time.h>
#include <message_filters/sync_policies/exact_time.h>
#include <message_filters/synchronizer.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>

#include "base/text.h"

namespace corrsel {
namespace {

constexpr std::size_t kFewImages = 3;
constexpr double kMaxPeriod = 10.0;  // s

/// Median distance of a left stamp from the nearest right one [s], to 10 us; NaN where one side has none.
double medianGap(const std::vector<ros::Time>& left, const std::vector<ros::Time>& right) {
  if (left.empty() || right.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> gaps;
  for (const ros::Time& stamp : left) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const ros::Time& other : right) {
      nearest = std::min(nearest, std::abs(stamp.toSec() - other.toSec()));
    }
    gaps.push_back(nearest);
  }
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  return std::round(*middle * 1e5) / 1e5;
}

}  // namespace

/// message_filters, which is given the images directly: it cannot be made anew within a callback of filters
/// that it is connected to.
class PairSynchronizer::Synchronizer {
 public:
  /// @param complete  where pairs are put. @param max_interval  of approximate stamps [s]; 0 = no limit
  Synchronizer(bool approximate, std::uint32_t queue_size, double max_interval,
               std::vector<ImagePair>& complete) {
    const auto paired = [&complete](const sensor_msgs::ImageConstPtr& left,
                                    const sensor_msgs::ImageConstPtr& right) {
      complete.emplace_back(left, right);
    };
    const auto callback = boost::bind<void>(paired, boost::placeholders::_1, boost::placeholders::_2);
    if (approximate) {
      approximate_ =
          std::make_unique<message_filters::Synchronizer<ApproximateTime>>(ApproximateTime(queue_size));
      if (max_interval > 0.0) approximate_->setMaxIntervalDuration(ros::Duration(max_interval));
      approximate_->registerCallback(callback);
    } else {
      exact_ = std::make_unique<message_filters::Synchronizer<ExactTime>>(ExactTime(queue_size));
      exact_->registerCallback(callback);
    }
  }

  /// Approximate pairs are handed over once no better partner can come. Without a lower bound on the time to
  /// the next image, that is one period late. @param seconds  smallest time between two images of this side
  void expect(Side side, double seconds) {
    if (approximate_) approximate_->setInterMessageLowerBound(side, ros::Duration(seconds));
  }

  void add(Side side, const sensor_msgs::ImageConstPtr& msg) {
    if (exact_) {
      side == kLeft ? exact_->add<0>(msg) : exact_->add<1>(msg);
    } else {
      side == kLeft ? approximate_->add<0>(msg) : approximate_->add<1>(msg);
    }
  }

 private:
  using Image = sensor_msgs::Image;
  using ExactTime = message_filters::sync_policies::ExactTime<Image, Image>;
  using ApproximateTime = message_filters::sync_policies::ApproximateTime<Image, Image>;

  std::unique_ptr<message_filters::Synchronizer<ExactTime>> exact_;
  std::unique_ptr<message_filters::Synchronizer<ApproximateTime>> approximate_;
};

PairSynchronizer::PairSynchronizer(const ros::NodeHandle& nh, const ros::NodeHandle& pnh,
                                   const FeatureMatcherParameters& parameters, Callback on_set)
    : on_set_(std::move(on_set)),
      queue_size_(static_cast<std::uint32_t>(parameters.queue_size)),
      approximate_sync_(parameters.approximate_sync),
      max_interval_(parameters.approximate_sync_max_interval),
      left_(
          nh, pnh, parameters, "left/",
          [this](const sensor_msgs::ImageConstPtr& msg, bool backwards) { receive(kLeft, msg, backwards); }),
      right_(nh, pnh, parameters, "right/", [this](const sensor_msgs::ImageConstPtr& msg, bool backwards) {
        receive(kRight, msg, backwards);
      }) {
  makeSynchronizer();
}

PairSynchronizer::~PairSynchronizer() { unsubscribe(); }

void PairSynchronizer::makeSynchronizer() {
  synchronizer_ = std::make_unique<Synchronizer>(approximate_sync_, queue_size_, max_interval_, complete_);
}

void PairSynchronizer::subscribe() {
  left_.subscribe();
  right_.subscribe();
}

void PairSynchronizer::unsubscribe() {
  left_.unsubscribe();
  right_.unsubscribe();
  restart_ = true;  // waiting images are dropped later, since this may be called within a callback
}

void PairSynchronizer::receive(Side side, const sensor_msgs::ImageConstPtr& msg, bool backwards) {
  if (backwards) (side == kLeft ? right_ : left_).restart();
  if (restart_.exchange(false) || backwards) makeSynchronizer();
  try {
    // Half the shortest time seen, since the next image may come sooner than those before.
    const double period = (side == kLeft ? left_ : right_).shortestPeriod();
    synchronizer_->expect(side, std::min(0.5 * period, kMaxPeriod));
    synchronizer_->add(side, msg);
  } catch (const std::exception&) {  // ros::Duration cannot hold the difference of two stamps
    makeSynchronizer();
  }
  std::vector<ImagePair> complete;
  complete.swap(complete_);
  for (ImagePair& pair : complete) {
    ImageSet set;
    set.left = std::move(pair.first);
    set.right = std::move(pair.second);
    set.left_mask = left_.mask();
    set.right_mask = right_.mask();
    set.left_calibration = left_.calibration(*set.left);
    set.right_calibration = right_.calibration(*set.right);
    ++n_sets_;
    on_set_(std::move(set));
  }
}

LiveSource::Inputs PairSynchronizer::inputs() const {
  return {{"left", left_.count()}, {"right", right_.count()}, {"pair", n_sets_}};
}

ImageSource::Counts PairSynchronizer::counts() const {
  Counts counts;
  counts.left = left_.count();
  counts.right = right_.count();
  counts.sets = n_sets_;
  return counts;
}

std::string PairSynchronizer::complaint() {
  const std::lock_guard<std::mutex> lock(period_mutex_);
  std::vector<std::string> parts;
  const std::size_t n_sets = n_sets_;
  const std::size_t max_periods = std::max(left_.periodCount(), right_.periodCount());
  if (max_periods >= kFewImages && max_periods >= 3 * (n_sets - n_sets_before_))
    parts.push_back(mismatch(n_sets - n_sets_before_));
  for (CameraInput* camera : {&left_, &right_}) {
    const std::string text = camera->complaint();
    if (!text.empty()) parts.push_back(text);
  }
  if (max_periods >= kFewImages ||
      !parts.empty()) {  // fewer images are counted on, or slow cameras would never be checked
    left_.newPeriod();
    right_.newPeriod();
    n_sets_before_ = n_sets;
  }
  return core::joinList(parts, ". ");
}

std::string PairSynchronizer::mismatch(std::size_t n_sets) const {
  std::string text = left_.describe("left") + " and " + right_.describe("right") + ", but only " +
                     std::to_string(n_sets) + " pairs";
  const double gap = medianGap(left_.recentStamps(), right_.recentStamps());
  if (std::isnan(gap)) return text;
  text += "; from a left stamp to the nearest right one it is " + core::formatNumber(gap) +
          " s (median). Remedies: equal stamps from cameras that are triggered together; ";
  if (!approximate_sync_) {
    text += "~approximate_sync with an ~approximate_sync_max_interval above that; ";
  } else if (max_interval_ > 0.0) {
    text += "a larger ~approximate_sync_max_interval, now " + core::formatNumber(max_interval_) + " s; ";
  }
  return text + "a larger ~queue_size if one camera's images come later than the other's";
}

}  // namespace corrsel
