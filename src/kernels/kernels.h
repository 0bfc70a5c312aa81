#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kernels/affine.h"
#include "kernels/area_ratio.h"
#include "kernels/binary.h"
#include "kernels/corner.h"
#include "kernels/descriptor.h"
#include "kernels/field.h"
#include "kernels/five_point.h"
#include "kernels/grid.h"
#include "kernels/hessian.h"
#include "kernels/orientation.h"
#include "kernels/pair.h"
#include "kernels/patch.h"
#include "kernels/pose.h"
#include "kernels/residual.h"
#include "kernels/scale_space.h"
#include "kernels/shrink.h"
#include "kernels/support.h"
#include "kernels/unproject.h"
#include "kernels/view.h"

namespace corrsel::core {

/// Instruction sets that the kernels are compiled for: kPlain is the portable form, with which tests compare
/// the others; kBaseline is SSE2 on x86-64 and NEON on ARM; kAvx512 is F, BW, DQ and VL, kAvx512Vnni that
/// with VNNI, VPOPCNTDQ and VBMI, which came together with Ice Lake and Zen 4.
enum class KernelLevel : std::uint8_t { kPlain, kBaseline, kAvx2, kAvx512, kAvx512Vnni };

std::string toString(KernelLevel level);

/// The levels that this build and this processor offer, lowest first.
std::vector<KernelLevel> supportedKernelLevels();

/// The level in use: the highest supported one, unless the environment variable CORRSEL_KERNELS (plain,
/// baseline, avx2, avx512 or avx512vnni) or setKernelLevel() selects another one. Throws
/// std::invalid_argument if the variable names a level that does not exist or that the processor lacks.
KernelLevel kernelLevel();

/// For tests and measurements. Throws std::invalid_argument for a level that is not supported.
void setKernelLevel(KernelLevel level);

/// The hot loops, one set per level. All levels give bit-identical results: they run the same operations in
/// the same order, without contraction, on vectors of different width.
struct Kernels {
  ResidualKernels residuals;
  FieldKernels field;
  GmsKernels gms;
  NeighbourKernels neighbours;
  PairKernels pairs;
  DescriptorKernels descriptors;
  SupportKernels support;
  ScaleSpaceKernels scale_space;
  OrientationKernels orientation;
  PatchKernels patches;
  ShrinkKernels shrink;
  CornerKernels corners;
  BinaryKernels binary;
  HessianKernels hessian;
  ViewKernels views;
  AffineKernels affine;
  AreaRatioKernels area_ratio;
  PoseKernels pose;
  UnprojectKernels rays;
  FivePointKernels five_point;
};

/// The kernels of the level in use. Throws like kernelLevel().
const Kernels& kernels();

}  // namespace corrsel::core
