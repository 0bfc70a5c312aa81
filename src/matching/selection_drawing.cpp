#include <algorithm>
#include <iterator>
#include <map>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

#include "corrsel/matching/match_drawing.h"
#include "matching/drawing_ground.h"

namespace corrsel::core {
namespace {

const cv::Scalar kPaper = cv::Scalar::all(232), kInk = cv::Scalar::all(20);
const cv::Scalar kRejected = cv::Scalar::all(15);
/// Wider pairs of images are put above each other.
constexpr double kWidestPair = 3.2;
constexpr double kLargestScale = 2;

/// Where both images lie in the picture, and by which factor they are scaled.
struct Layout {
  double scale = 1;
  cv::Rect left, right;
  cv::Size size;  ///< of both images together

  cv::Point2d leftPoint(const Correspondences& m, std::size_t i) const {
    return point(left, m.left_x[i], m.left_y[i]);
  }
  cv::Point2d rightPoint(const Correspondences& m, std::size_t i) const {
    return point(right, m.right_x[i], m.right_y[i]);
  }

 private:
  cv::Point2d point(const cv::Rect& image, float x, float y) const {
    return {image.x + scale * (x + 0.5) - 0.5, image.y + scale * (y + 0.5) - 0.5};
  }
};

Layout layoutOf(const cv::Size& left, const cv::Size& right, int picture_width) {
  const bool stacked = left.width + right.width > kWidestPair * std::max(left.height, right.height);
  const int width = stacked ? std::max(left.width, right.width) : left.width + right.width;
  const int gap = std::max(2, (picture_width > 0 ? picture_width : width) / 200);
  Layout layout;
  if (picture_width > 0)
    layout.scale = std::min(kLargestScale, static_cast<double>(picture_width - (stacked ? 0 : gap)) / width);
  const auto scaled = [&layout](int side) { return std::max(1, cvRound(layout.scale * side)); };
  layout.left = {0, 0, scaled(left.width), scaled(left.height)};
  layout.right = {0, 0, scaled(right.width), scaled(right.height)};
  (stacked ? layout.right.y : layout.right.x) = gap + (stacked ? layout.left.height : layout.left.width);
  layout.size = (layout.left | layout.right).size();
  return layout;
}

/// The grey image, pale enough for dark lines and dark enough for bright ones.
void place(const cv::Mat& image, cv::Mat target) {
  cv::Mat grey;
  cv::cvtColor(toColour(image), grey, cv::COLOR_BGR2GRAY);
  if (grey.depth() == CV_16U) grey.convertTo(grey, CV_8U, 1.0 / 257);
  if (grey.size() != target.size()) {
    const bool smaller = target.cols < grey.cols;
    cv::resize(grey, grey, target.size(), 0, 0, smaller ? cv::INTER_AREA : cv::INTER_LINEAR);
  }
  grey.convertTo(grey, CV_8U, 0.6, 45);
  cv::cvtColor(grey, target, cv::COLOR_GRAY2BGR);
}

/// Rows of one colour.
struct Class {
  std::vector<std::size_t> rows;
  cv::Scalar colour;
  std::string name;  ///< in the legend
};

/// At most `count` of the rows, evenly chosen.
std::vector<std::size_t> thinned(const std::vector<std::size_t>& rows, std::size_t count) {
  count = std::min(count, rows.size());
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < count; ++k) chosen.push_back(rows[k * rows.size() / count]);
  return chosen;
}

/// The rejected matches first, then the kept ones group by group.
std::vector<Class> classesOf(const Correspondences& matches, const Selection& selection) {
  Class rejected{{}, kRejected, "rejected"};
  std::map<std::uint32_t, Class> kept;  // unsigned, so that -1 comes last
  const bool grouped = !selection.group.empty();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (!drawable(matches, i)) continue;
    if (selection.mask[i] == 0) {
      rejected.rows.push_back(i);
      continue;
    }
    kept[grouped ? static_cast<std::uint32_t>(selection.group[i]) : 0U].rows.push_back(i);
  }
  std::vector<Class> classes = {rejected};
  for (auto& [key, members] : kept) {
    const auto group = static_cast<std::int32_t>(key);
    const bool labelled = group >= 0 && key < selection.motion.size();
    members.colour = labelled ? colourOf(group, selection.motion[key]) : selectionColour(group);
    members.name = !grouped || kept.size() == 1 ? "kept"
                   : group < 0                  ? "kept, in no group"
                                                : "group " + std::to_string(group + 1);
    if (labelled) members.name += ", " + inWords(selection.motion[key]);
    classes.push_back(members);
  }
  return classes;
}

class Picture {
 public:
  Picture(const Correspondences& matches, const Layout& layout, cv::Mat canvas)
      : matches_(matches), layout_(layout), canvas_(std::move(canvas)) {}

