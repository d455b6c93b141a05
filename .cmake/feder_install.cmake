# Install tree: headers keep their paths from the root, so "engine/kkt.h" reads the same inside and outside.
include(CMakePackageConfigHelpers)
install(TARGETS feder_engine feder_solvers feder_models EXPORT federTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT federTargets NAMESPACE feder:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/feder)
foreach(folder engine solvers models)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/feder
          FILES_MATCHING PATTERN "*.h" PATTERN "scenes" EXCLUDE)
endforeach()
# The gallery is data for the reader of scene files; its README.md says what they may hold.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/models/scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/feder)
configure_package_config_file(${PROJECT_SOURCE_DIR}/.cmake/federConfig.cmake.in ${PROJECT_BINARY_DIR}/federConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/feder)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/federConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/federConfig.cmake ${PROJECT_BINARY_DIR}/federConfigVersion.cmake
              ${PROJECT_SOURCE_DIR}/.cmake/FindSuiteSparse.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/feder)
