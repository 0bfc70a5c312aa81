#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "dataset_folder.h"
#include "datasets/evd.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

class Evd : public DatasetFolder {
 protected:
  void SetUp() override {
    DatasetFolder::SetUp();
    for (const std::string name : {"adam", "cafe"}) {
      writeImage("1/" + name + ".png", 3);
      writeImage("2/" + name + ".png", 7);
      write("h/" + name + ".txt", "1 0 " + std::to_string(name.size()) + "\n0 1 0\n0 0 1\n");
    }
  }
};

TEST_F(Evd, ReadsPairs) {
  EXPECT_TRUE(EvdReader::fits(path()));
  const EvdReader reader("evd", path());
  ASSERT_EQ(reader.size(), 2u);
  EXPECT_EQ(reader.id(1).text(), "evd/cafe/1-2");
  const ImagePair pair = reader.read(1);
  EXPECT_EQ(pair.left.data[0], 3);
  EXPECT_EQ(pair.right.data[0], 7);
  EXPECT_EQ(pair.left_name, "1/cafe.png");
  EXPECT_EQ(pair.right_name, "2/cafe.png");
  EXPECT_EQ(pair.truth.kind, TruthKind::kHomography);
  EXPECT_EQ(pair.truth.matrix(0, 2), 4);
  EXPECT_EQ(reader.files().size(), 6u);
}

TEST_F(Evd, AMissingFileCostsItsPairOnly) {
  std::filesystem::remove(path("2/adam.png"));
  writeImage("1/dum.png");
  write("h/cafe.txt", "1 2 3");
  const EvdReader reader("evd", path());
  ASSERT_EQ(reader.size(), 3u);
  const std::string expected[] = {path("2/adam") + ": the image is missing",
                                  path("h/cafe.txt") + ": holds 3 numbers where a homography has 9",
                                  path("2/dum") + ": the image is missing"};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string error = errorOf<DatasetError>([&] { reader.check(i); });
    EXPECT_EQ(error.find(expected[i]), 0u) << error;
    EXPECT_EQ(errorOf<DatasetError>([&] { reader.read(i); }), error);
  }
  std::filesystem::remove_all(path("h"));
  EXPECT_FALSE(EvdReader::fits(path()));
}

}  // namespace
}  // namespace corrsel::core
