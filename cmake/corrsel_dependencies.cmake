# Finds the packages that each part of corrsel needs. Everything that is missing is reported in one error, with the
# Debian package that provides it and the option that leaves the part out.
set(missing "")
set(missing_packages "")

# corrsel_check(FOUND_VARIABLE NAME PART DEBIAN_PACKAGE): notes NAME as missing where FOUND_VARIABLE is false.
macro(corrsel_check found name part debian_package)
  if(NOT ${found})
    string(APPEND missing "\n  ${name}, needed by ${part} (Debian package ${debian_package})")
    list(APPEND missing_packages ${debian_package})
  endif()
endmacro()

# corrsel_report_missing(): stops with an error if anything has been noted as missing.
macro(corrsel_report_missing)
  if(missing)
    list(REMOVE_DUPLICATES missing_packages)
    string(REPLACE ";" " " missing_packages "${missing_packages}")
    message(FATAL_ERROR "These packages are missing:${missing}\nOn Debian 12: apt-get install ${missing_packages}")
  endif()
endmacro()

set(core_part "corrsel::core")
set(features_part "corrsel::features; -D${PROJECT_NAME}_FEATURES=OFF builds corrsel::core alone")
set(benchmark_part "corrsel::benchmark; -D${PROJECT_NAME}_BENCHMARK=OFF builds without it")

find_package(Threads REQUIRED)
find_package(Eigen3 QUIET)
corrsel_check(Eigen3_FOUND "Eigen 3" "${core_part}" libeigen3-dev)
set(opencv_modules core)
if(${PROJECT_NAME}_FEATURES)
  list(APPEND opencv_modules features2d imgproc)
  # VLFeat comes with neither a CMake nor a pkg-config file.
  find_path(VLFEAT_INCLUDE_DIR vl/covdet.h)
  find_library(VLFEAT_LIBRARY vl)
  set(vlfeat_found FALSE)
  if(VLFEAT_INCLUDE_DIR AND VLFEAT_LIBRARY)
    set(vlfeat_found TRUE)
  endif()
  corrsel_check(vlfeat_found
    "VLFeat (searched with VLFEAT_INCLUDE_DIR and VLFEAT_LIBRARY)" "${features_part}" libvlfeat-dev
  )
endif()
if(${PROJECT_NAME}_BENCHMARK)
  list(APPEND opencv_modules imgcodecs)
  find_package(PkgConfig QUIET)
  corrsel_check(PKG_CONFIG_FOUND "pkg-config" "${benchmark_part}" pkg-config)
  if(PKG_CONFIG_FOUND)
    pkg_check_modules(MATIO QUIET IMPORTED_TARGET matio)
    corrsel_check(MATIO_FOUND "matio" "${benchmark_part}" libmatio-dev)
  endif()
  find_package(nlohmann_json QUIET)
  corrsel_check(nlohmann_json_FOUND "nlohmann-json" "${benchmark_part}" nlohmann-json3-dev)
  find_package(yaml-cpp QUIET)
  corrsel_check(yaml-cpp_FOUND "yaml-cpp" "${benchmark_part}" libyaml-cpp-dev)
endif()
find_package(OpenCV 4.5 QUIET COMPONENTS ${opencv_modules})
string(REPLACE ";" ", " opencv_text "${opencv_modules}")
corrsel_check(OpenCV_FOUND "OpenCV 4.5 or newer with the modules ${opencv_text}" "${core_part}" libopencv-dev)

# ROS: AUTO builds its parts where catkin is found.
if(NOT ${PROJECT_NAME}_ROS MATCHES "^(AUTO|ON|OFF|TRUE|FALSE|YES|NO|1|0)$")
  message(FATAL_ERROR "${PROJECT_NAME}_ROS is '${${PROJECT_NAME}_ROS}'; valid values: AUTO, ON, OFF")
endif()
if(${PROJECT_NAME}_ROS AND NOT ${PROJECT_NAME}_ROS STREQUAL AUTO AND NOT ${PROJECT_NAME}_BENCHMARK)
  message(FATAL_ERROR "${PROJECT_NAME}_ROS=ON needs corrsel::benchmark: also set ${PROJECT_NAME}_FEATURES=ON and "
    "${PROJECT_NAME}_BENCHMARK=ON"
  )
endif()
set(ros_packages
  cv_bridge:libcv-bridge-dev
  diagnostic_updater:libdiagnostic-updater-dev
  dynamic_reconfigure:libdynamic-reconfigure-config-init-mutex-dev
  image_geometry:libimage-geometry-dev
  image_transport:libimage-transport-dev
  message_filters:libmessage-filters-dev
  message_generation:ros-message-generation
  nodelet:libnodeletlib-dev
  pluginlib:pluginlib-dev
  rosbag:librosbag-dev
  rosbag_storage:librosbag-storage-dev
  roscpp:libroscpp-dev
  roslib:libroslib-dev
  sensor_msgs:libsensor-msgs-dev
  std_msgs:libstd-msgs-dev
)
string(REGEX REPLACE ":[^;]*" "" ros_components "${ros_packages}")
set(catkin_FOUND FALSE)
if(${PROJECT_NAME}_ROS AND ${PROJECT_NAME}_BENCHMARK)
  find_package(catkin QUIET COMPONENTS ${ros_components})
  set(ros_part "the ROS nodes; -D${PROJECT_NAME}_ROS=OFF builds without ROS")
  if(catkin_FOUND)
    foreach(ros_package ${ros_packages})
      string(REPLACE ":" ";" ros_package ${ros_package})
      list(GET ros_package 0 component)
      list(GET ros_package 1 debian_package)
      corrsel_check(${component}_FOUND "the ROS package ${component}" "${ros_part}" ${debian_package})
    endforeach()
  elseif(NOT ${PROJECT_NAME}_ROS STREQUAL AUTO)
    corrsel_check(catkin_FOUND "catkin" "${ros_part}" catkin)
  endif()
endif()

corrsel_report_missing()
