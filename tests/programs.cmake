# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0

pliant_test(serve
    SOURCES ../support/scan_files.cpp test_checkpoint.cpp test_client.cpp test_commands.cpp
            test_files.cpp test_frames.cpp test_hostile.cpp test_overlay.cpp test_path.cpp
            test_scene.cpp test_server.cpp test_vessel.cpp
    LIBRARIES nlohmann_json::nlohmann_json)
if(PLIANT_BUILD_APP)
    pliant_test(apps SOURCES ../../apps/pliant/camera_path.cpp ../../apps/pliant/keyframes.cpp
                             ../serve/test_client.cpp test_keyframes.cpp test_mesh.cpp test_path.cpp
                             test_program.cpp test_serve.cpp test_value_range.cpp
                             test_vessel.cpp
                LIBRARIES nlohmann_json::nlohmann_json)
    target_compile_definitions(test_apps PRIVATE PLIANT_PROGRAM="$<TARGET_FILE:pliant_app>")
    add_dependencies(test_apps pliant_app)
endif()
# The pages of results: what draws and measures is tested, not the program that times.
pliant_test(results
    SOURCES ../../benchmarks/results_page/chart.cpp
            ../../benchmarks/results_page/page.cpp
            ../../benchmarks/results_page/plot.cpp
            ../../benchmarks/results_chainmail/setups.cpp
            ../../benchmarks/results_chainmail/slices.cpp
            test_plot.cpp test_setups.cpp)
target_include_directories(test_results PRIVATE
    ${PROJECT_SOURCE_DIR}/benchmarks/results_chainmail
    ${PROJECT_SOURCE_DIR}/benchmarks/results_page)
# What reads other people's bytes, with bytes that nobody meant.
add_subdirectory(fuzz)
