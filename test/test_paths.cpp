#include "test_paths.h"

#include <cstdlib>

namespace corrsel::testing {

std::string sourceDir() { return CORRSEL_SOURCE_DIR; }

std::string develDir() { return CORRSEL_DEVEL_DIR; }

std::string realDataDir() {
  const char* const set = std::getenv("CORRSEL_TEST_DATA");
  return set ? set : CORRSEL_SHARED_DATA_DIR;
}

}  // namespace corrsel::testing
