#pragma once

// The kernels of one level, as the level_*.cpp files compile them.

#include "kernels/affine_kernels.h"
#include "kernels/area_ratio_kernels.h"
#include "kernels/binary_kernels.h"
#include "kernels/corner_kernels.h"
#include "kernels/descriptor_kernels.h"
#include "kernels/field_kernels.h"
#include "kernels/five_point_kernels.h"
#include "kernels/grid_kernels.h"
#include "kernels/hessian_kernels.h"
#include "kernels/kernels.h"
#include "kernels/normal_kernels.h"
#include "kernels/orientation_kernels.h"
#include "kernels/pair_kernels.h"
#include "kernels/patch_kernels.h"
#include "kernels/pixel_kernels.h"
#include "kernels/pose_kernels.h"
#include "kernels/residual_kernels.h"
#include "kernels/scale_space_kernels.h"
#include "kernels/shrink_kernels.h"
#include "kernels/support_kernels.h"
#include "kernels/unproject_kernels.h"
#include "kernels/view_kernels.h"

namespace corrsel::core {

extern const Kernels kPlainKernels, kBaselineKernels, kAvx2Kernels, kAvx512Kernels, kAvx512VnniKernels;

namespace {

constexpr Kernels kTable = {
    {{errorsKernel<Transfer>, errorsKernel<SymmetricTransfer>, errorsKernel<Sampson>,
      errorsKernel<SmallerTransfer>, errorsKernel<TangentSampson>},
     {scoreKernel<Transfer>, scoreKernel<SymmetricTransfer>, scoreKernel<Sampson>,
      scoreKernel<SmallerTransfer>, scoreKernel<TangentSampson>},
     {normalKernel<Transfer, TransferTerms>, normalKernel<SymmetricTransfer, TransferTerms>,
      normalKernel<Sampson, SampsonTerms>, normalKernel<SmallerTransfer, TransferTerms>},
     pixelErrorsKernel<PixelTransfer>,
     pixelErrorsKernel<PixelSampson>},
    {factorKernel, gramKernel, fieldResidualsKernel, posteriorsKernel},
    {imageCellsKernel, countPairsKernel, verifyKernel<1>, verifyKernel<8>, voteKernel, countVotesKernel},
    {pointCellsKernel, anyNearestKernel, commonKernel},
    {{pairBlockKernel<RatioOfDistances>, pairBlockKernel<DifferenceOfDistances>, pairBlockKernel<Payoff>},
     {pairConflictsKernel<RatioOfDistances>, pairConflictsKernel<DifferenceOfDistances>},
     pairRowKernel<Payoff>,
     pairProductKernel},
    kDescriptorKernels,
    {supportKernel<2>, supportKernel<1>, aroundKernel<2>, aroundKernel<1>, affineGainsKernel,
     supportersKernel},
    {filterColumnsKernel, filterRowKernel, doubleRowKernel, subtractRowsKernel, extremaKernel},
    {orientationKernel},
    {samplePatchKernel, sampleClampedKernel, blurRowsKernel, blurColumnsKernel, momentsKernel,
     filterPatchKernel, filterUprightKernel, directionsKernel, describeKernel},
    {shrinkColumnsKernel, shrinkRowsKernel, smoothRowsKernel, smoothColumnsKernel},
    {cornerScoresKernel, cornerMaximaKernel, structureKernel},
    {centroidKernel, binaryTestsKernel},
    {hessianResponsesKernel, hessianExtremaKernel},
    {sampleLineKernel},
    {countKernel, aroundSeedKernel},
    {areaRatioKernel},
    {poseErrorsKernel, poseSumsKernel, poseSidesKernel},
    {{unprojectKernel<PlainPinholeLens>, unprojectKernel<PinholeLens<false>>,
      unprojectKernel<PinholeLens<true>>, unprojectKernel<FisheyeLens>,
      unprojectKernel<EquirectangularLens>}},
    {fivePointKernel},
};

}  // namespace
}  // namespace corrsel::core
