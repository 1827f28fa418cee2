# cmake --install: program, libraries, headers, schema, and the package that find_package(gyrator) reads.
include(CMakePackageConfigHelpers)

list(TRANSFORM gyrator_rooms PREPEND gyrator_ OUTPUT_VARIABLE gyrator_targets)

install(TARGETS ${gyrator_targets} gyrator
  EXPORT gyratorTargets
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR}
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY src/gyrator DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.hpp" PATTERN "app" EXCLUDE)
install(FILES ${PROJECT_BINARY_DIR}/generated/gyrator/version.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/gyrator)
install(FILES schemas/model.schema.json schemas/study.schema.json schemas/regression.schema.json schemas/design.schema.json schemas/amplifier.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/gyrator)
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DATADIR}/gyrator FILES_MATCHING PATTERN "*.json" PATTERN "*.csv")
install(DIRECTORY profiles DESTINATION ${CMAKE_INSTALL_DATADIR}/gyrator FILES_MATCHING PATTERN "*.json")

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/gyrator)
install(EXPORT gyratorTargets NAMESPACE gyrator:: DESTINATION ${package_dir})
configure_package_config_file(cmake/gyratorConfig.cmake.in ${PROJECT_BINARY_DIR}/gyratorConfig.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/gyratorConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/gyratorConfig.cmake ${PROJECT_BINARY_DIR}/gyratorConfigVersion.cmake
  cmake/GyratorDependencies.cmake cmake/FindSerialHdf5.cmake cmake/FindLibmodbus.cmake
  DESTINATION ${package_dir})
