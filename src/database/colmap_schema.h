#pragma once

#include <set>
#include <string>

#include "database/sqlite.h"

namespace corrsel::core {

/// The version of COLMAP whose tables createColmapTables() makes, as it writes it: 3.8.
constexpr int kColmapUserVersion = 3800;

/// Makes COLMAP's tables in an empty database.
void createColmapTables(const SqliteDatabase& database);

/// Makes the tables in which verifications are noted beside COLMAP's own, where they are missing. COLMAP
/// ignores them.
void createVerificationTables(const SqliteDatabase& database);

bool hasTable(const SqliteDatabase& database, const std::string& table);

/// The names of a table's columns; empty where there is no such table.
std::set<std::string> columnsOf(const SqliteDatabase& database, const std::string& table);

/// Throws StoreError where a table or column is missing that ColmapStore reads.
void requireColmapTables(const SqliteDatabase& database);

/// Throws StoreError where two_view_geometries has columns of a newer version that must be filled.
void requireWritableGeometries(const SqliteDatabase& database);

}  // namespace corrsel::core
