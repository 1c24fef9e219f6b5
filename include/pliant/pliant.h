// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// All public headers except the C interface <pliant/haptics_device.h>. Those of pliant::research,
// <pliant/research/…>, are beside them, and may change with any version.
//
//   a scan            volume.h, mesh.h; cut_mesh.h: cuts through tetrahedra
//   its deformation   deformation.h: displacements, from any model; resample.h: back to a grid
//   a tool            tool.h
//   a tissue          tissue.h: the interface; chainmail.h, springs.h, pbd.h,
//                     body_contact.h, vessel.h, catheter.h, drivable.h, organs.h
//   materials         material.h; fit.h, fit_mesh.h: springs identified against finite elements
//                     (fem.h) or measurements; network_file.h: their file
//   a view            render.h; image.h, png.h: its pictures
//   a hand            haptics.h
//   learning          gym.h
//   a scene           session.h, serve.h
//   a data set        truth.h: pairs of scans for registration
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

#include <pliant/body_contact.h>
#include <pliant/catheter.h>
#include <pliant/chainmail.h>
#include <pliant/cut_mesh.h>
#include <pliant/deformation.h>
#include <pliant/drivable.h>
#include <pliant/fem.h>
#include <pliant/files.h>
#include <pliant/fit.h>
#include <pliant/fit_mesh.h>
#include <pliant/gym.h>
#include <pliant/haptics.h>
#include <pliant/image.h>
#include <pliant/material.h>
#include <pliant/mesh.h>
#include <pliant/network_file.h>
#include <pliant/organs.h>
#include <pliant/pbd.h>
#include <pliant/png.h>
#include <pliant/record.h>
#include <pliant/relax.h>
#include <pliant/render.h>
#include <pliant/resample.h>
#include <pliant/result.h>
#include <pliant/scan_values.h>
#include <pliant/serve.h>
#include <pliant/session.h>
#include <pliant/springs.h>
#include <pliant/surface_view.h>
#include <pliant/tasks.h>
#include <pliant/tissue.h>
#include <pliant/tissues.h>
#include <pliant/tool.h>
#include <pliant/truth.h>
#include <pliant/vec.h>
#include <pliant/version.h>
#include <pliant/vessel.h>
#include <pliant/volume.h>
#include <pliant/warp.h>
