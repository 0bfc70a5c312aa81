#include "search/model.h"

#include "search/fundamental_model.h"
#include "search/homography_model.h"

namespace corrsel::core {

bool Model::escapeDegeneracy(const Verifier&, const std::uint32_t*, DegeneracyMemory&, Candidate&) const {
  return false;
}

void Model::solveBatch(const NormalizedMatches& matches, Hypotheses* batch, int count) const {
  for (int k = 0; k < count; ++k) batch[k].count = solve(matches, batch[k].sample, batch[k].models);
}

const Model& modelOf(ModelKind kind, ConsensusOptions::Error error) {
  static const FundamentalModel fundamental;
  static const HomographyModel transfer(Residual::kTransfer), symmetric(Residual::kSymmetricTransfer),
      smaller(Residual::kSmallerTransfer);
  if (kind == ModelKind::kFundamental) return fundamental;
  if (error == ConsensusOptions::Error::kTransfer) return transfer;
  return error == ConsensusOptions::Error::kSymmetricTransfer ? symmetric : smaller;
}

}  // namespace corrsel::core
