// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Position-based dynamics: particles and constraints, projected one after the other in small
// sub-steps [Mueller2007, Macklin2016, Macklin2019].
//
//   PbdParts parts = *pbd_of_mesh(mesh, {.density = 1000, .edge_compliance = 1e-5});
//   parts.inverse_masses[0] = 0;                                // held
//   auto body = PbdBody::create(std::move(parts), {.time_step = 0.005, .sub_steps = 10});
//   body->step(100, arena);
//   Vec3d place = body->position(7);
//
// Any consistent units apply. docs/pbd.md defines each constraint and its cost.

#pragma once

#include <pliant/mesh.h>
#include <pliant/result.h>
#include <pliant/tasks.h>
#include <pliant/vec.h>

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Softness of a constraint.
///   Compliance α: energy C²/2α, for every step and number of iterations [Macklin2016].
///   Stiffness k: the share of C that each projection removes, 0…1 [Mueller2007, VesselPbd2016].
enum class PbdMethod { Compliance, Stiffness };

/// C = distance of two nodes − rest length; α in length/force.
struct PbdDistance {
    std::array<std::int32_t, 2> nodes{};
    double rest_length = -1;  ///< negative: the distance at rest
    double compliance = 0;
    double stiffness = 1;
};

/// C = angle between the triangles (0, 1, 2) and (1, 0, 3) − rest angle; 0 is flat; α in 1/(force ·
/// length).
struct PbdBend {
    std::array<std::int32_t, 4> nodes{};  ///< the common edge, then the two other corners
    double rest_angle = std::numeric_limits<double>::quiet_NaN();  ///< NaN: the angle at rest
    double compliance = 0;
    double stiffness = 1;
};

/// C = volume − rest volume [VesselPbd2016, Eq. 2]; α is volume/bulk modulus.
struct PbdVolume {
    std::array<std::int32_t, 4> nodes{};
    double rest_volume = -1;  ///< negative: the volume at rest
    double compliance = 0;
    double stiffness = 1;
};

/// A stable neo-Hookean tetrahedron [Smith2018, Macklin2021]; needs PbdMethod::Compliance.
struct PbdSolid {
    std::array<std::int32_t, 4> nodes{};
    double young_modulus = 1e5;
    double poisson_ratio = 0.45;  ///< above 0 and below 0.5
};

/// Σ weight · position = target on all three axes. attachment_force() is the force on the body.
struct PbdAttachment {
    std::array<std::int32_t, 4> nodes{};  ///< a node with weight 0 is ignored
    std::array<double, 4> weights{1, 0, 0, 0};
    Vec3d target{0, 0, 0};
    double compliance = 0;
};

/// Particles stay on the side to which the normal points.
struct PbdPlane {
    Vec3d point{0, 0, 0}, normal{0, 0, 1};
    double friction = 0;  ///< Coulomb friction coefficient
};

struct PbdParts {
    std::vector<Vec3d> places{};           ///< rest positions
    std::vector<double> inverse_masses{};  ///< 0: fixed
    std::vector<PbdDistance> distances{};
    std::vector<PbdBend> bends{};
    std::vector<PbdVolume> volumes{};
    std::vector<PbdSolid> solids{};
    std::vector<PbdAttachment> attachments{};
    std::vector<PbdPlane> planes{};
};

enum class PbdNumbers {
    Float,   ///< 32-bit floats, vectorised
    Double,  ///< 64-bit floats, scalar: for tiny compliances and comparisons
};

struct PbdSettings {
    double time_step = 1.0 / 60;
    std::int32_t sub_steps = 10;
    std::int32_t iterations = 1;  ///< per sub-step; one is enough for small sub-steps
    Vec3d gravity{0, 0, 0};
    double damping = 0;  ///< of velocities, in 1/time
    PbdMethod method = PbdMethod::Compliance;
    PbdNumbers numbers = PbdNumbers::Float;
    bool vectors = true;                   ///< vector instructions; the scalar code gives the same
                                           ///< bits
    std::int32_t domain_particles = 1024;  ///< particles per domain, such that a domain fits the L1
                                           ///< cache
    /// Alternating sweeps: every second iteration of a sub-step visits all constraints in the
    /// opposite order; needs an even number of iterations. In a constant order, many hard
    /// constraints can start to oscillate (docs/pbd.md).
    bool to_and_fro = false;
    /// Rate [1/time] at which hard volumes recover under a lasting load: the share of the volume
    /// error by which the target moves the other way. At most the damping, otherwise they can
    /// oscillate; 0: none. Volumes with a compliance are unchanged.
    double volume_recovery = 0;
    /// Repacks the free constraints if many particles are held: faster, but the order changes,
    /// which affects bodies that the sub-steps don't solve completely.
    bool packs_anew = false;
};

