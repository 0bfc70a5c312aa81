#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "base/text.h"
#include "benchmark/tables.h"
#include "result_rows.h"
#include "test_paths.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::contains;
using testing::errorOf;
using testing::rowsOf;

template <class Row>
std::string withoutEnd(const CsvTable<Row>& table, const Row& row) {
  const std::string line = table.line(row);
  EXPECT_EQ(line.back(), '\n');
  return line.substr(0, line.size() - 1);
}

TEST(Tables, RowsReadBackAsWritten) {
  ResultRow row = rowsOf("1-2", 1.0 / 3)[0];
  row.detect_seconds = 0.1 + 0.2;
  row.seed = 7;
  row.status = Status::kTooFew;
  const CsvTable<ResultRow> table = pairsTable({5, 10});
  const std::string line = withoutEnd(table, row);
  const ResultRow back = table.parse(line);
  EXPECT_EQ(withoutEnd(table, back), line);
  EXPECT_EQ(back.id, row.id);
  ASSERT_EQ(back.metrics.size(), 2U);
  EXPECT_EQ(back.metrics[1].tau, 10);
  EXPECT_EQ(back.metrics[1].n_correct, 20U);
  EXPECT_EQ(back.metrics[1].n_inliers, 60U);
  EXPECT_EQ(back.metrics[1].f_paper, row.metrics[1].f_paper);
  EXPECT_EQ(back.detect_seconds, 0.1 + 0.2);
  EXPECT_EQ(back.status, Status::kTooFew);
}

TEST(Tables, LabelledAndUnknownTruthsHaveNoTolerances) {
  const CsvTable<ResultRow> table = pairsTable({5, 10});
  ResultRow row = rowsOf("1-2")[0];
  row.truth = TruthKind::kLabels;
  row.metrics = {metricsOf(kUndefined, 30, 60, 60, 60)};
  const ResultRow labelled = table.parse(withoutEnd(table, row));
  ASSERT_EQ(labelled.metrics.size(), 1U);
  EXPECT_TRUE(std::isnan(labelled.metrics[0].tau));
  EXPECT_EQ(labelled.metrics[0].f_same_tau, 0.5);
  EXPECT_EQ(labelled.metricsAt(3), &labelled.metrics[0]);
  row.truth = TruthKind::kNone;
  row.metrics.assign(2, Metrics());
  const ResultRow unknown = table.parse(withoutEnd(table, row));
  ASSERT_EQ(unknown.metrics.size(), 2U);
  EXPECT_EQ(unknown.metrics[0].tau, 5);
  EXPECT_TRUE(std::isnan(unknown.metrics[0].f_paper));
  EXPECT_EQ(unknown.metricsAt(3), nullptr);
}

TEST(Tables, EveryColumnReadsTheCellItWrites) {
  const auto check = [](const auto& table, const std::string& line) {
    EXPECT_EQ(withoutEnd(table, table.parse(line)), line) << table.file();
  };
  const CsvTable<ResultRow> pairs = pairsTable({0.5, 10});
  check(pairs, "a,b,c,d,e,f,homography,2,3,40,5,6,7,8,,9,10,ok,rigid,2.5,14,15,16,17,18");
  check(pairs, "a,b,c,d,e,f,labels,2,3,40,5,,,8,9,,,ok,unknown,2.5,14,15,16,17,18");
  check(pairs, "a,b,c,d,e,f,none,2,3,40,0,,,8,,,,ok,nothing,2.5,14,15,16,17,18");
  check(pairs, "a,b,c,d,e,f,labels,2,3,40,5,,,,,,,failed,,,14,15,16,17,");
  check(posesTable(), "a,b,c,d,e,f,7,ok,9,essential,8,0.5,0.25,0.5,0.75,,0.01,,,,,,,,,");
  check(posesTable(), "a,b,c,d,e,f,7,ok,9,none,0,,,180,0.75,inf,0.01,,,,,,,,,");
  check(posesTable(), "a,b,c,d,e,f,7,ok,9,,,,,,,2.5,0.01,,,,,,,,,");
  check(posesTable(), "a,b,c,d,e,f,7,ok,9,none,0,,,180,0.75,inf,0.01,planar,general,0.5,0.25,0.5,30,4.5,5,0");
  check(posesTable(), "a,b,c,d,e,f,7,ok,9,none,0,,,180,0.75,inf,0.01,none,rest,,,180,,,0,1");
  check(posesTable(), "a,b,c,d,e,f,7,unsupported_input,,,,,,,,,,,,,,,,,,");
  check(poseSummaryTable(),
        "a,b,c,d,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,18,19,20,21,"
        "22,23,24,25,26,27,28,29,30,31,32,33,34,35,36,37,38,39,40");
  check(summaryTable(), "a,b,c,d,1,2,3,4,5,6,7,8,9,10,11,12");
  check(stagesTable(), "1,a,b,c,d,2.5");
  check(stagesTable(), ",a,,,bag,2.5");
  check(scalingTable(), "a,1,2,3,4,too_few,0.5");
  check(failuresTable(), "a,b,c,d,e,\"f, g\"");
  check(imagesTable(), "a,b,c,d,e,f,g,1,2,3,4,");
  check(truthChecksTable(), "a,b,c,d,homography,inverse,5,1,2,3,4,6");
  check(remarksTable(), "a,b,c,\"d, e\"");
}

