#include "datasets/adelaide_rmf.h"

#include <matio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>

#include "datasets/files.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRemedy = "copy the file again from the original dataset";

struct CloseMat {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using MatFile = std::unique_ptr<mat_t, CloseMat>;
using Variable = std::unique_ptr<matvar_t, FreeVariable>;

const char* className(matio_classes type) {
  switch (type) {
    case MAT_C_EMPTY:
      return "empty";
    case MAT_C_CELL:
      return "cell";
    case MAT_C_STRUCT:
      return "struct";
    case MAT_C_OBJECT:
      return "object";
    case MAT_C_CHAR:
      return "char";
    case MAT_C_SPARSE:
      return "sparse";
    case MAT_C_DOUBLE:
      return "double";
    case MAT_C_SINGLE:
      return "single";
    case MAT_C_INT8:
      return "int8";
    case MAT_C_UINT8:
      return "uint8";
    case MAT_C_INT16:
      return "int16";
    case MAT_C_UINT16:
      return "uint16";
    case MAT_C_INT32:
      return "int32";
    case MAT_C_UINT32:
      return "uint32";
    case MAT_C_INT64:
      return "int64";
    case MAT_C_UINT64:
      return "uint64";
    case MAT_C_FUNCTION:
      return "function";
    case MAT_C_OPAQUE:
      return "opaque";
  }
  return "unknown";
}

/// One field of a .mat file with its data in memory.
class Field {
 public:
  Field(const std::string& path, const std::string& name, Variable variable)
      : path_(path), name_(name), variable_(std::move(variable)) {
    for (int i = 0; i < variable_->rank; ++i) count_ *= variable_->dims[i];
  }

  [[noreturn]] void fail(const std::string& fault) const {
    throw DatasetError(path_ + ": field '" + name_ + "' " + fault + "; " + kRemedy);
  }

  std::size_t count() const { return count_; }
  int rank() const { return variable_->rank; }
  std::size_t dim(int i) const { return variable_->dims[i]; }

  /// Class and shape, e.g. "6x241 double".
  std::string description() const {
    std::string text;
    for (int i = 0; i < variable_->rank; ++i) text += (i ? "x" : "") + std::to_string(variable_->dims[i]);
    return text + " " + className(variable_->class_type);
  }

  /// All values in MATLAB's column-major order.
  std::vector<double> numbers() const {
    if (variable_->isComplex) fail("is complex, real numbers expected");
    switch (variable_->class_type) {
      case MAT_C_DOUBLE:
        return convert<double>();
      case MAT_C_SINGLE:
        return convert<float>();
      case MAT_C_INT8:
        return convert<std::int8_t>();
      case MAT_C_UINT8:
        return convert<std::uint8_t>();
      case MAT_C_INT16:
        return convert<std::int16_t>();
      case MAT_C_UINT16:
        return convert<std::uint16_t>();
      case MAT_C_INT32:
        return convert<std::int32_t>();
      case MAT_C_UINT32:
        return convert<std::uint32_t>();
      case MAT_C_INT64:
        return convert<std::int64_t>();
      case MAT_C_UINT64:
        return convert<std::uint64_t>();
      default:
        fail("is " + description() + ", numbers expected");
    }
  }

  /// Bytes of a uint8 array in MATLAB's column-major order.
  const std::uint8_t* bytes() const {
    if (variable_->class_type != MAT_C_UINT8 || variable_->isComplex) {
      fail("is " + description() + ", uint8 expected");
    }
    return values<std::uint8_t>();
  }

 private:
  template <typename T>
  const T* values() const {
    if (variable_->data_size != static_cast<int>(sizeof(T)) || variable_->nbytes < count_ * sizeof(T)) {
      fail("has fewer bytes than its shape " + description() + " requires");
    }
    return static_cast<const T*>(variable_->data);
  }

  template <typename T>
  std::vector<double> convert() const {
    const T* const first = values<T>();
    std::vector<double> numbers(count_);
    std::transform(first, first + count_, numbers.begin(),
                   [](T value) { return static_cast<double>(value); });
    return numbers;
  }

