#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// Colours (BGR) that colour-blind people can distinguish (Okabe and Ito 2008).
struct MatchColours {
  cv::Scalar correct{115, 158, 0};    ///< bluish green: selected and correct
  cv::Scalar wrong{0, 94, 213};       ///< vermillion: selected and wrong
  cv::Scalar missed{178, 114, 0};     ///< blue: correct but not selected
  cv::Scalar selected{66, 228, 240};  ///< yellow: selected, ground truth unknown
  cv::Scalar moving{167, 121, 204};   ///< reddish purple: selected, of a group that moves by itself
};

/// The colour of a group of matches (BGR), different from those that state whether a match is correct. There
/// are five, which are used in turn.
cv::Scalar groupColour(std::int32_t group);

/// Draws both images side by side with lines between matched points. An empty image is replaced by a plain
/// one of the size that the matches state, or, if that is unknown, one that holds all points.
/// @param errors    ground-truth errors in px, as long as the mask, or empty: truth unknown
/// @param tolerance  matches with error <= tolerance count as correct, px
/// @param max_lines  largest number of lines of each class; others are left out evenly, so that the picture
/// stays readable
/// @param group     numbers as in Selection::group, or empty. The points of matches of a group are discs
/// above
///                  all lines in the colour of the group; lines have it where the truth is unknown
/// @param motion    as Selection::motion, or empty. Moving groups have MatchColours::moving, and no other
///                  group has it
/// @return 8-bit BGR, height of the taller image, widths added
cv::Mat drawMatches(const cv::Mat& left, const cv::Mat& right, const Correspondences& matches,
                    const std::vector<std::uint8_t>& mask, const std::vector<double>& errors,
                    double tolerance, std::size_t max_lines = 200,
                    const std::vector<std::int32_t>& group = {}, const std::vector<GroupMotion>& motion = {});

struct SelectionDrawingOptions {
  /// Of the picture, px, to which the images are reduced or enlarged, but at most twice; 0 = they stay as
  /// they are.
  int width = 1600;
  std::size_t max_lines = 100;  ///< of the kept and of the rejected matches each; their points are all drawn
  std::string title;  ///< first line of the caption; empty: what drawSelection() found in `selection`
};

/// Draws a selection for people: grey images, above them thin dark lines and crosses of the rejected matches,
/// and above these the lines and discs of the kept ones, in the colours of their groups. A caption below
/// states what was found and explains the colours, and where the motion of the groups is known, which of them
/// move by themselves (in MatchColours::moving, which no other group then has); it stays readable where the
/// picture is reduced to a third. Images that are wide and flat are put above each other, others side by
/// side.
///
/// The parameters that drawMatches() has too mean the same here.
/// @param selection  of these matches
/// @return 8-bit BGR
/// Throws std::invalid_argument where the selection is not of these matches, naming both numbers, and for a
/// negative width.
cv::Mat drawSelection(const cv::Mat& left, const cv::Mat& right, const Correspondences& matches,
                      const Selection& selection, const SelectionDrawingOptions& options = {});

/// The colour (BGR) in which drawSelection() shows the kept matches of a group; seven are used in turn. That
/// of group 0 is also that of all kept matches of a selection without groups; -1 is kept without a group.
cv::Scalar selectionColour(std::int32_t group);

/// A few words on a scene, for people: "a plane, or a camera that only turned". Empty for kUnknown.
std::string inWords(SceneKind scene);

/// What a group of matches does, for people: "moving".
std::string inWords(GroupMotion motion);

}  // namespace corrsel::core