TEST(Tables, RowsThatAreNotEvaluatedHaveNoNumbers) {
  ResultRow row = rowsOf("1-2")[0];
  row.status = Status::kUnsupportedInput;
  EXPECT_EQ(withoutEnd(pairsTable({5, 10}), row),
            "set,\"scene, "
            "\"\"one\"\"\",1-2,orb+orb,none,gms,homography,0,0,100,60,60,60,,,,,unsupported_input,,,0,,,,");
}

TEST(Tables, DamagedLinesAreRefused) {
  EXPECT_TRUE(contains(errorOf([] { pairsTable({5}).parse("a,b"); }), "2 columns"));
  const std::string count = errorOf([] { scalingTable().parse("a,1,-2,3,4,ok,0.5"); });
  EXPECT_TRUE(contains(count, "n: '-2'")) << count;
  const std::string status = errorOf([] { scalingTable().parse("a,1,2,3,4,fine,0.5"); });
  EXPECT_TRUE(contains(status, "fine")) << status;
  const std::string model =
      errorOf([] { posesTable().parse("a,b,c,d,e,f,7,ok,9,affine,8,0.5,0.25,0.5,0.75,,0.01,,,,,,,,,"); });
  EXPECT_TRUE(contains(model, "model: 'affine'")) << model;
  const std::string kind = errorOf([] { truthChecksTable().parse("a,b,c,d,guess,inverse,5,1,2,3,4,6"); });
  EXPECT_TRUE(contains(kind, "truth: 'guess'")) << kind;
  const std::string text =
      scalingTable().header() + "\na,1,2,3,4,ok,0.5\na,b\na,1,2,3,4,ok,high\nb,1,2,3,4,ok,1";
  ASSERT_EQ(scalingTable().intactRows(text).size(), 1U);
  EXPECT_EQ(scalingTable().intactRows(text)[0].select_seconds, 0.5);
}

/// Without the quotes and line breaks between the parts of a string that goes over several lines of Python.
std::string joinedLiterals(const std::string& python) {
  return std::regex_replace(python, std::regex("\"\\s*\n\\s*\""), "");
}

template <class Row>
void expectInDocs(const CsvTable<Row>& table) {
  const std::string docs = readTextFile(corrsel::testing::sourceDir() + "/docs/evaluation.md");
  EXPECT_TRUE(contains(docs, "`" + table.header() + "`")) << "docs/evaluation.md, " << table.file();
}

template <class Row>
void expectDescribed(const CsvTable<Row>& table) {
  expectInDocs(table);
  const std::string reader =
      joinedLiterals(readTextFile(corrsel::testing::sourceDir() + "/python/corrsel/report/reading.py"));
  EXPECT_TRUE(contains(reader, "\"" + table.header() + "\"")) << "reading.py, " << table.file();
}

TEST(Tables, DocumentationAndReportHaveTheSameColumns) {
  expectDescribed(pairsTable({}));
  expectDescribed(posesTable());
  expectDescribed(summaryTable());
  expectDescribed(poseSummaryTable());
  expectDescribed(stagesTable());
  expectDescribed(scalingTable());
  expectDescribed(failuresTable());
  expectDescribed(imagesTable());
  expectInDocs(savedMatchesTable());  // corrsel.files reads it by its columns' names
  expectInDocs(truthChecksTable());   // the report reads the warnings in summary.json
  expectDescribed(remarksTable());
}

}  // namespace
}  // namespace corrsel::core
