#pragma once

#include <string>
#include <vector>

#include "datasets/files.h"

namespace corrsel::core {

/// A layout of datasets that have a folder for each pair or scene.
struct FolderLayout {
  std::string dataset;  ///< a name of openDataset() that means it, e.g. "pairs"
  std::string files;    ///< of a pair's folder, in words
  FolderFit (*fit)(const std::vector<std::string>& names);
};

/// A layout that is recognised from the dataset's folder as a whole.
struct RootLayout {
  std::string dataset;                   ///< a name of openDataset() that means it, e.g. "colmap"
  std::string files;                     ///< in words, e.g. "NAME.mat"
  bool (*has)(const std::string& root);  ///< whether the folder has files of the layout
  bool by_sequence = false;  ///< whether each folder of a sequence is a dataset in this layout, too
};

/// Whether a folder below `root` has a complete pair of the layout.
bool hasPairOf(const FolderLayout& layout, const std::string& root);

/// Whether `root` has .mat files, as AdelaideRMF has.
bool hasMatFile(const std::string& root);

/// Layouts that a dataset's folder is searched for.
struct SearchedLayouts {
  std::vector<FolderLayout> folders;
  std::vector<RootLayout> roots;
};

/// Why no pair can be read from `root`, in several lines: what the first folders hold, what each of them
/// lacks for the layout that fits them best, what can be done, and which layouts were looked for. Recognises
/// images without folders, a folder that is a pair itself, datasets that lie one folder deeper, and another
/// layout than expected.
/// @param all  all layouts, whether looked for or not
std::string explainUnreadable(const std::string& root, const SearchedLayouts& searched,
                              const SearchedLayouts& all);

/// Where `path` is not a folder because the folder above it is the dataset itself: a sentence that says so.
/// Empty otherwise.
std::string explainMissing(const std::string& path, const SearchedLayouts& all);

}  // namespace corrsel::core
