// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Position-based dynamics: particles and constraints between them, projected one after the other in
// small sub-steps [Mueller2007, Macklin2016, Macklin2019].
//
//   PbdParts parts = *pbd_of_mesh(mesh, {.density = 1000, .edge_compliance = 1e-5});
//   parts.inverse_masses[0] = 0;                                // held
//   auto body = PbdBody::create(std::move(parts), {.time_step = 0.005, .sub_steps = 10});
//   body->step(100, arena);
//   Vec3d place = body->position(7);
//
// Any consistent units will do. docs/pbd.md says what each constraint is, and what it costs.

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

/// How far a constraint gives way.
///   Compliance α: energy C²/2α, whatever the step and the number of iterations [Macklin2016].
///   Stiffness k: the share of C that each projection takes away, 0…1 [Mueller2007, VesselPbd2016].
enum class PbdMethod { Compliance, Stiffness };

/// C = distance of two nodes − rest length; α in length/force.
struct PbdDistance {
    std::array<std::int32_t, 2> nodes{};
    double rest_length = -1;  ///< below 0: that of the rest places
    double compliance = 0;
    double stiffness = 1;
};

/// C = angle between the triangles (0, 1, 2) and (1, 0, 3) − rest angle, 0 where they are flat; α
/// in 1/(force · length).
struct PbdBend {
    std::array<std::int32_t, 4> nodes{};  ///< the common edge, then the two other corners
    double rest_angle = std::numeric_limits<double>::quiet_NaN();  ///< NaN: of the rest places
    double compliance = 0;
    double stiffness = 1;
};

/// C = volume − rest volume [VesselPbd2016, Eq. 2]; α is volume/bulk modulus.
struct PbdVolume {
    std::array<std::int32_t, 4> nodes{};
    double rest_volume = -1;  ///< below 0: that of the rest places
    double compliance = 0;
    double stiffness = 1;
};

/// A stable neo-Hookean tetrahedron [Smith2018, Macklin2021]; needs PbdMethod::Compliance.
struct PbdSolid {
    std::array<std::int32_t, 4> nodes{};
    double young_modulus = 1e5;
    double poisson_ratio = 0.45;  ///< above 0 and below 0.5
};

/// Σ weight · place = target, for all three axes. The force on the body is attachment_force().
struct PbdAttachment {
    std::array<std::int32_t, 4> nodes{};  ///< a node with weight 0 isn't looked at
    std::array<double, 4> weights{1, 0, 0, 0};
    Vec3d target{0, 0, 0};
    double compliance = 0;
};

/// Particles stay on the side that the normal points to.
struct PbdPlane {
    Vec3d point{0, 0, 0}, normal{0, 0, 1};
    double friction = 0;  ///< Coulomb's
};

struct PbdParts {
    std::vector<Vec3d> places{};           ///< at rest
    std::vector<double> inverse_masses{};  ///< 0: held where it is put
    std::vector<PbdDistance> distances{};
    std::vector<PbdBend> bends{};
    std::vector<PbdVolume> volumes{};
    std::vector<PbdSolid> solids{};
    std::vector<PbdAttachment> attachments{};
    std::vector<PbdPlane> planes{};
};

enum class PbdNumbers {
    Float,   ///< places and constraints as 32-bit floats, in vectors
    Double,  ///< as 64-bit floats, one by one: where compliances are tiny, or to compare with
};

struct PbdSettings {
    double time_step = 1.0 / 60;
    std::int32_t sub_steps = 10;
    std::int32_t iterations = 1;  ///< of each sub-step; one is enough where sub-steps are small
    Vec3d gravity{0, 0, 0};
    double damping = 0;  ///< of velocities, in 1/time
    PbdMethod method = PbdMethod::Compliance;
    PbdNumbers numbers = PbdNumbers::Float;
    bool vectors = true;                   ///< vector instructions; the bits are the same without
    std::int32_t domain_particles = 1024;  ///< about as many stay in the first cache together
    /// Every second iteration of a sub-step goes through all constraints in the opposite order;
    /// there must be an even number of iterations. Always in the same order, many hard constraints
    /// begin to shake by themselves (docs/pbd.md).
    bool to_and_fro = false;
    /// How fast [1/time] a load that lasts stops showing in hard volumes: the share of its error by
    /// which each one's target is moved the other way. At most the damping, or they begin to
    /// shake; 0: not at all. Volumes with a compliance are left as they are.
    double volume_recovery = 0;
    /// Where much is held, pack the rest anew: faster, but in another order, on which a body that
    /// sub-steps don't solve depends.
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

    /// @returns LimitExceeded, and everything as it was before this call's last step, where a place
    ///          is no number any more, or where memory is short
    Status step(std::int32_t count, const TaskArena& arena);

    std::int32_t particle_count() const;
    Vec3d position(std::int32_t particle) const;
    Vec3d velocity(std::int32_t particle) const;
    double inverse_mass(std::int32_t particle) const;
    /// All places. @pre positions.size() == particle_count()
    void get_positions(std::span<Vec3d> positions) const;

    Status set_state(std::int32_t particle, Vec3d position, Vec3d velocity);
    /// 0 holds the particle from now on.
    Status set_inverse_mass(std::int32_t particle, double inverse_mass);
    /// Forces on particles, instead of those before, until they are changed.
    Status load(std::span<const std::int32_t> particles, std::span<const Vec3d> forces);
    Status move_attachment(std::int32_t attachment, Vec3d target);

    /// λ/h² of the last sub-step: minus the tension of a distance, minus the moment of a bend, the
    /// pressure of a volume. Where all is held around, as it was when that began.
    /// @pre a constraint of a kind other than Solid
    double multiplier(PbdKind kind, std::int32_t constraint) const;
    /// On the body.
    Vec3d attachment_force(std::int32_t attachment) const;
    /// Of all constraints but attachments on each particle, with the last sub-step's multipliers.
    std::vector<Vec3d> constraint_forces() const;

    /// Of all places: equal for every number of threads, with and without vectors.
    std::uint64_t hash() const;

  private:
    friend class PbdRollback;
    struct Impl;
    explicit PbdBody(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

/// How far tetrahedra are from their rest volume.
struct VolumeChange {
    double total = 0;    ///< of the sum, relative
    double mean = 0;     ///< of each one's size of the change, relative to its own rest volume
    double largest = 0;  ///< the same
};
/// Of the parts' volumes and solids. @pre positions.size() == parts.places.size()
VolumeChange volume_change(const PbdParts& parts, std::span<const Vec3d> positions);

/// Tissue, before it is made of a mesh.
struct PbdMaterial {
    double density = 1;
    double edge_compliance = 0;    ///< of each edge
    double volume_compliance = 0;  ///< of each tetrahedron
    double bend_compliance = 0;    ///< of each edge of the boundary
    bool edges = true, volumes = true, bends = false;
    bool solids = false;  ///< neo-Hookean tetrahedra, best without the others
    double young_modulus = 1e5, poisson_ratio = 0.45;
};
/// A particle for each node, with a quarter of its tetrahedra's mass. Edges come once each, in
/// lexical order; bends where two triangles of the boundary share an edge.
/// @returns InvalidArgument that names the mesh's cell or the material's field
Result<PbdParts> pbd_of_mesh(const TetMesh& mesh, const PbdMaterial& material);

/// Cubes of five tetrahedra, mirrored in turn so that they fit: what position-based solvers are
/// timed with. Nodes x fastest. @pre cells and side above 0
TetMesh five_tet_block(Vec3i cells, double side);

}  // namespace pliant
#pragma GCC visibility pop
