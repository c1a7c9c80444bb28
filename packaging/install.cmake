# cmake --install: the program, what it runs, its man page and shell completion, and the layers as
# libraries for find_package(Aspic). cpack: a Debian package of the same, but for the libraries.
include(CMakePackageConfigHelpers)

install(TARGETS aspic COMPONENT program)
install(TARGETS aspic-assimp DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/aspic COMPONENT program)
if(TARGET aspic-openvdb)
  install(TARGETS aspic-openvdb DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/aspic COMPONENT program)
endif()
install(FILES packaging/aspic.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
install(FILES packaging/aspic.bash-completion COMPONENT program RENAME aspic
  DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(DIRECTORY graphs DESTINATION ${CMAKE_INSTALL_DATADIR}/aspic COMPONENT program
  PATTERN "*.py" EXCLUDE)
install(FILES LICENSE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Aspic)
install(EXPORT AspicTargets NAMESPACE Aspic:: DESTINATION ${package_dir})
configure_package_config_file(packaging/AspicConfig.cmake.in ${CMAKE_BINARY_DIR}/AspicConfig.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/AspicConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/AspicConfig.cmake ${CMAKE_BINARY_DIR}/AspicConfigVersion.cmake
  DESTINATION ${package_dir})

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME aspic)
set(CPACK_PACKAGE_VENDOR "The Aspic developers")
set(CPACK_PACKAGE_CONTACT "The Aspic developers <aspic@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "node graphs of deformation effects, cooked and rendered headless")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL program)
set(CPACK_COMPONENTS_GROUPING ALL_COMPONENTS_IN_ONE)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "libosmesa6, ffmpeg")  # loaded and run, not linked
include(CPack)
