# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# The components of the library, each after those that it needs. Read by this build, and by the
# installed package.
#   NEEDS    the other components that it stands on, with theirs
#   RECIPES  third-party libraries that it links; who links the static library needs them too
#   HEADERS  third-party headers that are compiled in, and programs' libraries: for this build only

set(PLIANT_ALL_COMPONENTS core io models fit render scenes serve)

set(PLIANT_core_NEEDS)
set(PLIANT_core_RECIPES tbb)
set(PLIANT_core_HEADERS tomlplusplus)

set(PLIANT_io_NEEDS core)
set(PLIANT_io_RECIPES lz4 png pugixml zlib)
set(PLIANT_io_HEADERS gdcm)

set(PLIANT_models_NEEDS core)
set(PLIANT_models_RECIPES highway lz4)
set(PLIANT_models_HEADERS eigen)

set(PLIANT_fit_NEEDS core models)
set(PLIANT_fit_RECIPES nlopt)
set(PLIANT_fit_HEADERS eigen)

set(PLIANT_render_NEEDS core models)
set(PLIANT_render_RECIPES highway)
set(PLIANT_render_HEADERS)

set(PLIANT_scenes_NEEDS core io models render)
set(PLIANT_scenes_RECIPES)
set(PLIANT_scenes_HEADERS nlohmann_json)

set(PLIANT_serve_NEEDS core io models render scenes)
set(PLIANT_serve_RECIPES lz4 openssl)
set(PLIANT_serve_HEADERS boost nlohmann_json)

# Adds to a list of components those that they need, and puts the list in order. Other names stay
# out of it.
function(pliant_add_needs list)
    set(wanted ${${list}})
    foreach(component IN LISTS ${list})
        list(APPEND wanted ${PLIANT_${component}_NEEDS})
    endforeach()
    set(all ${PLIANT_ALL_COMPONENTS})
    foreach(component IN LISTS PLIANT_ALL_COMPONENTS)
        if(NOT component IN_LIST wanted)
            list(REMOVE_ITEM all ${component})
        endif()
    endforeach()
    set(${list} ${all} PARENT_SCOPE)
endfunction()
