#include <gtest/gtest.h>
#include <matio.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <vector>

#include "datasets/adelaide_rmf.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;
using namespace testing;

/// A field to be written, with its values in column-major order.
struct FieldSpec {
  std::vector<std::size_t> dims;
  matio_classes class_type;
  matio_types data_type;
  std::vector<unsigned char> bytes;
};

template <typename T>
FieldSpec field(std::vector<std::size_t> dims, matio_classes class_type, matio_types data_type,
                const std::vector<T>& values) {
  const auto* const first = reinterpret_cast<const unsigned char*>(values.data());
  return {std::move(dims), class_type, data_type, {first, first + values.size() * sizeof(T)}};
}

FieldSpec doubles(std::vector<std::size_t> dims, const std::vector<double>& values) {
  return field(std::move(dims), MAT_C_DOUBLE, MAT_T_DOUBLE, values);
}

/// A folder with one file "pair.mat", removed at the end.
class AdelaideFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("corrsel_adelaide_" + std::to_string(::getpid()));
    fs::remove_all(root_);
    fs::create_directories(root_);
    // img1 is 2 rows x 3 columns in colour: red plane 0..5, green 10..15, blue 20..25, down the columns.
    fields_["img1"] = field<std::uint8_t>({2, 3, 3}, MAT_C_UINT8, MAT_T_UINT8,
                                          {0, 1, 2, 3, 4, 5, 10, 11, 12, 13, 14, 15, 20, 21, 22, 23, 24, 25});
    fields_["img2"] = field<std::uint8_t>({3, 2}, MAT_C_UINT8, MAT_T_UINT8, {1, 2, 3, 4, 5, 6});
    fields_["data"] = doubles({6, 2}, {1.5, 2, 1, 3, 4, 1, 5, 6, 1, 7, 8.25, 1});
    fields_["label"] = doubles({1, 2}, {0, 2});
    fields_["score"] = doubles({1, 2}, {100, 50});
  }

  void TearDown() override { fs::remove_all(root_); }

  void writeFile(matio_compression compression = MAT_COMPRESSION_NONE) {
    mat_t* const file = Mat_CreateVer(path().c_str(), nullptr, MAT_FT_MAT5);
    ASSERT_NE(file, nullptr);
    for (auto& [name, spec] : fields_) {
      matvar_t* const variable =
          Mat_VarCreate(name.c_str(), spec.class_type, spec.data_type, static_cast<int>(spec.dims.size()),
                        spec.dims.data(), spec.bytes.data(), 0);
      EXPECT_EQ(Mat_VarWrite(file, variable, compression), 0);
      Mat_VarFree(variable);
    }
    Mat_Close(file);
  }

  std::string path() const { return (root_ / "pair.mat").string(); }
  ImagePair read() const { return AdelaideRmfReader("adelaidermf", root_.string()).read(0); }

  /// Writes the file with one field replaced, which must be refused with a text that names both.
  void expectRefused(const std::string& name, const FieldSpec& replacement, const std::string& expected) {
    const FieldSpec good = fields_.at(name);
    fields_[name] = replacement;
    writeFile();
    fields_[name] = good;
    const std::string error = errorOf<DatasetError>([this] { read(); });
    EXPECT_TRUE(contains(error, path() + ": field '" + name + "'")) << error;
    EXPECT_TRUE(contains(error, expected)) << error;
  }

  fs::path root_;
  std::map<std::string, FieldSpec> fields_;
};

TEST_F(AdelaideFolder, ReadsAllFields) {
  for (const matio_compression compression : {MAT_COMPRESSION_NONE, MAT_COMPRESSION_ZLIB}) {
    writeFile(compression);
    const AdelaideRmfReader reader("adelaidermf", root_.string());
    ASSERT_EQ(reader.size(), 1u);
    EXPECT_EQ(reader.files(), std::vector<std::string>{path()});
    EXPECT_EQ(reader.id(0).text(), "adelaidermf/pair/1-2");

    const ImagePair pair = reader.read(0);
    ASSERT_EQ(pair.left.type(), CV_8UC3);
    ASSERT_EQ(pair.left.size(), cv::Size(3, 2));
    EXPECT_EQ(pair.left.at<cv::Vec3b>(1, 0), cv::Vec3b(21, 11, 1));
    EXPECT_EQ(pair.left.at<cv::Vec3b>(0, 2), cv::Vec3b(24, 14, 4));
    ASSERT_EQ(pair.right.type(), CV_8UC1);
    ASSERT_EQ(pair.right.size(), cv::Size(2, 3));
    EXPECT_EQ(pair.right.at<std::uint8_t>(2, 0), 3);
    EXPECT_EQ(pair.right.at<std::uint8_t>(0, 1), 4);

    EXPECT_EQ(pair.truth.kind, TruthKind::kLabels);
    EXPECT_EQ(pair.truth.labels, (std::vector<std::uint32_t>{0, 2}));
    ASSERT_TRUE(pair.given.has_value());
    EXPECT_EQ(pair.given->left_x, (std::vector<float>{1.5f, 5}));
    EXPECT_EQ(pair.given->left_y, (std::vector<float>{2, 6}));
    EXPECT_EQ(pair.given->right_x, (std::vector<float>{3, 7}));
    EXPECT_EQ(pair.given->right_y, (std::vector<float>{4, 8.25f}));
    EXPECT_EQ(pair.given->distance, (std::vector<float>{100, 50}));
    EXPECT_EQ(pair.given->left_size, cv::Size(3, 2));
    EXPECT_EQ(pair.given->right_size, cv::Size(2, 3));
    EXPECT_EQ(pair.given->inconsistency(), "");
  }
}

