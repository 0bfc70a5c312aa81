// Compiled with the headers that most sources include; see source_folder.cmake.
