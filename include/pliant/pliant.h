// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// All public headers except the C interface <pliant/view/haptics_device.h>. Those of
// pliant::research, <pliant/research/…>, are beside them, and may change with any version.
//
// Beside this one stand the headers that most programs and a tissue of your own need:
//
//   a scan            volume.h, mesh.h; scan_files.h, mesh_files.h: their files
//   its deformation   deformation.h: displacements, from any model; resample.h: back to a grid
//   a tool            tool.h
//   a tissue          tissue.h: the interface; tissues.h: the library's; chainmail.h; own_tissue.h:
//                     bases of your own, check_tissue.h: its test
//   a view            render.h
//   a scene           serve.h
//   an error          result.h
//
// Shelves have the others:
//
//   core/     vectors, threads, settings as data, numbers as text, outputs that appear at once
//   models/   materials, springs, bodies, vessels, organs, finite elements, identification
//   view/     pictures, surfaces, force feedback
//   data/     kinds of scans, sessions, environments for learning, truth for registrations
//
// Each class names its thread safety:
//
//   immutable          any call, on any thread, at any time
//   concurrent reads   const calls may run at the same time; any other call runs alone
//   one thread         one call at a time, const ones included
//
// A call may use the threads of the TaskArena that it was given. Free functions may run at the same
// time, unless they change the same object.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/check_tissue.h>
#include <pliant/core/files.h>
#include <pliant/core/moving_scan.h>
#include <pliant/core/record.h>
#include <pliant/core/tasks.h>
#include <pliant/core/text.h>
#include <pliant/core/vec.h>
#include <pliant/core/version.h>
#include <pliant/data/gym.h>
#include <pliant/data/morph.h>
#include <pliant/data/scan_values.h>
#include <pliant/data/session.h>
#include <pliant/data/truth.h>
#include <pliant/data/warp.h>
#include <pliant/deformation.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>
#include <pliant/models/body_contact.h>
#include <pliant/models/catheter.h>
#include <pliant/models/cut_mesh.h>
#include <pliant/models/drivable.h>
#include <pliant/models/fem.h>
#include <pliant/models/fit.h>
#include <pliant/models/fit_mesh.h>
#include <pliant/models/material.h>
#include <pliant/models/network_file.h>
#include <pliant/models/organs.h>
#include <pliant/models/passports.h>
#include <pliant/models/pbd.h>
#include <pliant/models/relax.h>
#include <pliant/models/scene_files.h>
#include <pliant/models/springs.h>
#include <pliant/models/vessel.h>
#include <pliant/own_tissue.h>
#include <pliant/render.h>
#include <pliant/resample.h>
#include <pliant/result.h>
#include <pliant/scan_files.h>
#include <pliant/serve.h>
#include <pliant/tissue.h>
#include <pliant/tissues.h>
#include <pliant/tool.h>
#include <pliant/view/haptics.h>
#include <pliant/view/image.h>
#include <pliant/view/png.h>
#include <pliant/view/surface_view.h>
#include <pliant/volume.h>
