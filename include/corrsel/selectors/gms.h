#pragma once

#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct GmsOptions : ConfidenceOptions {
  double alpha = 4.0;     ///< threshold factor: the paper's 4; the authors' code uses 6
  int grid = 20;          ///< cells per side of the left grid
  bool rotation = false;  ///< try 8 rotations of the neighbourhood, 45 degrees apart
  bool scale = false;     ///< try 5 sizes of the right grid: 1, 1/2, 1/sqrt(2), sqrt(2), 2
  bool drop_first_cells =
      false;  ///< leave out the first half cells of shifted grids, as the authors' header does

  void visit(OptionVisitor& visitor) const override;
};

/// Grid-based motion statistics.
///
/// Idea: correct matches move together with their neighbours, outliers do not. A match is kept if enough
/// other matches connect the same two regions of the images.
///
/// Algorithm: both images are divided into cells. For each left cell i, the right cell j that receives
/// most of its matches is tested. S_ij is the number of matches between the 3x3 neighbourhoods of i and j,
/// counted cell by cell; n_i is the mean number of matches per cell in the neighbourhood of i, without
/// cells off the grid. The pair of cells is accepted if S_ij >= alpha * sqrt(n_i), and all matches between
/// accepted cells are selected. The results of four grids, each shifted by half a cell, are united. With
/// `rotation` or `scale`, the variant that selects most matches wins; among equals, the first one.
///
/// Input: coordinates and the sizes of both images. GMS is made for thousands of evenly spread matches.
/// When there are few, two matches that agree in neighbouring cells already pass, and a single one never
/// does.
///
/// Presets: `rotation`, `scale` and `rotation_scale` switch on the options of these names.
///
/// Failure: without an image size the status is `unsupported_input`. Points more than one pixel outside
/// their image are rejected. There is no score.
///
/// Cost: O(N * shifts * scales + cells * rotations) time and O(N + grid * right cells) memory in the
/// workspace; the counts of the plain form take 0.15 MB.
///
/// Source: Bian et al., CVPR 2017; the paper's section on GMS. The paper's text averages the counts of
/// pairs of cells, the authors' code those of left cells; this is the code's rule.
class GmsSelector : public SelectorWithOptions<GmsOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "gms"; }
  Presets presets() const override;

 protected:
  std::string missingInput(const Correspondences& matches) const override;
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
