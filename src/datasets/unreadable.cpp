#include "datasets/unreadable.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iterator>
#include <set>

#include "base/text.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kShownFolders = 3, kShownNames = 4;

/// Types of images that are not read.
constexpr const char* kOtherImages[] = {".arw",  ".avif", ".cr2", ".dng", ".exr", ".gif", ".heic",
                                        ".heif", ".jp2",  ".jxl", ".nef", ".raw", ".svg"};

std::string extensionOf(const std::string& name) {
  std::string extension = fs::path(name).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

bool isUnreadImage(const std::string& name) {
  return std::find(std::begin(kOtherImages), std::end(kOtherImages), extensionOf(name)) !=
         std::end(kOtherImages);
}

bool isReadImage(const std::string& name) { return isImageExtension(extensionOf(name)); }

std::string quoted(const std::string& text) { return "'" + text + "'"; }

/// The folder of a path that may end with a slash.
std::string parentOf(const std::string& path) {
  const fs::path folder = fs::path(path).has_filename() ? fs::path(path) : fs::path(path).parent_path();
  const std::string parent = folder.parent_path().string();
  return parent.empty() ? "." : parent;
}

/// "a.png, b.png, c.png, d.png and 7 more"
std::string shown(const std::vector<std::string>& names, std::size_t max_shown = kShownNames) {
  const std::size_t count = std::min(names.size(), max_shown);
  std::string text = joinList({names.begin(), names.begin() + static_cast<std::ptrdiff_t>(count)});
  if (names.size() > count) text += " and " + std::to_string(names.size() - count) + " more";
  return text;
}

bool isDataset(const std::string& folder, const SearchedLayouts& all) {
  return std::any_of(all.roots.begin(), all.roots.end(),
                     [&folder](const RootLayout& layout) { return layout.has(folder); }) ||
         std::any_of(all.folders.begin(), all.folders.end(),
                     [&folder](const FolderLayout& layout) { return hasPairOf(layout, folder); });
}

/// The layout of which the folders hold most files; the last of equal ones.
const FolderLayout& bestOf(const std::vector<FolderLayout>& layouts, const std::string& root,
                           const std::vector<std::string>& folders) {
  const FolderLayout* best = &layouts.back();
  std::size_t max_present = 0;
  for (const FolderLayout& layout : layouts) {
    std::size_t present = 0;
    for (const std::string& folder : folders) present += layout.fit(fileNames(below(root, folder))).present;
    if (present > max_present || (present == max_present && max_present > 0)) {
      max_present = present;
      best = &layout;
    }
  }
  return *best;
}

/// "left", "left and right", "left, right and H1to2"
std::string enumeration(std::vector<std::string> names) {
  const std::string last = names.back();
  names.pop_back();
  return names.empty() ? last : joinList(names) + " and " + last;
}

/// "desk holds left.png, right.png; H.txt or F.txt is missing"
std::string lineOf(const std::string& root, const std::string& folder, const FolderLayout* layout) {
  const std::vector<std::string> names = fileNames(below(root, folder));
  const std::vector<std::string> folders = subfolders(below(root, folder));
  if (names.empty() && folders.empty()) return folder + " is empty";
  std::string text = folder + " holds " + (names.empty() ? "no files" : shown(names));
  if (!folders.empty()) text += (names.empty() ? " but the folders " : " and the folders ") + shown(folders);
  if (layout == nullptr) return text;
  const std::vector<std::string> lacking = layout->fit(names).lacking;
  return text + "; " + enumeration(lacking) + (lacking.size() == 1 ? " is missing" : " are missing");
}

/// A sentence where there are images of types that are not read.
std::string unreadTypes(const std::vector<std::string>& names) {
  std::set<std::string> types;
  for (const std::string& name : names) {
    if (isUnreadImage(name)) types.insert(extensionOf(name));
  }
  if (types.empty()) return "";
  return "\nImages of the type " + enumeration({types.begin(), types.end()}) + " are not read (" +
         imageExtensions() + " are); convert them to PNG.";
}

std::string searchedFor(const SearchedLayouts& searched) {
  std::string text = "\nThe folder was searched for";
  for (const FolderLayout& layout : searched.folders) {
    text += "\n  NAME/ with " + layout.files + " (as in " + layout.dataset + ")";
  }
  for (const RootLayout& layout : searched.roots) {
    text += "\n  " + layout.files + " (as in " + layout.dataset + ")";
  }
  return text + "\nThese layouts are described in docs/datasets.md.";
}

std::string explainWithoutFolders(const std::string& root, const std::vector<FolderLayout>& expected) {
  const std::vector<std::string> names = fileNames(root);
  if (names.empty()) return "It is empty.";
  std::string text = "It holds " + std::to_string(names.size()) +
                     (names.size() == 1 ? " file (" : " files (") + shown(names) + ") and no folders.";
  const bool images = std::any_of(names.begin(), names.end(), isReadImage) ||
                      std::any_of(names.begin(), names.end(), isUnreadImage);
  if (images && !expected.empty()) {
    text += " Make a folder for each pair, with " + expected.back().files + ".";
  }
  return text + unreadTypes(names);
}

/// What the first folders hold and what they lack.
std::string explainFolders(const std::string& root, const std::vector<std::string>& folders,
                           const std::vector<FolderLayout>& expected) {
  const auto end = folders.begin() + static_cast<std::ptrdiff_t>(std::min(folders.size(), kShownFolders));
  const std::vector<std::string> first(folders.begin(), end);
  const FolderLayout* const layout = expected.empty() ? nullptr : &bestOf(expected, root, first);
  std::string text = first.size() == folders.size()
                         ? "Its folders"
                         : "The first " + std::to_string(first.size()) + " of its " +
                               std::to_string(folders.size()) + " folders";
  if (layout != nullptr) text += ", compared with the layout of " + layout->dataset;
  text += ":";
  std::vector<std::string> names;
  bool rename = false;
  for (const std::string& folder : first) {
    text += "\n  " + lineOf(root, folder, layout);
    const std::vector<std::string> own = fileNames(below(root, folder));
    names.insert(names.end(), own.begin(), own.end());
    const std::vector<std::string> lacking = layout == nullptr ? own : layout->fit(own).lacking;
    const bool lacks_both = std::count(lacking.begin(), lacking.end(), "left") == 1 &&
                            std::count(lacking.begin(), lacking.end(), "right") == 1;
    rename = rename || (lacks_both && std::count_if(own.begin(), own.end(), isReadImage) == 2);
  }
  if (rename) text += "\nRename the two images of each pair to left and right.";
  return text + unreadTypes(names);
}

/// That the folder has another layout than the one that was expected.
std::string explainOther(const std::string& files, const std::string& dataset) {
  return files + ", which is the layout of " + dataset +
         ". Give the dataset that name, or any other one that does not stand for a layout.";
}

std::string explain(const std::string& root, const std::vector<FolderLayout>& expected,
                    const SearchedLayouts& all) {
  const std::vector<std::string> names = fileNames(root), folders = subfolders(root);
  for (const RootLayout& layout : all.roots) {
    if (layout.has(root)) return explainOther("It holds " + layout.files, layout.dataset);
  }
  for (const FolderLayout& layout : all.folders) {
    if (!layout.fit(names).whole()) continue;
    return "It is the folder of one pair (it holds " + shown(names) +
           "). The dataset is the folder above it, " + quoted(parentOf(root)) + ".";
  }
  for (const FolderLayout& layout : all.folders) {
    if (hasPairOf(layout, root)) return explainOther("Its folders hold " + layout.files, layout.dataset);
  }
  if (folders.empty()) return explainWithoutFolders(root, expected);
  std::vector<std::string> datasets;
  for (const std::string& folder : folders) {
    if (isDataset(below(root, folder), all)) datasets.push_back(quoted(below(root, folder)));
  }
  if (datasets.size() == 1)
    return "The pairs lie one folder deeper: the dataset is " + datasets.front() + ".";
  if (!datasets.empty()) {
    return "The pairs lie one folder deeper: there are several datasets, " + shown(datasets, kShownFolders) +
           ".";
  }
  return explainFolders(root, folders, expected);
}

}  // namespace