  std::string path_, name_;
  Variable variable_;
  std::size_t count_ = 1;
};

/// Throws DatasetError when a version 5 file ends before its last element does. libmatio may take such a file
/// for one that has fewer fields.
void checkLength(const std::string& path) {
  constexpr std::uint64_t kHeaderLength = 128;  // bytes; the last two give the byte order
  std::ifstream stream(path, std::ios::binary);
  std::array<unsigned char, kHeaderLength> header{};
  stream.read(reinterpret_cast<char*>(header.data()), header.size());
  const bool little_endian = header[126] == 'I';
  const std::uint64_t length = fs::file_size(path);
  std::uint64_t end = kHeaderLength;
  while (end < length) {
    std::array<unsigned char, 8> tag{};  // element type and number of bytes that follow
    stream.seekg(static_cast<std::streamoff>(end));
    stream.read(reinterpret_cast<char*>(tag.data()), tag.size());
    std::uint64_t bytes = 0;
    for (int i = 0; i < 4; ++i) bytes = bytes << 8 | tag[little_endian ? 7 - i : 4 + i];
    end += tag.size() + bytes;
  }
  if (end > length) {
    throw DatasetError(path + ": is cut off or damaged, it has " + std::to_string(length) + " of " +
                       std::to_string(end) + " bytes; " + kRemedy);
  }
}

/// Reads a field, or gives null where the file has none of that name.
std::unique_ptr<Field> readOptionalField(mat_t* file, const std::string& path, const std::string& name) {
  Variable variable(Mat_VarReadInfo(file, name.c_str()));
  if (!variable) return nullptr;
  const int error = Mat_VarReadDataAll(file, variable.get());
  if (error != 0 || (variable->data == nullptr && variable->nbytes > 0)) {
    throw DatasetError(path + ": field '" + name + "' cannot be read, the file is cut off or damaged; " +
                       kRemedy);
  }
  return std::make_unique<Field>(path, name, std::move(variable));
}

std::unique_ptr<Field> readField(mat_t* file, const std::string& path, const std::string& name) {
  std::unique_ptr<Field> field = readOptionalField(file, path, name);
  if (!field) throw DatasetError(path + ": field '" + name + "' is missing; " + kRemedy);
  return field;
}

cv::Mat toImage(const Field& field) {
  const bool colour = field.rank() == 3 && field.dim(2) == 3;
  const bool grey = field.rank() == 2 || (field.rank() == 3 && field.dim(2) == 1);
  if (!(colour || grey) || field.count() == 0) {
    field.fail("is " + field.description() + ", an image HxW or HxWx3 of class uint8 expected");
  }
  const std::uint8_t* const bytes = field.bytes();
  const int rows = static_cast<int>(field.dim(0));
  const int cols = static_cast<int>(field.dim(1));
  const std::size_t plane = field.dim(0) * field.dim(1);
  if (grey) {
    cv::Mat image(rows, cols, CV_8UC1);
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < cols; ++x) image.at<std::uint8_t>(y, x) = bytes[std::size_t(x) * rows + y];
    }
    return image;
  }
  cv::Mat image(rows, cols, CV_8UC3);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < cols; ++x) {
      const std::uint8_t* const red = bytes + std::size_t(x) * rows + y;
      image.at<cv::Vec3b>(y, x) = {red[2 * plane], red[plane], red[0]};
    }
  }
  return image;
}

Correspondences toMatches(const Field& field) {
  if (field.rank() != 2 || field.dim(0) != 6) {
    field.fail("is " + field.description() + ", 6xN expected (x1 y1 1 x2 y2 1)");
  }
  const std::vector<double> numbers = field.numbers();
  Correspondences matches;
  for (std::size_t i = 0; i < field.dim(1); ++i) {
    const double* const column = &numbers[6 * i];
    if (column[2] != 1.0 || column[5] != 1.0) {
      field.fail("has a column (number " + std::to_string(i + 1) +
                 ") whose third and sixth rows are not 1, x1 y1 1 x2 y2 1 expected");
    }
    matches.add({static_cast<float>(column[0]), static_cast<float>(column[1])},
                {static_cast<float>(column[3]), static_cast<float>(column[4])});
  }
  return matches;
}

/// The values of a field that has one per match.
std::vector<double> numbersPerMatch(const Field& field, std::size_t matches) {
  if (field.count() != matches) {
    field.fail("has " + std::to_string(field.count()) + " values (" + field.description() + ") for " +
               std::to_string(matches) + " matches in 'data'");
  }
  return field.numbers();
}

std::vector<std::uint32_t> toLabels(const Field& field, std::size_t matches) {
  std::vector<std::uint32_t> labels;
  for (const double value : numbersPerMatch(field, matches)) {
    if (!(value >= 0.0 && value <= std::numeric_limits<std::uint32_t>::max() && value == std::floor(value))) {
      field.fail("has the value " + std::to_string(value) + ", whole numbers from 0 expected");
    }
    labels.push_back(static_cast<std::uint32_t>(value));
  }
  return labels;
}

}  // namespace

AdelaideRmfReader::AdelaideRmfReader(const std::string& name, const std::string& root) : name_(name) {
  const std::string remedy = "set the path to the folder that holds the .mat files";
  requireFolder(root, "dataset '" + name + "'", remedy);
  for (const std::string& file : fileNames(root)) {
    const fs::path path = fs::path(root) / file;
    if (path.extension() == ".mat") files_.push_back(path.string());
  }
  if (files_.empty()) {
    throw DatasetError("dataset '" + name + "': '" + root + "' has no .mat file; " + remedy);
  }
}

PairId AdelaideRmfReader::id(std::size_t index) const {
  return {name_, fs::path(files_.at(index)).stem().string(), "1-2"};
}

ImagePair AdelaideRmfReader::read(std::size_t index) const {
  ImagePair pair;
  pair.id = id(index);
  const std::string& path = files_.at(index);
  const MatFile file(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
  if (!file) throw DatasetError(path + ": is not a readable MATLAB file; " + kRemedy);
  if (Mat_GetVersion(file.get()) == MAT_FT_MAT5) checkLength(path);

  pair.left = toImage(*readField(file.get(), path, "img1"));
  pair.right = toImage(*readField(file.get(), path, "img2"));

  Correspondences matches = toMatches(*readField(file.get(), path, "data"));
  matches.left_size = pair.left.size();
  matches.right_size = pair.right.size();
  pair.truth.kind = TruthKind::kLabels;
  pair.truth.labels = toLabels(*readField(file.get(), path, "label"), matches.size());
  if (const std::unique_ptr<Field> score = readOptionalField(file.get(), path, "score")) {
    const std::vector<double> scores = numbersPerMatch(*score, matches.size());
    matches.distance.assign(scores.begin(), scores.end());
  }
  pair.given = std::move(matches);
  return pair;
}

}  // namespace corrsel::core
