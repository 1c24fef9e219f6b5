# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# What `cmake --install` puts down: the library's components with the headers, a package that
# find_package(pliant) finds, and the program. The table of components and the recipes go along, so
# that those who use the library find the same third-party packages in the same way as this build.
# The component `program` is what runs alone, `dev` is for those who build with the library.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/pliant)

foreach(component IN LISTS PLIANT_BUILT)
    install(TARGETS pliant_${component} EXPORT pliant-${component}
            ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
            LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT program
                    NAMELINK_COMPONENT dev)
    if(component STREQUAL io)
        install(TARGETS pliant_decoder EXPORT pliant-io
                RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/pliant COMPONENT program)
    endif()
    install(EXPORT pliant-${component} NAMESPACE pliant:: DESTINATION ${package_dir}
            COMPONENT dev)
    foreach(recipe IN LISTS PLIANT_${component}_RECIPES)
        install(FILES cmake/recipes/${recipe}.cmake DESTINATION ${package_dir}/recipes
                COMPONENT dev)
    endforeach()
endforeach()
install(DIRECTORY include/pliant DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev
        FILES_MATCHING PATTERN "*.h")
if(PLIANT_RESEARCH)
    install(DIRECTORY research/include/pliant DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
            COMPONENT dev FILES_MATCHING PATTERN "*.h")
endif()

set(PLIANT_LINKS_RECIPES ON)
if(BUILD_SHARED_LIBS)
    set(PLIANT_LINKS_RECIPES OFF)
endif()
configure_package_config_file(cmake/pliant-config.cmake.in
    ${PROJECT_BINARY_DIR}/pliant-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/pliant-config-version.cmake
    COMPATIBILITY SameMinorVersion)
install(FILES cmake/house.cmake
              ${PROJECT_BINARY_DIR}/pliant-config.cmake
              ${PROJECT_BINARY_DIR}/pliant-config-version.cmake
        DESTINATION ${package_dir} COMPONENT dev)

if(PLIANT_BUILD_APP)
    install(TARGETS pliant_app RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
    # Manual pages and completions, where `./dev package` has made them.
    install(DIRECTORY ${PROJECT_BINARY_DIR}/descriptions/ DESTINATION ${CMAKE_INSTALL_DATADIR}
            COMPONENT program OPTIONAL)
endif()
install(FILES LICENSE THIRD_PARTY.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)

# What the build is made of, as SPDX; written when it is installed, with that time's date.
function(pliant_install_contents component folder)
    find_package(Python3 QUIET COMPONENTS Interpreter)
    if(NOT Python3_Interpreter_FOUND)
        return()
    endif()
    set(file ${PROJECT_BINARY_DIR}/pliant.spdx.json)
    set(page)
    if(PLIANT_BUILD_VIEWER)
        set(page ${PROJECT_SOURCE_DIR}/viewer/package-lock.json)
    endif()
    install(CODE "execute_process(COMMAND \"${Python3_EXECUTABLE}\"
        \"${PROJECT_SOURCE_DIR}/tools/package/sbom.py\" ${PROJECT_VERSION} \"${file}\" ${page}
        COMMAND_ERROR_IS_FATAL ANY)" COMPONENT ${component})
    install(FILES ${file} DESTINATION ${folder} COMPONENT ${component})
endfunction()
pliant_install_contents(program ${CMAKE_INSTALL_DOCDIR})

# Shared libraries are found beside each other, and from the program's folder.
if(BUILD_SHARED_LIBS AND NOT DEFINED CMAKE_INSTALL_RPATH)
    foreach(component IN LISTS PLIANT_COMPONENTS)
        set_target_properties(pliant_${component} PROPERTIES INSTALL_RPATH "$ORIGIN")
    endforeach()
    if(PLIANT_BUILD_APP)
        file(RELATIVE_PATH to_libraries ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
        set_target_properties(pliant_app PROPERTIES INSTALL_RPATH "$ORIGIN/${to_libraries}")
    endif()
endif()