TEST_F(AdelaideFolder, DoesWithoutScore) {
  fields_.erase("score");
  writeFile();
  EXPECT_TRUE(read().given->distance.empty());
}

TEST_F(AdelaideFolder, AcceptsEveryNumericClass) {
  const std::vector<FieldSpec> labels = {
      field<float>({1, 2}, MAT_C_SINGLE, MAT_T_SINGLE, {0, 2}),
      field<std::int8_t>({1, 2}, MAT_C_INT8, MAT_T_INT8, {0, 2}),
      field<std::uint8_t>({2, 1}, MAT_C_UINT8, MAT_T_UINT8, {0, 2}),
      field<std::int16_t>({1, 2}, MAT_C_INT16, MAT_T_INT16, {0, 2}),
      field<std::uint16_t>({1, 2}, MAT_C_UINT16, MAT_T_UINT16, {0, 2}),
      field<std::int32_t>({1, 2}, MAT_C_INT32, MAT_T_INT32, {0, 2}),
      field<std::uint32_t>({1, 2}, MAT_C_UINT32, MAT_T_UINT32, {0, 2}),
      field<std::int64_t>({1, 2}, MAT_C_INT64, MAT_T_INT64, {0, 2}),
      field<std::uint64_t>({1, 2}, MAT_C_UINT64, MAT_T_UINT64, {0, 2}),
  };
  for (const FieldSpec& spec : labels) {
    fields_["label"] = spec;
    fields_["score"] = spec;
    writeFile(MAT_COMPRESSION_ZLIB);
    const ImagePair pair = read();
    EXPECT_EQ(pair.truth.labels, (std::vector<std::uint32_t>{0, 2})) << "class " << spec.class_type;
    EXPECT_EQ(pair.given->distance, (std::vector<float>{0, 2})) << "class " << spec.class_type;
  }
  fields_["data"] =
      field<std::int16_t>({6, 2}, MAT_C_INT16, MAT_T_INT16, {1, 2, 1, 3, 4, 1, 5, 6, 1, 7, 8, 1});
  writeFile();
  EXPECT_EQ(read().given->right_y, (std::vector<float>{4, 8}));
}

TEST_F(AdelaideFolder, RefusesMissingAndEmptyFolders) {
  const std::string missing = (root_ / "nowhere").string();
  EXPECT_TRUE(
      contains(errorOf<DatasetError>([&] { AdelaideRmfReader reader("adelaidermf", missing); }), missing));
  EXPECT_TRUE(
      contains(errorOf<DatasetError>([&] { AdelaideRmfReader reader("adelaidermf", root_.string()); }),
               "no .mat file"));
}

TEST_F(AdelaideFolder, NamesTheMissingField) {
  for (const std::string name : {"img1", "img2", "data", "label"}) {
    const FieldSpec good = fields_.at(name);
    fields_.erase(name);
    writeFile();
    fields_[name] = good;
    const std::string error = errorOf<DatasetError>([this] { read(); });
    EXPECT_TRUE(contains(error, path() + ": field '" + name + "' is missing")) << error;
  }
}

