# The Debian package without ROS: after the build, `cpack -G DEB` in the build folder writes corrsel_VERSION_ARCHITECTURE.deb.
# With ROS, bloom writes the package ros-corrsel instead (scripts/maintenance/make_deb.sh).
#
# The package is installed below /usr, whatever the prefix of the build is. Libraries and programs find each other there by
# their relative paths. CPack needs Debian's packages dpkg-dev and file to find out which shared libraries are used.
string(REGEX MATCH "<description>[ \n]*([^.]+)" _ "${package_xml}")
string(REGEX REPLACE "[ \n]+" " " CPACK_PACKAGE_DESCRIPTION_SUMMARY "${CMAKE_MATCH_1}")
set(CPACK_PACKAGE_DESCRIPTION "Libraries with their headers, the Python package, and the benchmark with its report, without ROS.")
string(REGEX MATCH "<maintainer email=\"([^\"]+)\">([^<]+)" _ "${package_xml}")
set(CPACK_PACKAGE_CONTACT "${CMAKE_MATCH_2} <${CMAKE_MATCH_1}>")
set(CPACK_PACKAGE_VERSION ${CORRSEL_VERSION})
set(CPACK_GENERATOR DEB)
set(CPACK_STRIP_FILES ON)
# Everybody can read the folders, whatever the umask of the build is.
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE
)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_CONFLICTS ros-${PROJECT_NAME})  # It has the same files.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# dpkg-shlibdeps looks for the package's own libraries here where they have no relative paths, as after a build for /usr.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_LIBRARY_OUTPUT_DIRECTORY})
set(CPACK_DEBIAN_PACKAGE_DEPENDS libopencv-dev)  # The public headers include those of OpenCV's core module, and no Eigen.
if(${PROJECT_NAME}_PYTHON)
  # The modules in C++ fit one minor version of Python.
  math(EXPR next_minor "${Python3_VERSION_MINOR} + 1")
  string(APPEND CPACK_DEBIAN_PACKAGE_DEPENDS
    ", python3 (>= ${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR}), python3 (<< ${Python3_VERSION_MAJOR}.${next_minor})"
    ", python3-jinja2, python3-matplotlib, python3-numpy, python3-yaml"
  )
  set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-h5py, python3-opencv")  # for files of hloc, and for images
  set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_LIST_DIR}/prerm)
  set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
  # Debian's packages have their Python packages in another folder than installations below /usr/local.
  get_filename_component(parent ${${PROJECT_NAME}_PYTHON_DESTINATION} DIRECTORY)
  install(CODE "
    set(prefix \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}\")
    set(folder ${${PROJECT_NAME}_PYTHON_DESTINATION})
    if(prefix MATCHES \"/_CPack_Packages/.*/DEB/\" AND NOT folder STREQUAL \"lib/python3/dist-packages\")
      file(MAKE_DIRECTORY \"\${prefix}/lib/python3\")
      file(RENAME \"\${prefix}/\${folder}\" \"\${prefix}/lib/python3/dist-packages\")
      file(REMOVE_RECURSE \"\${prefix}/${parent}\")
    endif()
  ")
endif()
install(FILES LICENSE DESTINATION share/doc/${PROJECT_NAME} RENAME copyright)
include(CPack)
