# Finds the packages that each part of corrsel needs. Everything that is missing is reported in one error, with the
# Debian package that provides it and the option that leaves the part out.
set(missing "")
set(missing_packages "")

# check_found(FOUND_VARIABLE NAME PART DEBIAN_PACKAGE): notes NAME as missing where FOUND_VARIABLE is false.
macro(check_found found name part debian_package)
  if(NOT ${found})
    string(APPEND missing "\n  ${name}, needed by ${part} (Debian package ${debian_package})")
    list(APPEND missing_packages ${debian_package})
  endif()
endmacro()

# report_missing(): stops with an error if anything has been noted as missing.
macro(report_missing)
  if(missing)
    list(REMOVE_DUPLICATES missing_packages)
    string(REPLACE ";" " " missing_packages "${missing_packages}")
    message(FATAL_ERROR "These packages are missing:${missing}\nOn Debian 12: apt-get install ${missing_packages}")
  endif()
endmacro()

set(core_part "${PROJECT_NAME}::core")
set(benchmark_part "${PROJECT_NAME}::benchmark; -D${PROJECT_NAME}_BENCHMARK=OFF builds without it")
set(database_part "${PROJECT_NAME}::database; -D${PROJECT_NAME}_DATABASE=OFF builds without it")
set(both_parts "${PROJECT_NAME}::benchmark and ${PROJECT_NAME}::database")

find_package(Threads REQUIRED)
find_package(Eigen3 QUIET)
check_found(Eigen3_FOUND "Eigen 3" "${core_part}" libeigen3-dev)
set(opencv_modules core)
if(${PROJECT_NAME}_BENCHMARK OR ${PROJECT_NAME}_DATABASE)
  find_package(PkgConfig QUIET)
  check_found(PKG_CONFIG_FOUND "pkg-config" "${both_parts}" pkg-config)
  find_package(nlohmann_json QUIET)
  check_found(nlohmann_json_FOUND "nlohmann-json" "${both_parts}" nlohmann-json3-dev)
endif()
if(${PROJECT_NAME}_FEATURES)
  list(APPEND opencv_modules features2d imgproc video)
  find_package(yaml-cpp QUIET)  # the benchmark needs it, and corrsel_match is built where it is found
  # The target is named yaml-cpp up to version 0.7 and yaml-cpp::yaml-cpp from 0.8 on.
  set(yaml_cpp_target yaml-cpp)
  if(TARGET yaml-cpp::yaml-cpp)
    set(yaml_cpp_target yaml-cpp::yaml-cpp)
  endif()
endif()
if(${PROJECT_NAME}_BENCHMARK)
  list(APPEND opencv_modules calib3d imgcodecs)
  if(PKG_CONFIG_FOUND)
    pkg_check_modules(MATIO QUIET IMPORTED_TARGET matio)
    check_found(MATIO_FOUND "matio" "${benchmark_part}" libmatio-dev)
  endif()
  check_found(yaml-cpp_FOUND "yaml-cpp" "${benchmark_part}" libyaml-cpp-dev)
endif()
if(${PROJECT_NAME}_DATABASE)
  if(NOT imgcodecs IN_LIST opencv_modules)
    list(APPEND opencv_modules imgcodecs)
  endif()
  find_package(SQLite3 QUIET)
  check_found(SQLite3_FOUND "SQLite 3" "${database_part}" libsqlite3-dev)
  if(PKG_CONFIG_FOUND)
    pkg_search_module(HDF5 QUIET IMPORTED_TARGET hdf5-serial hdf5)
    check_found(HDF5_FOUND "HDF5" "${database_part}" libhdf5-dev)
  endif()
endif()
find_package(OpenCV 4.2 QUIET COMPONENTS ${opencv_modules})
string(REPLACE ";" ", " opencv_text "${opencv_modules}")
check_found(OpenCV_FOUND "OpenCV 4.2 or newer with the modules ${opencv_text}" "${core_part}" libopencv-dev)

# ROS: AUTO builds its parts where catkin is found.
if(NOT "${${PROJECT_NAME}_ROS}" MATCHES "^(AUTO|ON|OFF|TRUE|FALSE|YES|NO|1|0)$")
  message(FATAL_ERROR "${PROJECT_NAME}_ROS is '${${PROJECT_NAME}_ROS}'; valid values: AUTO, ON, OFF")
endif()
if(${PROJECT_NAME}_ROS AND NOT "${${PROJECT_NAME}_ROS}" STREQUAL "AUTO" AND NOT ${PROJECT_NAME}_BENCHMARK)
  message(FATAL_ERROR "${PROJECT_NAME}_ROS=ON needs ${PROJECT_NAME}::benchmark: also set ${PROJECT_NAME}_FEATURES=ON and "
    "${PROJECT_NAME}_BENCHMARK=ON"
  )
endif()
set(ros_components
  camera_calibration_parsers
  cv_bridge
  diagnostic_msgs
  diagnostic_updater
  dynamic_reconfigure
  geometry_msgs
  image_geometry
  image_transport
  message_filters
  message_generation
  nodelet
  pluginlib
  rosbag
  rosbag_storage
  roscpp
  roslib
  sensor_msgs
  std_msgs
  tf2_ros
  xmlrpcpp
)
set(ros_debian_packages
  libcamera-calibration-parsers-dev
  libcv-bridge-dev
  libdiagnostic-msgs-dev
  libdiagnostic-updater-dev
  libdynamic-reconfigure-config-init-mutex-dev
  libgeometry-msgs-dev
  libimage-geometry-dev
  libimage-transport-dev
  libmessage-filters-dev
  ros-message-generation
  libnodeletlib-dev
  pluginlib-dev
  librosbag-dev
  librosbag-storage-dev
  libroscpp-dev
  libroslib-dev
  libsensor-msgs-dev
  libstd-msgs-dev
  libtf2-ros-dev
  libxmlrpcpp-dev
)
set(catkin_FOUND FALSE)
if(${PROJECT_NAME}_ROS AND ${PROJECT_NAME}_BENCHMARK)
  # The GMockConfig.cmake of Debian 11 (package cmake-extras) and catkin do not fit together; without it, catkin builds
  # GoogleTest from the sources that libgtest-dev brings.
  set(CMAKE_DISABLE_FIND_PACKAGE_GMock ON)
  #catkin_lint: ignore missing_required
  find_package(catkin QUIET COMPONENTS ${ros_components})
  set(ros_part "the ROS nodes; -D${PROJECT_NAME}_ROS=OFF builds without ROS")
  if(catkin_FOUND)
    foreach(component ${ros_components})
      list(FIND ros_components ${component} index)
      list(GET ros_debian_packages ${index} debian_package)
      check_found(${component}_FOUND "the ROS package ${component}" "${ros_part}" ${debian_package})
    endforeach()
  elseif(NOT "${${PROJECT_NAME}_ROS}" STREQUAL "AUTO")
    check_found(catkin_FOUND "catkin" "${ros_part}" catkin)
  endif()
endif()
report_missing()