TEST_F(AdelaideFolder, RefusesWrongShapesAndValues) {
  expectRefused("label", doubles({1, 3}, {0, 1, 2}), "has 3 values (1x3 double) for 2 matches");
  expectRefused("score", doubles({1, 1}, {0}), "has 1 values (1x1 double) for 2 matches");
  expectRefused("label", doubles({1, 2}, {0, -1}), "whole numbers");
  expectRefused("label", doubles({1, 2}, {0, 0.5}), "whole numbers");
  expectRefused("label", doubles({1, 2}, {0, std::numeric_limits<double>::quiet_NaN()}), "whole numbers");
  expectRefused("label", field<char>({1, 2}, MAT_C_CHAR, MAT_T_UINT8, {'0', '1'}), "is 1x2 char");
  expectRefused("data", doubles({4, 3}, std::vector<double>(12, 1.0)), "is 4x3 double, 6xN expected");
  expectRefused("data", doubles({6, 2}, {1, 2, 1, 3, 4, 1, 5, 6, 2, 7, 8, 1}), "(number 2)");
  expectRefused("img1", doubles({2, 2}, {1, 2, 3, 4}), "is 2x2 double, uint8 expected");
  expectRefused("img2", field<std::uint8_t>({1, 2, 2}, MAT_C_UINT8, MAT_T_UINT8, {1, 2, 3, 4}),
                "is 1x2x2 uint8, an image HxW or HxWx3");
}

TEST_F(AdelaideFolder, RefusesWhatIsNoMatlabFile) {
  std::ofstream(path()) << "This is not a MATLAB file.";
  const std::string error = errorOf<DatasetError>([this] { read(); });
  EXPECT_TRUE(contains(error, path())) << error;
}

TEST_F(AdelaideFolder, RefusesFilesCutOffAnywhere) {
  for (const matio_compression compression : {MAT_COMPRESSION_NONE, MAT_COMPRESSION_ZLIB}) {
    writeFile(compression);
    for (std::uintmax_t length = fs::file_size(path()) - 1; length > 0;
         length -= std::min<std::uintmax_t>(length, 3)) {
      fs::resize_file(path(), length);
      // Where the cut falls between two fields, only an optional one may go unnoticed: score is the last.
      const std::string error = errorOf<DatasetError>([this] {
        const ImagePair pair = read();
        if (!pair.given->distance.empty()) ADD_FAILURE() << "read a damaged score";
      });
      if (length % 8 != 0) {
        EXPECT_TRUE(contains(error, path())) << length << " bytes: " << error;
      }
    }
  }
}

TEST(AdelaideRmf, ReadsTheRealDataset) {
  const std::string folder = sharedData("adelaidermf");
  if (folder.empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  const AdelaideRmfReader reader("adelaidermf", folder);
  ASSERT_EQ(reader.size(), 36u);
  for (std::size_t i = 0; i < reader.size(); ++i) {
    const ImagePair pair = reader.read(i);
    ASSERT_TRUE(pair.given.has_value());
    EXPECT_EQ(pair.given->inconsistency(), "");
    EXPECT_EQ(pair.given->distance.size(), pair.given->size());
    EXPECT_EQ(pair.truth.labels.size(), pair.given->size());
    for (std::size_t k = 0; k < pair.given->size(); ++k) {
      EXPECT_TRUE(cv::Rect2f(0.5f, 0.5f, pair.left.cols, pair.left.rows)
                      .contains({pair.given->left_x[k], pair.given->left_y[k]}))
          << pair.id.text() << " match " << k;
    }
    if (i == 0) {
      EXPECT_EQ(pair.id.sequence, "barrsmith");
      EXPECT_EQ(pair.given->size(), 241u);
      EXPECT_EQ(
          std::count_if(pair.truth.labels.begin(), pair.truth.labels.end(), [](auto l) { return l > 0; }),
          75);
    }
  }
}

TEST_F(AdelaideFolder, CarriesTheDatasetsName) {
  fields_.erase("score");
  writeFile();
  EXPECT_EQ(openDataset("adelaidermf_reconstructed", root_.string())->id(0).text(),
            "adelaidermf_reconstructed/pair/1-2");
  // Another name for such a folder: the layout is recognised.
  EXPECT_EQ(openDataset("mine", root_.string())->read(0).id.text(), "mine/pair/1-2");
}

TEST(AdelaideRmf, ReadsTheReconstructedPairs) {
  const std::string folder = sharedData("adelaidermf_reconstructed");
  if (folder.empty()) GTEST_SKIP() << "skipped: the reconstructed AdelaideRMF files are not here";
  const auto reader = openDataset("adelaidermf_reconstructed", folder);
  ASSERT_EQ(reader->size(), 2u);
  EXPECT_EQ(reader->id(0).text(), "adelaidermf_reconstructed/johnsona_RECONSTRUCTED/1-2");
  for (std::size_t i = 0; i < reader->size(); ++i) {
    const ImagePair pair = reader->read(i);
    EXPECT_EQ(pair.given->inconsistency(), "");
    EXPECT_TRUE(pair.given->distance.empty());
    EXPECT_EQ(pair.truth.labels.size(), pair.given->size());
  }
}

}  // namespace
}  // namespace corrsel::core