bool hasPairOf(const FolderLayout& layout, const std::string& root) {
  const std::vector<std::string> folders = subfolders(root);
  return std::any_of(folders.begin(), folders.end(), [&](const std::string& folder) {
    return layout.fit(fileNames(below(root, folder))).whole();
  });
}

bool hasMatFile(const std::string& root) {
  const std::vector<std::string> names = fileNames(root);
  return std::any_of(names.begin(), names.end(),
                     [](const std::string& name) { return fs::path(name).extension() == ".mat"; });
}

std::string explainUnreadable(const std::string& root, const SearchedLayouts& searched,
                              const SearchedLayouts& all) {
  return quoted(root) + " has no complete pair. " + explain(root, searched.folders, all) +
         searchedFor(searched);
}

std::string explainMissing(const std::string& path, const SearchedLayouts& all) {
  const std::string parent = parentOf(path);
  // The folder that holds all datasets looks like a dataset of the sequences that are datasets in it.
  SearchedLayouts certain{all.folders, {}};
  std::copy_if(all.roots.begin(), all.roots.end(), std::back_inserter(certain.roots),
               [](const RootLayout& layout) { return !layout.by_sequence; });
  std::error_code ignored;
  if (fs::is_directory(path, ignored) || !fs::is_directory(parent, ignored) || !isDataset(parent, certain))
    return "";
  return "The folder above it, " + quoted(parent) +
         ", is a dataset itself; the folder that holds all datasets " + "(data_root) is " +
         quoted(parentOf(parent)) + ".";
}

}  // namespace corrsel::core
