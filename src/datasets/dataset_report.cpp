#include "datasets/dataset_report.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <sstream>

#include "base/text.h"

namespace corrsel::core {
namespace {

/// A published dataset and the names of its sequences, separated by blanks.
struct Published {
  const char *dataset, *sequences;
};

constexpr Published kPublished[] = {
    {"vgg", "bark bikes boat graf leuven trees ubc wall"},
    {"symbench",
     "arch arch_easy bank bdom cars chinesebuilding eiffel essighaus graffiti londonbridge madrid metz "
     "miduomo01 miduomo02 montreal neubrandenburg notredame notredame12 notredame13 notredame14 "
     "notredame15 notredame16 paintedladies paintedladies12 paintedladies13 paintedladies14 "
     "paintedladies15 paintedladies16 paintedladies17 paintedladies18 pantheon pantheon02 portcullis "
     "postoffice riga sanmarco sanmarco2 stargarder stargarder3 synagogue taj tavern townsquare "
     "trevi02 vatican worldbuilding"},
    {"adelaidermf",
     "barrsmith biscuit biscuitbook biscuitbookbox boardgame bonhall bonython book breadcartoychips "
     "breadcube breadcubechips breadtoy breadtoycar carchipscube cube cubebreadtoychips cubechips "
     "cubetoy dinobooks elderhalla elderhallb game gamebiscuit hartley johnsona johnsonb ladysymon "
     "library napiera napierb neem nese oldclassicswing physics sene toycubecar unihouse unionhouse"},
};

/// The sequences of the published dataset; none where they are not known.
std::vector<std::string> publishedSequences(const std::string& dataset) {
  for (const Published& published : kPublished) {
    if (dataset != published.dataset) continue;
    std::istringstream words(published.sequences);
    return {std::istream_iterator<std::string>(words), std::istream_iterator<std::string>()};
  }
  return {};
}

std::string counted(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

}  // namespace

std::string DatasetReport::text() const {
  std::string text = dataset + ": found " + counted(sequences, "sequence") + ", " + counted(pairs, "pair") +
                     ", " + (problems.empty() ? "none" : std::to_string(problems.size())) +
                     " of them broken\n";
  if (!missing.empty()) {
    text += "missing: " + std::to_string(missing.size()) + " of the " +
            counted(publishedSequences(dataset).size(), "published sequence") + ": " + joinList(missing) +
            "\n";
  }
  if (!ignored.empty()) {
    text += "ignored: " + counted(ignored.size(), "folder") +
            " without any file of the layout: " + joinList(ignored) + "\n";
  }
  for (const std::string& problem : problems) text += "broken: " + problem + "\n";
  return text;
}

std::vector<std::size_t> evenlySpaced(std::size_t count, std::size_t limit) {
  std::vector<std::size_t> indices(std::min(count, limit));
  for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = i * count / indices.size();
  return indices;
}

DatasetReport describe(const DatasetReader& reader, const std::vector<std::size_t>& decoded,
                       const DescribeCalls& calls) {
  DatasetReport report;
  std::set<std::string> sequences;
  for (std::size_t i = 0; i < reader.size(); ++i) {
    const PairId id = reader.id(i);
    report.dataset = id.dataset;
    sequences.insert(id.sequence);
    try {
      if (std::binary_search(decoded.begin(), decoded.end(), i)) {
        const ImagePair pair = reader.read(i);
        if (calls.decoded) calls.decoded(pair);
      } else {
        reader.check(i);
      }
    } catch (const DatasetError& error) {
      report.problems.push_back(id.text() + ": " + error.what());
      report.broken.push_back(i);
    }
    if (calls.progress) calls.progress(i + 1, id);
  }
  report.sequences = sequences.size();
  report.pairs = reader.size();
  for (const std::string& sequence : publishedSequences(report.dataset)) {
    if (sequences.count(sequence) == 0) report.missing.push_back(sequence);
  }
  report.ignored = reader.ignored();
  return report;
}

}  // namespace corrsel::core
