# source_folder(LIBRARY NAME [SMALL] [UNITY] SOURCES... [DEPENDS TARGET...])
#
# Declares the sources of one folder as part of a library, core for example. They are compiled as an object library, named
# ${PROJECT_NAME}_LIBRARY_NAME, so that options of single files stay in the folder's CMakeLists.txt. DEPENDS lists libraries
# whose headers the sources include; the library links them privately.
#
# The sources get -O3 where the flags of the build end with -O2, as those of Debian's packages (build type None) and of
# RelWithDebInfo do, because the loops of most folders are written for a compiler that vectorises them. SMALL is for folders
# without such loops: their sources get -O2 where the build has -O3. UNITY compiles several sources at once. It takes a third
# of the time, and wants names in anonymous namespaces to differ between the files of the folder.
string(TOUPPER "${CMAKE_BUILD_TYPE}" build_type)
string(REGEX MATCHALL "-O[0-3a-z]*" levels "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${build_type}}")
set(fast_options "")
set(small_options "")
if(levels MATCHES "-O2$")
  set(fast_options -O3)
elseif(levels MATCHES "-O3$")
  set(small_options -O2)
endif()

# use_precompiled_headers(TARGET OPTIONS): TARGET gets the headers that most sources include from a compiled file. There is one
# such file for each value of OPTIONS, the options with which TARGET is compiled.
function(use_precompiled_headers target options)
  string(MAKE_C_IDENTIFIER "${PROJECT_NAME}_headers${options}" headers)
  if(NOT TARGET ${headers})
    add_library(${headers} OBJECT ${PROJECT_SOURCE_DIR}/cmake/precompiled.cpp)
    set_target_properties(${headers} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    target_compile_options(${headers} PRIVATE ${options})
    target_link_libraries(${headers} PRIVATE opencv_core Threads::Threads)
    target_precompile_headers(${headers} PRIVATE
      <algorithm> <array> <cmath> <cstdint> <filesystem> <fstream> <functional> <limits> <map> <memory> <numeric> <optional>
      <set> <sstream> <stdexcept> <string> <utility> <vector> <opencv2/core.hpp>
    )
  endif()
  target_precompile_headers(${target} REUSE_FROM ${headers})
endfunction()

# unity_build(TARGET): compiles several sources of TARGET at once.
function(unity_build target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
  # A class that is declared in a header and defined in its source file may have members of types that only this file knows.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endfunction()

# source_options(FILE... OPTIONS OPTION...): options of single files. Headers that were compiled without them do not fit.
function(source_options)
  cmake_parse_arguments(arg "" "" "OPTIONS" ${ARGN})
  set_source_files_properties(${arg_UNPARSED_ARGUMENTS} PROPERTIES
    COMPILE_OPTIONS "${arg_OPTIONS}"
    SKIP_PRECOMPILE_HEADERS ON
    SKIP_UNITY_BUILD_INCLUSION ON
  )
endfunction()

function(source_folder library name)
  cmake_parse_arguments(arg "SMALL;UNITY" "" "SOURCES;DEPENDS" ${ARGN})
  set(library ${PROJECT_NAME}_${library})
  set(objects ${library}_${name})
  set(options ${fast_options})
  if(arg_SMALL)
    set(options ${small_options})
  endif()
  add_library(${objects} OBJECT ${arg_SOURCES})
  set_target_properties(${objects} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_include_directories(${objects} PRIVATE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src)
  target_compile_options(${objects} PRIVATE ${options})
  target_link_libraries(${objects} PRIVATE opencv_core Threads::Threads ${arg_DEPENDS})
  use_precompiled_headers(${objects} "${options}")
  if(arg_UNITY)
    unity_build(${objects})
  endif()
  target_sources(${library} PRIVATE $<TARGET_OBJECTS:${objects}>)
  if(arg_DEPENDS)
    target_link_libraries(${library} PRIVATE ${arg_DEPENDS})
  endif()
endfunction()
