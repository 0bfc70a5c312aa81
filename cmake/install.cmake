# What is installed, with ROS and without, and how find_package(corrsel) finds it.
#
# Every library is an export set of its own, so that an application loads only the targets that it asks for. With ROS,
# catkin writes corrselConfig.cmake, which includes corrsel-targets.cmake. Without ROS, that file is corrselConfig.cmake.
include(CMakePackageConfigHelpers)

set(libraries core)
if(${PROJECT_NAME}_REFERENCE)
  list(APPEND libraries reference)
endif()
if(${PROJECT_NAME}_FEATURES)
  list(APPEND libraries features)
endif()
if(${PROJECT_NAME}_BENCHMARK)
  list(APPEND libraries benchmark)
endif()
if(${PROJECT_NAME}_DATABASE)
  list(APPEND libraries database)
endif()

if(catkin_FOUND)
  set(config_destination ${CATKIN_PACKAGE_SHARE_DESTINATION}/cmake)
else()
  set(config_destination ${CMAKE_INSTALL_LIBDIR}/cmake/${PROJECT_NAME})
endif()

foreach(library ${libraries})
  #catkin_lint: ignore undefined_target
  install(TARGETS ${PROJECT_NAME}_${library} EXPORT ${PROJECT_NAME}_${library}_targets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  )
  install(EXPORT ${PROJECT_NAME}_${library}_targets
    FILE ${PROJECT_NAME}-${library}.cmake
    NAMESPACE ${PROJECT_NAME}::
    DESTINATION ${config_destination}
  )
  if(catkin_FOUND)
    export(EXPORT ${PROJECT_NAME}_${library}_targets
      FILE ${CATKIN_DEVEL_PREFIX}/share/${PROJECT_NAME}/cmake/${PROJECT_NAME}-${library}.cmake
      NAMESPACE ${PROJECT_NAME}::
    )
  else()
    export(EXPORT ${PROJECT_NAME}_${library}_targets
      FILE ${PROJECT_BINARY_DIR}/${PROJECT_NAME}-${library}.cmake
      NAMESPACE ${PROJECT_NAME}::
    )
  endif()
endforeach()

if(catkin_FOUND)
  install(DIRECTORY include/${PROJECT_NAME}/ DESTINATION ${CATKIN_PACKAGE_INCLUDE_DESTINATION})
  install(
    TARGETS ${PROJECT_NAME}_bags ${PROJECT_NAME}_nodelets ${PROJECT_NAME}_reference_plugins ${PROJECT_NAME}_ros
    ARCHIVE DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
    LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
  )
  install(DIRECTORY config examples launch migration_rules DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
  install(FILES nodelet_plugins.xml reference_plugins.xml DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
  catkin_install_python(
    PROGRAMS
      scripts/export_matches.py scripts/kitti_to_bag.py scripts/matches_to_bag.py scripts/report.py
    DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION}
  )
  # The other scripts build the package and are of no use in an installation.
  #catkin_lint: ignore uninstalled_script
  install(PROGRAMS scripts/fetch_samples.sh DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
  install(FILES scripts/apt.sh DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
else()
  # catkin_lint's rules are those of an installation with catkin.
  #catkin_lint: skip
  file(GLOB headers include/${PROJECT_NAME}/*.h)
  install(FILES ${headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${PROJECT_NAME})
  set(core_headers search evaluation selectors)
  set(reference_headers reference)
  set(features_headers features matching tracking)
  set(benchmark_headers benchmark datasets pose)
  set(database_headers database)
  foreach(library ${libraries})
    foreach(folder ${${library}_headers})
      install(DIRECTORY include/${PROJECT_NAME}/${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${PROJECT_NAME})
    endforeach()
  endforeach()
  configure_file(cmake/${PROJECT_NAME}-targets.cmake.in ${PROJECT_NAME}Config.cmake @ONLY)
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/${PROJECT_NAME}ConfigVersion.cmake
    VERSION ${CORRSEL_VERSION}
    COMPATIBILITY SameMinorVersion
  )
  install(
    FILES
      ${PROJECT_BINARY_DIR}/${PROJECT_NAME}Config.cmake
      ${PROJECT_BINARY_DIR}/${PROJECT_NAME}ConfigVersion.cmake
    DESTINATION ${config_destination}
  )
endif()