  /// Lines through which the image can be seen.
  /// @param opacity  1 = nothing is seen through them
  void lines(const std::vector<std::size_t>& rows, const cv::Scalar& colour, int thickness, double opacity) {
    cv::Mat drawn = canvas_.clone();
    for (const std::size_t i : rows) {
      cv::line(drawn, layout_.leftPoint(matches_, i), layout_.rightPoint(matches_, i), colour, thickness,
               cv::LINE_AA);
    }
    cv::addWeighted(drawn, opacity, canvas_, 1 - opacity, 0, canvas_);
  }

  void crosses(const std::vector<std::size_t>& rows, const cv::Scalar& colour, int size, double opacity) {
    cv::Mat drawn = canvas_.clone();
    for (const std::size_t i : rows) {
      for (const cv::Point2d& point : {layout_.leftPoint(matches_, i), layout_.rightPoint(matches_, i)})
        cv::drawMarker(drawn, point, colour, cv::MARKER_TILTED_CROSS, size, 1, cv::LINE_AA);
    }
    cv::addWeighted(drawn, opacity, canvas_, 1 - opacity, 0, canvas_);
  }

  void discs(const std::vector<std::size_t>& rows, const cv::Scalar& colour, int radius) {
    for (const std::size_t i : rows) {
      for (const cv::Point2d& point : {layout_.leftPoint(matches_, i), layout_.rightPoint(matches_, i)}) {
        cv::circle(canvas_, point, radius + 1, kInk, cv::FILLED, cv::LINE_AA);
        cv::circle(canvas_, point, radius, colour, cv::FILLED, cv::LINE_AA);
      }
    }
  }

 private:
  const Correspondences& matches_;
  const Layout& layout_;
  cv::Mat canvas_;
};

void drawClasses(const std::vector<Class>& classes, const Correspondences& matches, const Layout& layout,
                 std::size_t max_lines, const cv::Mat& canvas) {
  Picture picture(matches, layout, canvas);
  const int unit = std::max(1, cvRound(layout.size.width / 800.0));
  const Class& rejected = classes.front();
  picture.lines(thinned(rejected.rows, max_lines), kRejected, 1, 0.3);
  picture.crosses(rejected.rows, kRejected, 2 * unit + 1, 0.7);
  const std::size_t groups = std::max<std::size_t>(1, classes.size() - 1);
  for (auto kept = classes.begin() + 1; kept != classes.end(); ++kept)
    picture.lines(thinned(kept->rows, max_lines / groups), kept->colour, std::max(1, unit / 2), 0.6);
  for (auto kept = classes.begin() + 1; kept != classes.end(); ++kept)
    picture.discs(kept->rows, kept->colour, unit + 1);
}

std::string titleOf(const Selection& selection, std::size_t count) {
  std::string title = std::to_string(selection.n_selected) + " of " + std::to_string(count) + " matches kept";
  const std::string scene = inWords(selection.scene);
  if (!scene.empty()) title += ": " + scene;
  if (selection.status != Status::kOk) title += " (" + toString(selection.status) + ")";
  return title;
}

/// Text of the caption below the images.
class Caption {
 public:
  explicit Caption(int width) : width_(width) {
    height_ = std::max(12, width / 48);
    font_scale_ = cv::getFontScaleFromHeight(cv::FONT_HERSHEY_DUPLEX, std::max(7, 6 * height_ / 10));
    thickness_ = std::max(1, width / 1200);
  }

  void line() {
    x_ = margin();
    rows_++;
  }

  /// A line as in the picture: with discs for the kept matches, with crosses for the rejected ones.
  void sample(const cv::Scalar& colour, bool kept) {
    items_.push_back({"", colour, x_, rows_, kept});
    x_ += 5 * height_ / 2;
  }

  void text(const std::string& words) {
    items_.push_back({words, kInk, x_, rows_, false});
    x_ += widthOf(words) + height_;
  }

  /// Whether a sample with words fits into the line.
  bool fits(const std::string& words) const {
    return x_ + 5 * height_ / 2 + widthOf(words) < width_ - margin();
  }

  cv::Mat draw() const {
    cv::Mat strip(rows_ * 3 * height_ / 2 + height_ / 2, width_, CV_8UC3, kPaper);
    for (const Item& item : items_) {
      const int base = item.row * 3 * height_ / 2 - height_ / 2;
      if (!item.words.empty()) {
        cv::putText(strip, item.words, {item.x, base + height_ / 4}, cv::FONT_HERSHEY_DUPLEX, font_scale_,
                    item.colour, thickness_, cv::LINE_AA);
        continue;
      }
      drawSample(strip, item, base);
    }
    return strip;
  }

