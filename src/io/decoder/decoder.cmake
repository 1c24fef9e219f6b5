# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# pliant-decode-pixels: the program that the library starts for compressed DICOM pixels. No part of
# the library: it alone links GDCM.

include(GNUInstallDirs)
add_executable(pliant_decoder decoder/main.cpp decoder/sandbox.cpp)
add_executable(pliant::decode_pixels ALIAS pliant_decoder)
set_target_properties(pliant_decoder PROPERTIES
    OUTPUT_NAME pliant-decode-pixels EXPORT_NAME decode_pixels
    RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
target_include_directories(pliant_decoder PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}
                                                  ${PROJECT_SOURCE_DIR}/src/core)
# GDCM's headers have warnings of their own.
target_include_directories(pliant_decoder SYSTEM PRIVATE ${GDCM_INCLUDE_DIRS})
target_link_libraries(pliant_decoder PRIVATE gdcmMSFF gdcmDICT gdcmDSED gdcmCommon)
# A sanitizer's memory is beyond the limits of the program, and its system calls are forbidden.
if(NOT PLIANT_SANITIZE AND NOT PLIANT_FUZZ)
    target_link_libraries(pliant_decoder PRIVATE pliant_flags)
endif()
add_dependencies(pliant_io pliant_decoder)
# The programs of the build tree look in libexec/pliant above their folder.
foreach(folder IN ITEMS libexec/pliant tests/libexec/pliant)
    add_custom_command(TARGET pliant_decoder POST_BUILD
        COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/${folder}
        COMMAND ${CMAKE_COMMAND} -E create_symlink $<TARGET_FILE:pliant_decoder>
                ${PROJECT_BINARY_DIR}/${folder}/pliant-decode-pixels
        VERBATIM)
endforeach()
# Where a host that links the static library finds it: installed, or in this build tree.
if(PLIANT_INSTALL)
    set(decoder_folder ${CMAKE_INSTALL_FULL_LIBEXECDIR}/pliant)
else()
    set(decoder_folder ${PROJECT_BINARY_DIR})
endif()
set_source_files_properties(formats/find_pixel_decoder.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON
    COMPILE_DEFINITIONS PLIANT_DECODER_FOLDER="${decoder_folder}")
