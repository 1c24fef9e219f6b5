// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A catheter that a hand drives into a tissue: a capability of tissues, Tissue::drivable(). The
// library's vessel has it (make_vessel, tissues.h), and a tissue of your own may have it
// (examples/own_tissue/needle.h). The server then takes commands of clients and of devices with
// force feedback for it, and shows its wire and its wall in the page.
//
// drive() sets the motion of the hand, and the tissue follows in its sweeps. The tool that drives
// touches the tissue (Tissue::is_touched_by) until it stops, or until Tissue::release().

#pragma once

#include <pliant/core/vec.h>
#include <pliant/mesh.h>
#include <pliant/models/catheter.h>
#include <pliant/result.h>

#include <cstdint>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Display data of a catheter beside the scan.
struct CatheterView {
    std::vector<Vec3d> catheter_mm{};  ///< part inside of the vessel, from the guide to the tip
    std::vector<Vec3f> moved_mm{};     ///< displacements of the nodes of wall(); empty: at rest
    double wall_moved_mm = 0;          ///< largest displacement of the wall
    std::int64_t inverted = 0;         ///< tetrahedra of wall and catheter
};

/// Thread safety: one thread.
class Drivable {
  public:
    virtual ~Drivable() = default;

    /// Sets the motion of the hand until the next call.
    /// @param tool  drives while a speed isn't 0
    /// @returns InvalidArgument if a component isn't finite; then nothing has changed
    virtual Status drive(std::uint32_t tool, const CatheterCommand& hand) noexcept = 0;
    virtual CatheterCommand hand() const noexcept = 0;  ///< the last command; at rest after reset()
    /// Force feedback uses inserted_mm, rotated_deg, time_s and force_n. Called often: measures
    /// that need a pass over the wall are 0.
    virtual CatheterMeasures measures() const noexcept = 0;
    /// Valid until the next change.
    virtual const CatheterView& view() const noexcept = 0;
    /// Reason of a permanent stop, until a reset; empty: none.
    virtual std::string failure() const { return {}; }

    // Constant data.

    virtual double radius_mm() const noexcept = 0;
    virtual double length_mm() const noexcept = 0;
    virtual CatheterEntry entry() const noexcept = 0;
    /// Inner surface of the wall at rest; may be empty.
    virtual const TriangleMesh& wall() const noexcept = 0;
};

}  // namespace pliant
#pragma GCC visibility pop
