// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// State of a body, and its sub-steps [Macklin2019]:
//
//   v ← v · (1 − damping h) + h g,  x ← x + h v;   constraints move x;   v ← v + (x − x′)/h
//
// where x′ is the position before the constraints. The usual v ← (x − x_old)/h loses h² g if it is
// below the last bit of a 32-bit position, as in small steps; here gravity only enters v.

#pragma once

#include "base/aligned_array.h"
#include "pbd/project.h"

#include <array>
#include <memory>

namespace pliant::pbd {

/// All particles and constraints are numbered as by the caller.
class Solver {
  public:
    virtual ~Solver() = default;
    virtual Status step(const TaskArena& arena) = 0;
    virtual Vec3d position(std::int32_t particle) const = 0;
    virtual Vec3d velocity(std::int32_t particle) const = 0;
    virtual double inverse_mass(std::int32_t particle) const = 0;
    virtual void set_state(std::int32_t particle, Vec3d position, Vec3d velocity) = 0;
    virtual void set_inverse_mass(std::int32_t particle, double inverse_mass) = 0;
    virtual void load(std::span<const std::int32_t> particles, std::span<const Vec3d> forces) = 0;
    /// Returns λ/h². @param part  below kMultipliers[kind]
    virtual double multiplier(int kind, std::int32_t constraint, int part) const = 0;
    /// Returns the forces on the last three corners. @pre warm starts
    virtual std::array<Vec3d, 3> solid_forces(std::int32_t solid) const = 0;
    virtual Vec3d attachment_force(std::int32_t attachment) const = 0;
    virtual std::uint64_t hash() const = 0;

    /// Allocates the memory for keep().
    virtual void reserve_kept() = 0;
    /// Saves positions, velocities and inverse masses. @pre reserve_kept() was called
    virtual void keep() noexcept = 0;
    /// Restores the state of keep(); multipliers stay those of the last sub-step.
    /// @pre keep() was called, and take_back() not since then
    virtual void take_back() noexcept = 0;
    /// Sets the positions and velocities of all particles.
    virtual void put_all(std::span<const Vec3d> positions,
                         std::span<const Vec3d> velocities) noexcept = 0;
    virtual void recall_forces(std::int32_t trials) noexcept = 0;
};

/// Parts, settings and plan outlive the solver.
std::unique_ptr<Solver> make_solver(const PbdParts& parts, const PbdSettings& settings,
                                    const Plan& plan);

/// Rest data of a tetrahedron's projection.
struct SolidNumbers {
    double inverse[9];  ///< row-major
    double h_compliance, e_compliance;
    double ogden_alpha;  ///< 0: neo-Hookean
};
SolidNumbers solid_numbers(const PbdParts& parts, const PbdSolid& solid);
template <class V>
struct WarmSolid;
/// The same with 1/α instead of 1/α̃.
WarmSolid<double> warm_solid(const SolidNumbers& numbers);

double rest_length(const PbdParts& parts, const PbdDistance& distance);
double rest_angle(const PbdParts& parts, const PbdBend& bend);
double rest_volume(const PbdParts& parts, const PbdVolume& volume);
/// Volume at the given positions; negative: inverted.
double tetrahedron_volume(const std::array<std::int32_t, 4>& nodes,
                          std::span<const Vec3d> positions);

/// @returns InvalidArgument that names the part and its number
Status check_parts(const PbdParts& parts, PbdMethod method);
Status check_settings(const PbdSettings& settings);
/// Checks the state of one particle.
Status check_state(Vec3d position, Vec3d velocity);
Status check_inverse_mass(const char* what, std::size_t particle, double inverse_mass);

}  // namespace pliant::pbd
