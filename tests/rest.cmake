# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0

# The checks of the sources, and each check's own test, which no compiler of the build is part of.
foreach(check IN ITEMS layers bibliography files)
    add_test(NAME check_${check} COMMAND ${PROJECT_SOURCE_DIR}/tools/check_${check})
endforeach()
foreach(check IN ITEMS check_layers check_bibliography check_files check_documents check_hardened
        check_symbols unless_passed)
    add_test(NAME ${check}_self_test COMMAND ${PROJECT_SOURCE_DIR}/tools/${check} --self-test)
endforeach()
find_program(ABIDIFF abidiff)
if(ABIDIFF)
    add_test(NAME abi_self_test COMMAND ${PROJECT_SOURCE_DIR}/tools/abi --self-test)
    set_tests_properties(abi_self_test PROPERTIES LABELS long)
endif()
pliant_test(material
    SOURCES test_material_map.cpp test_passports.cpp test_settings.cpp test_small_bones.cpp)
pliant_test(field
    SOURCES ../support/count_allocations.cpp test_bricks.cpp test_deformation.cpp
            test_trilinear_cell.cpp)
pliant_test(base
    SOURCES test_ended_commits.cpp test_geometry.cpp test_hash.cpp test_input_file.cpp
            test_memory_budget.cpp test_output_file.cpp
            test_record.cpp test_result.cpp test_small_matrix.cpp test_staged_files.cpp
            test_tasks.cpp test_text.cpp test_text_input.cpp)
pliant_test(volume
    SOURCES test_layer_stack.cpp test_phantom.cpp test_sample_linear.cpp test_scan_values.cpp
            test_slices.cpp test_volume.cpp test_voxel_array.cpp)
pliant_test(formats
    SOURCES ../support/scan_files.cpp ../../src/io/decoder/sandbox.cpp recorded_meta.cpp
            recorded_nifti.cpp recorded_nrrd.cpp recorded_types.cpp test_broken_files.cpp
            test_damaged_at_random.cpp test_dicom_codestreams.cpp test_dicom_decoder.cpp
            test_dicom_folders.cpp test_dicom_frames.cpp test_dicom_pixels.cpp
            test_dicom_sandbox.cpp test_dicom_segments.cpp test_dicom_series.cpp
            test_dicom_values.cpp test_dicom_volumes.cpp test_foreign_headers.cpp test_frames.cpp
            test_give_up.cpp
            test_headers.cpp test_mapped_scans.cpp test_nifti_2.cpp test_read_formats.cpp
            test_read_labels.cpp test_read_orientation.cpp test_read_vtk.cpp test_recorded_scans.cpp
            test_shared_scans.cpp test_straighten.cpp test_vector_field.cpp test_voxel_builder.cpp
            test_write_formats.cpp test_write_volume.cpp test_write_vti.cpp
    LIBRARIES pliant_lz4 ZLIB::ZLIB
    INPUTS $<TARGET_FILE:pliant_decoder> ${CMAKE_CURRENT_SOURCE_DIR}/formats/data
           ${CMAKE_CURRENT_SOURCE_DIR}/fuzz/corpus/dicom)
target_compile_definitions(test_formats PRIVATE
    PLIANT_DICOM_CORPUS="${CMAKE_CURRENT_SOURCE_DIR}/fuzz/corpus/dicom"
    PLIANT_TEST_DATA="${CMAKE_CURRENT_SOURCE_DIR}/formats/data")
pliant_test(organs SOURCES test_organs.cpp)
pliant_test(fit SOURCES test_fibres.cpp test_large.cpp test_mesh.cpp test_methods.cpp
            test_published.cpp)
target_include_directories(test_fit PRIVATE ${PROJECT_SOURCE_DIR}/research/results/springs)
pliant_test(mesh
    SOURCES ../support/count_allocations.cpp test_builders.cpp test_check_mesh.cpp
            test_cut_tetrahedra.cpp
            test_distance.cpp test_files.cpp test_fill_surface.cpp test_foreign_files.cpp
            test_limits.cpp test_stuffing.cpp test_write_vtu.cpp
    LIBRARIES ZLIB::ZLIB)
pliant_test(path SOURCES test_lumen_path.cpp test_march.cpp test_wall_distance.cpp)
pliant_test(fem
    SOURCES test_analytic.cpp test_bad_input.cpp test_beams.cpp test_elements.cpp test_fibres.cpp
            test_frames.cpp test_multigrid.cpp test_published.cpp test_solvers.cpp)
pliant_test(tissue
    SOURCES ../support/count_allocations.cpp test_body_cuts.cpp test_endoscopy.cpp
            test_giving_up.cpp test_mesh_tissue.cpp
            test_out_of_memory.cpp test_network_tissue.cpp test_spring_cuts.cpp
            test_spring_deformation.cpp test_state_kinds.cpp test_tissues.cpp test_check_tissue.cpp
            test_elastic_edits.cpp test_elastic_settings_file.cpp test_elastic_tissue.cpp
            test_own_tissue.cpp)
