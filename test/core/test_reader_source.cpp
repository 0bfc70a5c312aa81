#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "datasets/reader_source.h"

namespace corrsel::core {
namespace {

/// Three pairs, of which the second cannot be read.
class ThreePairs : public DatasetReader {
 public:
  std::size_t size() const override { return 3; }
  PairId id(std::size_t index) const override { return {"set", "scene", std::to_string(index)}; }
  ImagePair read(std::size_t index) const override {
    read_.push_back(index);
    if (index == 1) throw DatasetError("broken");
    ImagePair pair;
    pair.id = id(index);
    return pair;
  }
  std::vector<std::string> files() const override { return {}; }

  mutable std::vector<std::size_t> read_;
};

TEST(ReaderSource, ABrokenPairDoesNotStopTheOthers) {
  const ThreePairs reader;
  ReaderSource source(reader);
  EXPECT_EQ(source.size(), 3U);
  ImagePair pair;
  EXPECT_TRUE(source.next(pair));
  EXPECT_EQ(pair.id.pair, "0");
  EXPECT_EQ(source.nextId()->pair, "1");
  EXPECT_THROW(source.next(pair), DatasetError);
  EXPECT_EQ(source.nextId()->pair, "2");
  EXPECT_TRUE(source.next(pair));
  EXPECT_EQ(pair.id.pair, "2");
  EXPECT_FALSE(source.nextId());
  EXPECT_FALSE(source.next(pair));
}

TEST(ReaderSource, SkippedPairsAreNotRead) {
  const ThreePairs reader;
  ReaderSource source(reader);
  source.skip();
  source.skip();
  ImagePair pair;
  EXPECT_TRUE(source.next(pair));
  EXPECT_EQ(reader.read_, std::vector<std::size_t>{2});
}

}  // namespace
}  // namespace corrsel::core
