# source_folder(LIBRARY NAME SOURCES... [DEPENDS TARGET...])
#
# Declares the sources of one folder as part of a library; LIBRARY is core, reference, features or benchmark. They are compiled as an
# object library, named ${PROJECT_NAME}_LIBRARY_NAME, so that options set with set_source_files_properties() stay in the
# folder's CMakeLists.txt. DEPENDS lists libraries whose headers the sources include; the library links them privately.
#
# They get -O3 where the flags of the build end with -O2, as those of Debian's packages (build type None) and of
# RelWithDebInfo do: the loops of these folders are written for a compiler that vectorises them.
string(TOUPPER "${CMAKE_BUILD_TYPE}" build_type)
string(REGEX MATCHALL "-O[0-3a-z]*" levels "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${build_type}}")
set(source_folder_options "")
if(levels MATCHES "-O2$")
  set(source_folder_options -O3)
endif()
function(source_folder library name)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPENDS" ${ARGN})
  set(library ${PROJECT_NAME}_${library})
  set(objects ${library}_${name})
  add_library(${objects} OBJECT ${arg_SOURCES})
  set_target_properties(${objects} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_include_directories(${objects} PRIVATE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src)
  target_compile_options(${objects} PRIVATE ${source_folder_options})
  target_link_libraries(${objects} PRIVATE opencv_core Threads::Threads ${arg_DEPENDS})
  target_sources(${library} PRIVATE $<TARGET_OBJECTS:${objects}>)
  if(arg_DEPENDS)
    target_link_libraries(${library} PRIVATE ${arg_DEPENDS})
  endif()
endfunction()
