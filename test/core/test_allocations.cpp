#include <gtest/gtest.h>
#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "search/local_support.h"
#include "test_support.h"

namespace {

std::atomic<bool> counting{false};
std::atomic<int> allocations{0};
std::atomic<std::ptrdiff_t> live_bytes{0};

void* counted(std::size_t size, std::size_t alignment) {
  if (counting) ++allocations;
  // The size of aligned memory must be a multiple of the alignment.
  void* const memory = alignment > 0
                           ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)
                           : std::malloc(size > 0 ? size : 1);
  if (memory == nullptr) throw std::bad_alloc();
  live_bytes += static_cast<std::ptrdiff_t>(malloc_usable_size(memory));
  return memory;
}

/// Not inlined: GCC would take free() for the wrong partner of operator new.
[[gnu::noinline]] void release(void* memory) {
  live_bytes -= static_cast<std::ptrdiff_t>(malloc_usable_size(memory));
  std::free(memory);
}

}  // namespace

void* operator new(std::size_t size) { return counted(size, 0); }
void* operator new[](std::size_t size) { return counted(size, 0); }
void* operator new(std::size_t size, std::align_val_t a) { return counted(size, std::size_t(a)); }
void* operator new[](std::size_t size, std::align_val_t a) { return counted(size, std::size_t(a)); }
void operator delete(void* memory) noexcept { release(memory); }
void operator delete[](void* memory) noexcept { release(memory); }
void operator delete(void* memory, std::size_t) noexcept { release(memory); }
void operator delete[](void* memory, std::size_t) noexcept { release(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }

namespace corrsel::core {
namespace {

using namespace testing;

/// Heap allocations of one selection.
int allocationsOf(const Selector& selector, const Correspondences& matches) {
  allocations = 0;
  counting = true;
  const Selection selection = selector.select(matches);
  counting = false;
  EXPECT_EQ(selection.status, Status::kOk) << selection.message;
  EXPECT_GT(selection.n_selected, 0u);
  return allocations;
}

/// Selectors "name" or "name:preset" that keep their memory between calls.
class Allocations : public ::testing::TestWithParam<std::string> {};

TEST_P(Allocations, AreFewAfterTheFirstCallOfASize) {
  const auto selector = createSelector(GetParam());
  for (const std::size_t n : {1000, 5000}) {
    const Correspondences matches = homographyScene({n, 0.5, 1.0, 1}).matches;
    selector->select(matches);
    const int again = allocationsOf(*selector, matches);
    EXPECT_LE(again, 8) << n << " matches";
    EXPECT_GE(again, 1) << "the mask at least: nothing is counted";
  }
  // Smaller inputs find the memory there.
  EXPECT_LE(allocationsOf(*selector, homographyScene({2000, 0.5, 1.0, 2}).matches), 8);
}

/// Selectors that keep memory between calls, whose matrices may be allocated anew.
class KeptMemory : public Allocations {};

TEST_P(KeptMemory, BelongsToTheWorkspaceThatIsGiven) {
  const auto selector = createSelector(GetParam());
  Scene scene = homographyScene({3000, 0.5, 1.0, 1});
  addFrames(scene);
  const Correspondences& matches = scene.matches;
  Workspace::ofThread().release();
  const std::ptrdiff_t before = live_bytes;
  Workspace workspace;
  const Selection selection = selector->select(matches, workspace);
  const std::ptrdiff_t of_selection = static_cast<std::ptrdiff_t>(
      selection.mask.capacity() + selection.score.capacity() * sizeof(float) +
      selection.group.capacity() * sizeof(std::int32_t) + selection.probability.capacity() * sizeof(float) +
      selection.message.capacity());
  EXPECT_GT(live_bytes, before + of_selection + 10 * 3000);
  workspace.release();
  EXPECT_LE(live_bytes, before + of_selection + 256) << "not given back, or given to the thread";
  const Selection anew = selector->select(matches, workspace);
  EXPECT_EQ(anew.mask, selection.mask);
  EXPECT_EQ(anew.score, selection.score);
}

TEST(SamplersMemory, IsKeptFromCallToCall) {
  const Correspondences matches = homographyScene({3000, 0.5, 1.0, 1}).matches;
  for (const char* const sampler : {"uniform", "prosac", "local"}) {
    const auto selector = createSelector("ransac", {{"sampler", sampler}});
    selector->select(matches);
    EXPECT_LE(allocationsOf(*selector, matches), 8) << sampler;
  }
  for (const char* const name : {"pnapsac", "multigs", "mlesac"}) {
    const auto selector = createSelector(name);
    selector->select(matches);
    EXPECT_LE(allocationsOf(*selector, matches), 8) << name;
  }
}

TEST(LocalSupportMemory, IsKeptFromCallToCall) {
  Scene scene = homographyScene({3000, 0.5, 1.0, 1});
  addFrames(scene);
  std::vector<std::uint32_t> order(3000);
  std::iota(order.begin(), order.end(), 0U);
  LocalSupport support;
  support.compute(scene.matches, order);
  ASSERT_GT(support.localSize(), 1000u);
  allocations = 0;
  counting = true;
  support.compute(scene.matches, order);
  counting = false;
  EXPECT_LE(allocations, 3) << "the sort of the survivors, at most";
}

std::string testName(const ::testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), ':', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(All, Allocations,
                         ::testing::Values("nnsr", "ransac:h", "ransac:f", "usac:h", "usac:f", "vfc",
                                           "vfc:sparse", "vfc:guided", "gms", "gms:rotation_scale", "lpm",
                                           "lpm:v1", "lpm:v2", "lpm:guided", "acransac:h", "acransac:f",
                                           "planes", "auto", "auto:f", "laf", "laf:guided", "adalam", "icf",
                                           "significant", "lap", "ranks", "rfm_scan"),
                         testName);

INSTANTIATE_TEST_SUITE_P(All, KeptMemory,
                         ::testing::Values("ransac:h", "usac:f", "vfc", "gms", "lpm", "acransac", "auto",
                                           "st", "gtm", "laf", "frame_votes", "gaim", "logos", "adalam",
                                           "icf", "rfm_scan"),
                         testName);

}  // namespace
}  // namespace corrsel::core
