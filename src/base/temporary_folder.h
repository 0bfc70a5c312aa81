#pragma once

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

namespace corrsel::core {

/// A new, empty folder that is removed at the end with all that is in it.
class TemporaryFolder {
 public:
  /// @param name  the folder is called like it, with six random characters appended
  /// Throws std::runtime_error where no folder can be made.
  explicit TemporaryFolder(const std::string& name) {
    namespace fs = std::filesystem;
    std::string path = (fs::temp_directory_path() / (name + "_XXXXXX")).string();
    if (::mkdtemp(path.data()) == nullptr) {
      throw std::runtime_error("cannot create a temporary folder in " + fs::temp_directory_path().string() +
                               "; set TMPDIR to a folder that can be written");
    }
    path_ = path;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace corrsel::core