enum class PbdKind { Distance, Bend, Volume, Solid };

class PbdBody {
  public:
    /// @returns InvalidArgument that names the part or setting
    static Result<PbdBody> create(PbdParts parts, const PbdSettings& settings);
    ~PbdBody();
    PbdBody(PbdBody&&) noexcept;
    PbdBody& operator=(PbdBody&&) noexcept;

    const PbdParts& parts() const;
    const PbdSettings& settings() const;

    /// Replaces the step settings. @returns InvalidArgument for settings that create refuses
    Status set_time_step(double time_step);

    /// @returns LimitExceeded if a position is no longer finite or memory is short; then the failed
    ///          step changes nothing
    Status step(std::int32_t count, const TaskArena& arena);

    std::int32_t particle_count() const;
    Vec3d position(std::int32_t particle) const;
    Vec3d velocity(std::int32_t particle) const;
    double inverse_mass(std::int32_t particle) const;
    /// Copies all positions. @pre positions.size() == particle_count()
    void get_positions(std::span<Vec3d> positions) const;

    Status set_state(std::int32_t particle, Vec3d position, Vec3d velocity);
    /// Changes a particle's mass. 0 fixes the particle.
    Status set_inverse_mass(std::int32_t particle, double inverse_mass);
    /// Sets the forces on particles and removes the previous ones. They last until the next call.
    Status load(std::span<const std::int32_t> particles, std::span<const Vec3d> forces);
    Status move_attachment(std::int32_t attachment, Vec3d target);

    /// λ/h² of the last sub-step: minus the tension of a distance, minus the moment of a bend, the
    /// pressure of a volume. Constraints between held particles keep their last value.
    /// @pre a constraint of a kind other than Solid
    double multiplier(PbdKind kind, std::int32_t constraint) const;
    /// Force of the attachment on the body.
    Vec3d attachment_force(std::int32_t attachment) const;
    /// Force on each particle of all constraints except attachments, from the last sub-step's
    /// multipliers.
    std::vector<Vec3d> constraint_forces() const;

    /// Hash of all positions, equal for any number of threads, with and without vector
    /// instructions.
    std::uint64_t hash() const;

  private:
    friend class PbdRollback;
    struct Impl;
    explicit PbdBody(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

/// Deviation of tetrahedra from their rest volume.
struct VolumeChange {
    double total = 0;    ///< of the sum, relative
    double mean = 0;     ///< mean of the absolute relative changes
    double largest = 0;  ///< largest absolute relative change
};
/// Volume change of the parts' volumes and solids. @pre positions.size() == parts.places.size()
VolumeChange volume_change(const PbdParts& parts, std::span<const Vec3d> positions);

/// Material for pbd_of_mesh.
struct PbdMaterial {
    double density = 1;
    double edge_compliance = 0;    ///< of each edge
    double volume_compliance = 0;  ///< of each tetrahedron
    double bend_compliance = 0;    ///< of each edge of the boundary
    bool edges = true, volumes = true, bends = false;
    bool solids = false;  ///< neo-Hookean tetrahedra, best as the only constraints
    double young_modulus = 1e5, poisson_ratio = 0.45;
};
/// Makes a particle of each node, with a quarter of its tetrahedra's mass. Each edge occurs once,
/// in lexical order. Bends join two boundary triangles with a common edge.
/// @returns InvalidArgument that names the mesh's cell or the material's field
Result<PbdParts> pbd_of_mesh(const TetMesh& mesh, const PbdMaterial& material);

/// Block of cubes with five tetrahedra each, mirrored alternately so that they conform: the usual
/// benchmark of position-based solvers. Nodes x fastest. @pre cells and side above 0
TetMesh five_tet_block(Vec3i cells, double side);

}  // namespace pliant
#pragma GCC visibility pop
