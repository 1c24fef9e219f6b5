# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# The plan of the house, which this build, the installed package and tools/check_layers read, and
# from which the lists in README.md and HACKING.md are made (tools/check_layers --write).
#
# A wing is a folder of src/ and a component of the library, pliant::WING; wings stand in the order
# in which data flows. A room is a folder of its wing.

set(PLIANT_WINGS core io models view scenes serve)
# research/ at the root of the sources: PLIANT_RESEARCH=ON. No other wing needs it, and
# pliant::pliant is without it.
set(PLIANT_OPTIONAL_WINGS research)

#   NEEDS    the wings that it stands on, with theirs
#   RECIPES  third-party libraries that it links; who links the static library needs them too
#   HEADERS  third-party headers that are compiled in, and programs' libraries: for this build only
set(PLIANT_core_NEEDS)
set(PLIANT_core_RECIPES tbb)
set(PLIANT_core_HEADERS tomlplusplus)

set(PLIANT_io_NEEDS core)
set(PLIANT_io_RECIPES lz4 png pugixml zlib)
set(PLIANT_io_HEADERS gdcm)

set(PLIANT_models_NEEDS core)
set(PLIANT_models_RECIPES highway lz4)
set(PLIANT_models_HEADERS eigen)

set(PLIANT_view_NEEDS core models)
set(PLIANT_view_RECIPES highway)
set(PLIANT_view_HEADERS)

set(PLIANT_scenes_NEEDS core io models view)
set(PLIANT_scenes_RECIPES)
set(PLIANT_scenes_HEADERS nlohmann_json)

set(PLIANT_serve_NEEDS core io models view scenes)
set(PLIANT_serve_RECIPES lz4 openssl)
set(PLIANT_serve_HEADERS boost nlohmann_json)

set(PLIANT_research_NEEDS core models)
set(PLIANT_research_RECIPES)
set(PLIANT_research_HEADERS eigen)

# Contents of each wing, and of each room after its floor. A room includes itself and rooms on lower
# floors, of its own wing and of those that this one needs.
set(PLIANT_HOUSE
    "core              results, threads, settings; grids, voxels, phantoms; meshes"
    "  0 base          results, threads, hashing, small matrices, outputs that appear at once"
    "  1 volume        scans: grid and world, voxels in memory, phantoms"
    "  1 mesh          tetrahedra, triangles: lattice mesher, cuts, distances"
    "io                files: scans, meshes, pictures; the decoder of compressed DICOM"
    "  2 formats       scans from files: DICOM, NRRD, MetaImage, NIfTI, VTI, VTK"
    "  2 meshes        meshes from and into files: gmsh, OBJ, PLY, STL, VTK, VTP, VTU"
    "  2 pictures      PNG"
    "  3 decoder       the program that decodes compressed DICOM pixels; no part of the library"
    "  3 writers       scans and fields into files: NRRD, MetaImage, NIfTI, VTI"
    "models            tissues: ChainMail, springs, bodies, finite elements, vessels; resampling"
    "  2 field         displacements, cuts and voids in sparse bricks, whichever model writes"
    "  2 fem           linear elastic reference: elements, Cholesky, matrix-free lattices"
    "  2 springs       mass-spring networks, force transmittal and its baselines"
    "  2 pbd           position-based constraints in domains and packs; contact"
    "  2 vessel        vessel walls: from centrelines, surfaces, scans"
    "  3 material      ChainMail's limits: laws, air, labels; passports of measured tissues"
    "  3 resample      a deformation back to a grid, at once or live; fields"
    "  4 elastic       the elastic scan: cells of voxels, nested lattices, multigrid"
    "  4 lattice       ChainMail's elements: a field with materials; elements at a tool"
    "  4 warp          one map for images, labels and points, there and back"
    "  5 morph         an organ's motion between two phases, from its shapes and known points"
    "  5 propagate     the minimal move: heap, sweeps, a drag's fields, the permitted step"
    "  5 relax         the elastic return of pushed tissue, and imprints"
    "  5 catheter      a wire fed into a vessel; the scan that its wall carries"
    "  6 chainmail     the model: push, slide, cut, carve, history, state files"
    "  7 tissue        the interface of all tissues; all models of tissue behind it"
    "  7 truth         pairs of scans with a known deformation; scores of registrations"
    "  8 fit           stiffness of springs from a reference: annealing, Gauss-Newton"
    "view              pictures: ray casting, sections, paths; force feedback; learning"
    "  4 render        first-hit ray casting, blending, sections"
    "  5 path          ways through a lumen"
    "  8 haptics       force feedback: local models, the servo and its devices"
    "  8 gym           endoscopes and catheters for learning: many in one scan, scene flow"
    "scenes            scenes of files: organs, vessels with catheters, identified networks"
    "  8 organs        scenes of bodies: their meshes, what holds them, the scan that they carry"
    "  8 scene_files   vessels with catheters and networks of springs from files and phantoms"
    "serve             the page's server, and the page"
    "  8 protocol      commands and messages as values, as JSON and as frames"
    "  9 session       the scene of a server, its steps, recording, checkpoints, replay"
    "  10 hub          one scene, several clients: the hub, and feeds beside the voxels"
    "  11 network      HTTP, WebSocket, TLS, links, uploads and downloads; the server"
    "research          published methods, to compare with; results/: papers' figures"
    "  8 chains        published orderings, ChainMail on graphs and between objects"
    "  8 rods          rods solved directly, a catheter of tetrahedra, contact with a vessel"
    "  8 networks      springs by projective dynamics, with new positions; touched triangles"
    "  8 ranks         finite elements shared by processes, each with a slab of the lattice")

# Public headers by room, where they don't have the same name.
set(PLIANT_PUBLIC_HEADERS
    "base      files image output_file record result tasks text tool vec version"
    "mesh      cut_mesh"
    "volume    scan_values"
    "field     deformation moving_scan"
    "elastic   elastic_scan"
    "springs   network_file"
    "material  passports"
    "pbd       body_contact"
    "formats   scan_files"
    "meshes    mesh_files"
    "pictures  png"
    "tissue    check_tissue drivable mesh_tissue own_tissue scan_tissue tissues"
    "fit       fit_mesh"
    "render    surface_view"
    "haptics   haptics_device"
    "network   serve pliant"
    "chains    research/graph research/objects research/orderings"
    "ranks     research/ranks"
    "rods      research/overlap research/rod research/tet_catheter"
    "networks  research/spring_probe research/springs")

# Adds to a list of wings those that they need, and puts the list in order. Other names stay out.
function(pliant_add_needs list)
    set(wanted ${${list}})
    foreach(wing IN LISTS ${list})
        list(APPEND wanted ${PLIANT_${wing}_NEEDS})
    endforeach()
    set(all ${PLIANT_WINGS} ${PLIANT_OPTIONAL_WINGS})
    foreach(wing IN LISTS all)
        if(NOT wing IN_LIST wanted)
            list(REMOVE_ITEM all ${wing})
        endif()
    endforeach()
    set(${list} ${all} PARENT_SCOPE)
endfunction()
