# source_folder(LIBRARY NAME SOURCES... [DEPENDS TARGET...])
#
# Declares the sources of one folder as part of a library; LIBRARY is core, features or benchmark. They are compiled as an
# object library, named ${PROJECT_NAME}_LIBRARY_NAME, so that options set with set_source_files_properties() stay in the
# folder's CMakeLists.txt. DEPENDS lists libraries whose headers the sources include; the library links them privately.
function(source_folder library name)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPENDS" ${ARGN})
  set(library ${PROJECT_NAME}_${library})
  set(objects ${library}_${name})
  add_library(${objects} OBJECT ${arg_SOURCES})
  set_target_properties(${objects} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_include_directories(${objects} PRIVATE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(${objects} PRIVATE opencv_core Threads::Threads ${arg_DEPENDS})
  target_sources(${library} PRIVATE $<TARGET_OBJECTS:${objects}>)
  if(arg_DEPENDS)
    target_link_libraries(${library} PRIVATE ${arg_DEPENDS})
  endif()
endfunction()
