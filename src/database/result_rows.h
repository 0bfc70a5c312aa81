#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace corrsel::core {

/// The checksum (base/checksum.h, a byte a unit) of all rows of two_view_geometries in ascending order of
/// pair_id. Of every row it takes pair_id, rows, cols and config as little-endian numbers of 8 bytes, and
/// then for each of data, F, E, H, qvec and tvec the number of its bytes in the same way and the bytes. NULL,
/// an empty blob and a column that the schema lacks are 0 bytes. So it does not depend on how the rows came
/// into the file, nor on other tables and columns.
///
/// Cost: reads the table once. Throws StoreError.
std::string checksumOfGeometries(const std::filesystem::path& database);

/// Copies the pairs that a part of a run has verified, byte for byte and in one transaction, into the
/// database that was divided. Rows that are there are replaced.
/// @param part           file that a run with `--shard` has written
/// @param configuration  settings that the part must have been verified with
/// @return number of pairs
/// Throws StoreError where the part is no such file, has other settings, or belongs to another database;
/// nothing of it is copied then.
std::size_t mergeVerifications(const std::filesystem::path& database, const std::filesystem::path& part,
                               const std::string& configuration);

}  // namespace corrsel::core
