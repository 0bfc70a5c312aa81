# Finds what the Python package needs. Sets corrsel_PYTHON to OFF, and reports why, where something is missing.
#
# corrsel_PYTHON_DESTINATION is the folder for packages, relative to the prefix: the one below the prefix that the
# interpreter searches, else one named like those it searches.
if(${PROJECT_NAME}_SANITIZE)
  # An interpreter built without the sanitizer cannot load such a module.
  set(${PROJECT_NAME}_PYTHON OFF)
  message(STATUS "Python package: not built with sanitizers")
  return()
endif()
if(PYTHON_EXECUTABLE AND NOT Python3_EXECUTABLE)
  set(Python3_EXECUTABLE ${PYTHON_EXECUTABLE})
endif()
set(development Development)
if(NOT CMAKE_VERSION VERSION_LESS 3.18)
  set(development Development.Module)
endif()
find_package(Python3 3.8 QUIET COMPONENTS Interpreter ${development})
if(NOT Python3_FOUND)
  set(${PROJECT_NAME}_PYTHON OFF)
  message(STATUS "Python package: not built, since the development files of Python 3.8 or later are missing "
    "(python3-dev)")
  return()
endif()
set(PYTHON_EXECUTABLE ${Python3_EXECUTABLE})  # for versions of pybind11 that do not know Python3_EXECUTABLE
# catkin of Debian 13 has found Python, of which it needs the interpreter alone. pybind11 would take that instead of Python3.
unset(Python_FOUND)
find_package(pybind11 2.4 QUIET)
if(NOT pybind11_FOUND)
  set(${PROJECT_NAME}_PYTHON OFF)
  message(STATUS "Python package: not built, since pybind11 is missing (pybind11-dev)")
  return()
endif()

if(NOT ${PROJECT_NAME}_PYTHON_DESTINATION)
  execute_process(
    COMMAND ${Python3_EXECUTABLE} -c "
import os, site, sys
prefix = os.path.join(sys.argv[1], '')
folders = site.getsitepackages()
below = [f[len(prefix):] for f in folders if f.startswith(prefix + 'lib')]
version = 'python%d.%d' % sys.version_info[:2]
print(below[0] if below else 'lib/%s/%s' % (version, os.path.basename(folders[0])))
" ${CMAKE_INSTALL_PREFIX}
    OUTPUT_VARIABLE ${PROJECT_NAME}_PYTHON_DESTINATION
    OUTPUT_STRIP_TRAILING_WHITESPACE
  )
endif()
message(STATUS "Python package: for Python ${Python3_VERSION} (${Python3_EXECUTABLE}), pybind11 ${pybind11_VERSION}")