pliant_test(truth
    SOURCES ../support/count_allocations.cpp test_cases.cpp test_elastic_cases.cpp
            test_exact_map.cpp test_out_of_memory.cpp)
pliant_test(catheter
    SOURCES ../support/count_allocations.cpp test_carried_scan.cpp test_chain.cpp
            test_out_of_memory.cpp test_random_vessels.cpp test_scene.cpp
            test_wire.cpp)
pliant_test(vessel
    SOURCES ../support/count_allocations.cpp test_given_wall.cpp test_out_of_memory.cpp
            test_soundness.cpp test_wall.cpp)
pliant_test(scenes SOURCES test_unsteered_tips.cpp INPUTS ${PROJECT_SOURCE_DIR}/scenes)
target_compile_definitions(test_scenes PRIVATE PLIANT_SCENES="${PROJECT_SOURCE_DIR}/scenes")
pliant_test(gym
    SOURCES ../support/count_allocations.cpp test_catheter_arena.cpp test_elastic_walls.cpp
            test_endoscope_arena.cpp test_out_of_memory.cpp test_scene_flow.cpp)
pliant_test(haptics
    SOURCES ../../research/results/haptics/hands.cpp
            ../../research/results/haptics/haptic_run.cpp ../../research/results/haptics/tissues.cpp
            test_feel_catheter.cpp test_live_feel.cpp test_models.cpp test_passivity.cpp
            test_servo.cpp test_servo_step.cpp test_space_mouse.cpp test_stability.cpp
            watch_thread.cpp
    LIBRARIES ${CMAKE_DL_LIBS}
    INPUTS $<TARGET_FILE:example_haptic_device> $<TARGET_FILE:wrong_haptic_device>
           $<TARGET_FILE:fake_spnav>)
target_include_directories(test_haptics PRIVATE
    ${PROJECT_SOURCE_DIR}/research/results/haptics ${PROJECT_SOURCE_DIR}/research/results/page)
# Plug-ins: the one that people begin with, one that must be refused, one that takes its time.
enable_language(C)
add_library(example_haptic_device MODULE ${PROJECT_SOURCE_DIR}/examples/haptic_device/device.c)
add_library(wrong_haptic_device MODULE haptics/wrong_plugin.c)
add_library(slow_haptic_device MODULE haptics/slow_plugin.c)
target_include_directories(slow_haptic_device PRIVATE ${PROJECT_SOURCE_DIR}/include)
foreach(plugin IN ITEMS example wrong)
    target_include_directories(${plugin}_haptic_device PRIVATE ${PROJECT_SOURCE_DIR}/include)
    string(TOUPPER PLIANT_${plugin}_DEVICE definition)
    target_compile_definitions(test_haptics PRIVATE
        ${definition}="$<TARGET_FILE:${plugin}_haptic_device>")
    add_dependencies(test_haptics ${plugin}_haptic_device)
endforeach()
target_link_libraries(example_haptic_device PRIVATE m)
# A library that is loaded in place of libspnav.
add_library(fake_spnav MODULE haptics/fake_spnav.c)
target_compile_definitions(test_haptics PRIVATE
    PLIANT_FAKE_SPNAV_LIBRARY="$<TARGET_FILE:fake_spnav>")
add_dependencies(test_haptics fake_spnav)
pliant_test(protocol
    SOURCES ../hub/read_frames.cpp ../hub/test_client.cpp settings_files.cpp test_commands.cpp
            test_frames.cpp test_settings_files.cpp
    LIBRARIES nlohmann_json::nlohmann_json pliant_lz4
    INPUTS ${PROJECT_SOURCE_DIR}/docs ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src/serve
           ${PROJECT_SOURCE_DIR}/viewer/src)
