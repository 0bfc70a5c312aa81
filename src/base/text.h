#pragma once

#include <string>
#include <vector>

namespace corrsel::core {

/// Shortest decimal text that reads back as the same double; empty for NaN, "inf"/"-inf" for infinities.
std::string formatNumber(double value);

/// Reads a whole text as a number. Throws std::invalid_argument naming `what` and the text.
double parseNumber(const std::string& text, const std::string& what);
int parseInteger(const std::string& text, const std::string& what);
bool parseFlag(const std::string& text, const std::string& what);

/// Splits at every separator and trims white space; empty pieces are dropped.
std::vector<std::string> splitList(const std::string& text, char separator = ',');

std::string joinList(const std::vector<std::string>& items, const std::string& separator = ", ");

/// The name that `word` probably means: the one with the fewest edits (a character inserted, left out,
/// replaced, or, likeliest, swapped with its neighbour), or else the shortest one that begins with `word`.
/// Case is ignored, and so are '_', '-' and blanks. Of several equally near names the first one is returned.
/// The text is empty where every name differs in more than a third of its characters, and begins otherwise.
std::string nearestName(const std::string& word, const std::vector<std::string>& names);

/// "; did you mean 'gms'?" with the nearest name, or an empty text where no name is near.
std::string didYouMean(const std::string& word, const std::vector<std::string>& names);

/// The end of a message about an unknown name: "; did you mean 'gms'? valid: gms, lpm", without the question
/// where no name is near.
/// @param heading  of the list
std::string validNames(const std::string& word, const std::vector<std::string>& names,
                       const std::string& heading = "valid");

/// A CSV field (RFC 4180): quoted if it contains a comma, a quote or a line break. Line breaks become blanks,
/// so that every record stays on one line.
std::string csvField(const std::string& text);

/// One CSV record without line end. Fields are quoted if necessary.
std::string csvLine(const std::vector<std::string>& fields);

/// Splits one CSV line (RFC 4180 quoting, no embedded line breaks).
std::vector<std::string> parseCsvLine(const std::string& line);

/// Complete lines of a text, without line ends. A last line without a line end is left out.
std::vector<std::string> completeLines(const std::string& text);

/// All bytes of a file; empty if it cannot be read.
std::string readTextFile(const std::string& path);

/// A file name without separators or shell-special characters: characters outside [A-Za-z0-9._+-] and a
/// leading '.' become '_'.
std::string safeFileName(const std::string& text);

/// A file name that no other text has: characters outside [A-Za-z0-9._+-] and a leading '.' are
/// percent-encoded (RFC 3986), an empty text becomes "%". Of a result with more than 200 characters, the
/// first 180 are followed by '%' and the text's checksum.
std::string uniqueFileName(const std::string& text);

}  // namespace corrsel::core
