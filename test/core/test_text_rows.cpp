#include <gtest/gtest.h>

#include <string>

#include "corrsel/datasets/reader.h"
#include "dataset_folder.h"
#include "datasets/text_rows.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

using TextRows = DatasetFolder;

TEST_F(TextRows, SplitsLinesAndSkipsComments) {
  write("a.txt", "# head\n\n1 2.5,x\r\n  \t\n-3\n");
  const std::vector<TextRow> rows = readTextRows(path("a.txt"), "");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].words, (std::vector<std::string>{"1", "2.5", "x"}));
  EXPECT_EQ(rows[0].place(), path("a.txt") + ": line 3");
  EXPECT_EQ(rows[0].numbers(0, 2), (std::vector<double>{1, 2.5}));
  EXPECT_EQ(rows[1].number(0), -3);
  EXPECT_EQ(rows[1].line, 5u);
}

TEST_F(TextRows, TimesAreExact) {
  write("a.txt", "1305031102.175304 1403636579763555584 12 1.0000000019\n");
  const TextRow row = readTextRows(path("a.txt"), "")[0];
  EXPECT_EQ(row.time(0, 9), 1305031102175304000);
  EXPECT_EQ(row.time(1, 0), 1403636579763555584);
  EXPECT_EQ(row.time(2, 9), 12000000000);
  EXPECT_EQ(row.time(3, 9), 1000000001);
}

TEST_F(TextRows, FaultsNameFileLineAndWord) {
  write("a.txt", "\nabc nan 1e400 -5 99999999999999999999 9223372036854775808\n");
  const TextRow row = readTextRows(path("a.txt"), "")[0];
  const auto errorIn = [&](const auto& action) { return errorOf<DatasetError>(action); };
  const std::string place = path("a.txt") + ": line 2: ";
  EXPECT_EQ(errorIn([&] { row.number(0); }).find(place + "entry 1: 'abc'"), 0u)
      << errorIn([&] { row.number(0); });
  EXPECT_FALSE(errorIn([&] { row.number(1); }).empty());
  EXPECT_FALSE(errorIn([&] { row.number(2); }).empty());
  EXPECT_EQ(errorIn([&] { row.time(3, 9); }), place + "entry 4: '-5' is not a time; write it in seconds");
  EXPECT_TRUE(contains(errorIn([&] { row.time(4, 0); }), "has too many digits for a time in nanoseconds"));
  EXPECT_TRUE(contains(errorIn([&] { row.time(5, 0); }), "has too many digits for a time in nanoseconds"));
  EXPECT_EQ(errorIn([&] { row.requireWords(3, "x y z"); }),
            place + "has 6 entries where 3 are expected (x y z)");
  EXPECT_EQ(errorIn([&] { readTextRows(path("b.txt"), "make it"); }),
            path("b.txt") + ": the file is missing; make it");
}

}  // namespace
}  // namespace corrsel::core
