# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# What `cmake --install` puts down: the library with its headers, a package that
# find_package(pliant) finds, and the program. The recipes go along, so that those who use the
# library find the same third-party packages in the same way as this build.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/pliant)

install(TARGETS pliant EXPORT pliant ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY include/pliant DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        FILES_MATCHING PATTERN "*.h")
install(EXPORT pliant NAMESPACE pliant:: DESTINATION ${package_dir} FILE pliant-targets.cmake)
foreach(recipe IN LISTS PLIANT_LIBRARY_RECIPES)
    install(FILES cmake/recipes/${recipe}.cmake DESTINATION ${package_dir}/recipes)
endforeach()

configure_package_config_file(cmake/pliant-config.cmake.in
    ${PROJECT_BINARY_DIR}/pliant-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/pliant-config-version.cmake
    COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/pliant-config.cmake
              ${PROJECT_BINARY_DIR}/pliant-config-version.cmake
        DESTINATION ${package_dir})

install(TARGETS pliant_decoder EXPORT pliant
        RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/pliant)
if(PLIANT_BUILD_APP)
    install(TARGETS pliant_app RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(FILES LICENSE THIRD_PARTY.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
