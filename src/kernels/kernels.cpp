#include "kernels/kernels.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <stdexcept>

#include "base/text.h"

namespace corrsel::core {

#if defined(__x86_64__)
extern const Kernels kAvx2Kernels, kAvx512Kernels, kAvx512VnniKernels;
#endif
extern const Kernels kPlainKernels, kBaselineKernels;

namespace {

const Kernels& tableOf(KernelLevel level) {
#if defined(__x86_64__)
  if (level == KernelLevel::kAvx512Vnni) return kAvx512VnniKernels;
  if (level == KernelLevel::kAvx512) return kAvx512Kernels;
  if (level == KernelLevel::kAvx2) return kAvx2Kernels;
#endif
  return level == KernelLevel::kPlain ? kPlainKernels : kBaselineKernels;
}

bool isSupported(KernelLevel level) {
  const std::vector<KernelLevel> levels = supportedKernelLevels();
  return std::find(levels.begin(), levels.end(), level) != levels.end();
}

KernelLevel initialLevel() {
  const std::vector<KernelLevel> levels = supportedKernelLevels();
  const char* const wanted = std::getenv("CORRSEL_KERNELS");
  if (wanted == nullptr || *wanted == '\0') return levels.back();
  std::vector<std::string> valid;
  for (const KernelLevel level : levels) {
    if (toString(level) == wanted) return level;
    valid.push_back(toString(level));
  }
  throw std::invalid_argument(std::string("environment variable CORRSEL_KERNELS = '") + wanted +
                              "' is not a kernel level of this machine" + validNames(wanted, valid));
}

std::atomic<KernelLevel>& currentLevel() {
  static std::atomic<KernelLevel> level{initialLevel()};
  return level;
}

}  // namespace

std::string toString(KernelLevel level) {
  switch (level) {
    case KernelLevel::kAvx512Vnni:
      return "avx512vnni";
    case KernelLevel::kAvx512:
      return "avx512";
    case KernelLevel::kAvx2:
      return "avx2";
    case KernelLevel::kBaseline:
      return "baseline";
    case KernelLevel::kPlain:
      break;
  }
  return "plain";
}

std::vector<KernelLevel> supportedKernelLevels() {
  std::vector<KernelLevel> levels = {KernelLevel::kPlain, KernelLevel::kBaseline};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) levels.push_back(KernelLevel::kAvx2);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) {
    levels.push_back(KernelLevel::kAvx512);
    if (__builtin_cpu_supports("avx512vnni") && __builtin_cpu_supports("avx512vpopcntdq") &&
        __builtin_cpu_supports("avx512vbmi")) {
      levels.push_back(KernelLevel::kAvx512Vnni);
    }
  }
#endif
  return levels;
}

KernelLevel kernelLevel() { return currentLevel(); }

void setKernelLevel(KernelLevel level) {
  if (!isSupported(level)) {
    throw std::invalid_argument("kernel level " + toString(level) + " is not supported by this processor");
  }
  currentLevel() = level;
}

const Kernels& kernels() { return tableOf(currentLevel()); }

}  // namespace corrsel::core