target_compile_definitions(test_protocol PRIVATE PLIANT_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
pliant_test(session
    SOURCES ../hub/read_frames.cpp ../hub/test_client.cpp ../support/scan_files.cpp
            test_checkpoint.cpp test_scene.cpp test_source.cpp
    LIBRARIES nlohmann_json::nlohmann_json pliant_lz4)
pliant_test(hub
    SOURCES ../support/count_allocations.cpp ../support/scan_files.cpp read_frames.cpp
            test_client.cpp test_changed_blocks.cpp test_depth_for_time.cpp test_fairness.cpp
            test_files.cpp test_haptic_catheter.cpp test_haptics.cpp test_hostile.cpp
            test_labels.cpp test_marks.cpp test_network.cpp test_out_of_memory.cpp
            test_overlay.cpp test_organ.cpp
            test_own_tissue.cpp test_path.cpp test_playback.cpp test_recorder.cpp
            test_recording.cpp test_rest_field.cpp test_server.cpp test_slow_line.cpp
            test_states.cpp test_sweep_pace.cpp test_traffic.cpp test_vessel.cpp
    LIBRARIES nlohmann_json::nlohmann_json Boost::headers OpenSSL::SSL pliant_lz4
    INPUTS ${PROJECT_SOURCE_DIR}/scenes $<TARGET_FILE:slow_haptic_device>)
target_include_directories(test_hub PRIVATE ${PROJECT_SOURCE_DIR}/examples)
target_compile_definitions(test_hub PRIVATE
    PLIANT_SLOW_DEVICE="$<TARGET_FILE:slow_haptic_device>"
    PLIANT_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
add_dependencies(test_hub slow_haptic_device)
if(PLIANT_BUILD_APP)
    pliant_test(apps SOURCES ../../apps/pliant/camera_path.cpp ../../apps/pliant/ending.cpp
                             ../../apps/pliant/keyframes.cpp ../../apps/pliant/movie.cpp
                             ../hub/read_frames.cpp ../hub/test_client.cpp
                             ../support/scan_files.cpp test_body.cpp test_conformance.cpp
                             test_crashes.cpp test_elastic.cpp test_ending.cpp
                             test_ending_movies.cpp test_failing_calls.cpp test_fit_mesh.cpp
                             test_keyframes.cpp test_labels.cpp
                             test_materials.cpp
                             test_kinds_of_scans.cpp
                             test_mesh.cpp test_morph.cpp
                             test_outputs.cpp test_path.cpp
                             test_program.cpp test_readers.cpp test_release_0_2.cpp test_serve.cpp
                             test_truth.cpp
                             test_value_range.cpp test_vessel.cpp
                LIBRARIES nlohmann_json::nlohmann_json pliant_lz4
                INPUTS $<TARGET_FILE:pliant_app> $<TARGET_FILE:pliant_decoder>
                       $<TARGET_FILE:failing_calls> ${CMAKE_CURRENT_SOURCE_DIR}/apps/data
                       ${CMAKE_CURRENT_SOURCE_DIR}/data)
    add_library(failing_calls MODULE apps/failing_calls.c)
    target_link_libraries(failing_calls PRIVATE ${CMAKE_DL_LIBS})
    target_compile_definitions(test_apps PRIVATE
        PLIANT_PROGRAM="$<TARGET_FILE:pliant_app>"
        PLIANT_FAILING_CALLS="$<TARGET_FILE:failing_calls>"
        PLIANT_APPS_DATA="${CMAKE_CURRENT_SOURCE_DIR}/apps/data")
    set_source_files_properties(apps/test_release_0_2.cpp PROPERTIES
        SKIP_UNITY_BUILD_INCLUSION ON
        COMPILE_DEFINITIONS PLIANT_RELEASES="${CMAKE_CURRENT_SOURCE_DIR}/data")
    add_dependencies(test_apps pliant_app failing_calls)
endif()
# Each fifth call of two quick commands fails; all of them with `./dev faults`.
if(PLIANT_BUILD_APP AND NOT PLIANT_SANITIZE)
    add_test(NAME faults COMMAND ${PROJECT_SOURCE_DIR}/tools/faults info convert --every 5
             --program $<TARGET_FILE:pliant_app> --shim $<TARGET_FILE:failing_calls>)
    set_tests_properties(faults PROPERTIES LABELS long)
endif()
# README's and the documents' command lines. With sanitizers they would take minutes; the rooms'
# tests cover the same code.
if(PLIANT_BUILD_APP AND NOT PLIANT_SANITIZE)
    pliant_test(documents SOURCES commands.cpp test_commands.cpp LIBRARIES PNG::PNG
                INPUTS $<TARGET_FILE:pliant_app> ${PROJECT_SOURCE_DIR}/README.md
                       ${PROJECT_SOURCE_DIR}/docs ${PROJECT_SOURCE_DIR}/scenes)
    target_compile_definitions(test_documents PRIVATE
        PLIANT_PROGRAM="$<TARGET_FILE:pliant_app>" PLIANT_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
    add_dependencies(test_documents pliant_app)
endif()
# Readers of untrusted input, on their corpora.
add_subdirectory(fuzz)
# And the whole program with damaged files.
if(PLIANT_BUILD_APP)
    pliant_test(mutate SOURCES child.cpp judge.cpp mutations.cpp test_judge.cpp test_mutations.cpp
                LIBRARIES nlohmann_json::nlohmann_json)
    pliant_long(mutate test_mutate)
    add_subdirectory(mutate)
endif()
# The longest begin first, so that no processor waits for one at the end.
set_tests_properties(hub PROPERTIES COST 200)
if(TARGET test_documents)
    set_tests_properties(apps documents PROPERTIES COST 100)
endif()
