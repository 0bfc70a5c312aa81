#include "benchmark/files.h"

#include <filesystem>
#include <fstream>

#include "corrsel/benchmark/results.h"

namespace corrsel::core {

bool forEachLine(const std::string& path, const std::function<void(const std::string&)>& use) {
  std::ifstream in(path, std::ios::binary);
  for (std::string line; std::getline(in, line);) {
    if (in.eof()) return false;  // without line end
    use(line);
  }
  return true;
}

void writeFile(const std::string& path, const std::string& text) {
  writeFile(path, [&text](std::ostream& out) { out << text; });
}

void writeFile(const std::string& path, const std::function<void(std::ostream&)>& write) {
  const std::string part = path + ".part";
  std::ofstream out(part, std::ios::binary | std::ios::trunc);
  write(out);
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(part, path, error);
  if (!out || error) {
    throw RunFolderError("cannot write " + path + ": check the permissions and the free space of its folder");
  }
}

void appendToFile(const std::string& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary | std::ios::app);
  out << text;
  out.close();
  if (!out) {
    throw RunFolderError("cannot write to " + path +
                         ": check the free space. What has been written stays valid: resume the run then");
  }
}

}  // namespace corrsel::core
