#pragma once

#include <memory>
#include <string>

#include "corrsel/correspondences.h"
#include "corrsel/database/two_view_geometry.h"
#include "corrsel/selection.h"
#include "corrsel/selectors/selector.h"
#include "corrsel/workspace.h"

namespace corrsel::core {

struct PairCameras {
  Camera first, second;
};

/// Selects the inliers of a pair and finds the relation that explains most of them, as described at
/// PairVerifier.
class CompetingModels {
 public:
  /// @param selector   as in createSelector()
  /// @param common     options that every selector gets if it has them
  /// @param threshold  of epipolar relations, px
  CompetingModels(const std::string& selector, const OptionMap& common, double threshold);

  /// The selection with a model, if there is one, and with a confidence.
  /// @param matches  without cameras
  Selection select(const Correspondences& matches, Workspace& workspace) const;

  /// The relation of a selection of select(), without inliers.
  /// @param cameras    of both images, or nullptr
  /// @param selection  its mask, model and probabilities are replaced where another relation explains more
  TwoViewGeometry geometryOf(const Correspondences& matches, const PairCameras* cameras, Workspace& workspace,
                             Selection& selection) const;

 private:
  void addPose(const Correspondences& matches, const PairCameras& cameras, Workspace& workspace,
               Selection& selection, TwoViewGeometry& geometry) const;
  void takeEssential(const Correspondences& kept, const PoseResult& found, Selection& selection,
                     TwoViewGeometry& geometry) const;

  std::unique_ptr<Selector> selector_, automatic_, fundamental_, pose_;
  double threshold_;
};

}  // namespace corrsel::core
