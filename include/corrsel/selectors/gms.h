#pragma once

#include <string>

#include "corrsel/selectors/presets.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct GmsOptions : OptionSet {
  double alpha = 4.0;     ///< threshold factor: the paper's 4; the authors' code uses 6
  int grid = 20;          ///< cells per side of the left grid
  bool rotation = false;  ///< try 8 rotations of the neighbourhood, 45 degrees apart
  bool scale = false;     ///< try 5 sizes of the right grid: 1, 1/2, 1/sqrt(2), sqrt(2), 2
  bool drop_first_cells =
      false;  ///< leave out the first half cells of shifted grids, as the authors' header does

  void visit(OptionVisitor& visitor) const override;
};

/// Grid-based motion statistics (Bian et al., CVPR 2017; the paper's section on GMS).
///
/// Both images are divided into cells. For each left cell i the right cell j that receives most of its
/// matches is tested: S = number of matches between the 3x3 neighbourhoods of i and j, cell by cell; accepted
/// if S >= alpha * sqrt(mean number of matches in i's neighbourhood). All matches between an accepted pair of
/// cells are selected; four half-cell shifts of the left grid are united. With rotation or scale the variant
/// that selects most wins, the first one among equals. Needs both image sizes; points more than one pixel
/// outside their image are rejected. Made for thousands of evenly spread matches: with few, two that agree in
/// neighbouring cells pass already, and one alone never does.
///
/// Presets: `rotation`, `scale`, `rotation_scale`. O(N * shifts * scales + cells * rotations) time,
/// O(N + grid * right cells) memory, kept per thread; 0.15 MB of counts in the plain form.
class GmsSelector : public Selector {
 public:
  explicit GmsSelector(GmsOptions options = {});
  static Presets presets();
  std::string name() const override { return "gms"; }
  const OptionSet& options() const override { return options_; }

 protected:
  std::string missingInput(const Correspondences& matches) const override;
  void run(const Correspondences& matches, Selection& result) const override;

 private:
  GmsOptions options_;
};

}  // namespace corrsel::core
