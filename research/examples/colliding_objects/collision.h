// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A free ring, tissue with a bay, and a wall in one space [Gibson1996, 3.5]: the ring is pulled
// into the bay, squeezed there, touched by the tissue, and pulled back to the wall. Lattices of one
// layer, 1 mm between elements, so that a picture shows every element.
//
//      wall │                      +------------+
//           │     .---.            '--.         ‖
//           │    ( ring )  → push      )  bay   ‖ fixed
//           │     '---'            .--'         ‖
//           │                      +------------+

#pragma once

#include <pliant/render.h>
#include <pliant/research/objects.h>

#include <string>
#include <vector>

namespace collision {

inline constexpr int kRing = 0, kTissue = 1;  ///< numbers of the objects
inline constexpr double kWall_mm = -2;        ///< x of the wall

struct Element {
    pliant::Vec3i ijk;
    double x_mm, y_mm;  ///< centre of its box of 1 mm × 1 mm
    bool fixed;
};

/// The space after one push.
struct Frame {
    std::string title;
    std::vector<std::vector<Element>> objects;  ///< solid elements of each object
    // Of the push that led here; the first frame has none.
    int pushed = -1;                     ///< number of the object, or −1
    std::vector<pliant::Vec3i> grabbed;  ///< elements that the tool holds
    pliant::Vec3d start_mm{0, 0, 0};     ///< mean position of the grabbed elements before the push
    pliant::Vec3d push_mm{0, 0, 0};      ///< requested motion
    pliant::ObjectPushReport report;
};

/// Runs all pushes. @returns one frame for the start and one for each push
pliant::Result<std::vector<Frame>> play(const pliant::TaskArena& arena);

/// Verifies the frames: each push ends where a box meets a box or the wall, no two boxes overlap,
/// and an object moves only if it is pushed.
/// @returns the first contradiction; empty if there is none
std::string find_fault(const std::vector<Frame>& frames);

/// All frames with axes [mm] and a legend.
pliant::Image picture_of(const std::vector<Frame>& frames);

}  // namespace collision