 private:
  struct Item {
    std::string words;
    cv::Scalar colour;
    int x, row;
    bool kept;
  };

  void drawSample(cv::Mat& strip, const Item& item, int y) const {
    const cv::Point from(item.x + height_ / 4, y), to(item.x + 7 * height_ / 4, y);
    const int radius = std::max(2, height_ / 5);
    if (!item.kept) {
      cv::line(strip, from, to, cv::Scalar::all(120), 1, cv::LINE_AA);
      for (const cv::Point& end : {from, to})
        cv::drawMarker(strip, end, item.colour, cv::MARKER_TILTED_CROSS, 2 * radius, thickness_, cv::LINE_AA);
      return;
    }
    cv::line(strip, from, to, kInk, 2 * thickness_ + 2, cv::LINE_AA);
    cv::line(strip, from, to, item.colour, 2 * thickness_, cv::LINE_AA);
    for (const cv::Point& end : {from, to}) {
      cv::circle(strip, end, radius + 1, kInk, cv::FILLED, cv::LINE_AA);
      cv::circle(strip, end, radius, item.colour, cv::FILLED, cv::LINE_AA);
    }
  }

  int margin() const { return height_; }
  int widthOf(const std::string& words) const {
    return cv::getTextSize(words, cv::FONT_HERSHEY_DUPLEX, font_scale_, thickness_, nullptr).width;
  }

  int width_, height_ = 0, thickness_ = 1, x_ = 0, rows_ = 0;
  double font_scale_ = 1;
  std::vector<Item> items_;
};

cv::Mat captionOf(const std::string& title, const std::vector<Class>& classes, int width) {
  Caption caption(width);
  caption.line();
  caption.text(title);
  caption.line();
  bool first = true;
  const auto add = [&](const Class& entry, bool kept) {
    if (entry.rows.empty()) return;
    const std::string words = entry.name + ": " + std::to_string(entry.rows.size());
    if (!first && !caption.fits(words)) caption.line();
    first = false;
    caption.sample(entry.colour, kept);
    caption.text(words);
  };
  for (auto kept = classes.begin() + 1; kept != classes.end(); ++kept) add(*kept, true);
  add(classes.front(), false);
  return caption.draw();
}

}  // namespace

cv::Scalar selectionColour(std::int32_t group) {
  if (group < 0) return cv::Scalar::all(255);
  const MatchColours colours;
  const cv::Scalar all[] = {groupColour(0),  groupColour(1), groupColour(2), groupColour(3),
                            colours.correct, colours.wrong,  colours.missed};
  return all[static_cast<std::size_t>(group) % std::size(all)];
}

std::string inWords(SceneKind scene) {
  switch (scene) {
    case SceneKind::kNothing:
      return "nothing in common beyond chance";
    case SceneKind::kAtRest:
      return "the same view, nothing has moved";
    case SceneKind::kPlaneOrRotation:
      return "a plane, or a camera that only turns";
    case SceneKind::kRigid:
      return "a rigid scene with depth";
    case SceneKind::kSeveralMotions:
      return "several motions";
    case SceneKind::kUnknown:
      break;
  }
  return "";
}

std::string inWords(GroupMotion motion) {
  return motion == GroupMotion::kUnknown ? "not known whether moving" : toString(motion);
}

cv::Mat drawSelection(const cv::Mat& left_image, const cv::Mat& right_image, const Correspondences& matches,
                      const Selection& selection, const SelectionDrawingOptions& options) {
  const std::size_t rows = selection.mask.size(), groups = selection.group.size();
  if (rows != matches.size() || (groups != 0 && groups != rows)) {
    throw std::invalid_argument("the selection is of " + std::to_string(rows) + " matches, but there are " +
                                std::to_string(matches.size()) +
                                "; give the matches that the selector was given");
  }
  if (options.width < 0) {
    throw std::invalid_argument("width is " + std::to_string(options.width) +
                                "; valid: 0 (that of the images) or more, px");
  }
  const cv::Mat left = imageOrGround(left_image, matches.left_size, matches.left_x, matches.left_y);
  const cv::Mat right = imageOrGround(right_image, matches.right_size, matches.right_x, matches.right_y);
  const Layout layout = layoutOf(left.size(), right.size(), options.width);
  cv::Mat images(layout.size, CV_8UC3, kInk);
  place(left, images(layout.left));
  place(right, images(layout.right));
  const std::vector<Class> classes = classesOf(matches, selection);
  drawClasses(classes, matches, layout, options.max_lines, images);
  const std::string title = options.title.empty() ? titleOf(selection, matches.size()) : options.title;
  cv::Mat picture;
  cv::vconcat(images, captionOf(title, classes, images.cols), picture);
  return picture;
}

}  // namespace corrsel::core
