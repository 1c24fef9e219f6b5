// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Position-based dynamics: particles and constraints, projected one after the other in small
// sub-steps [Mueller2007, Macklin2016, Macklin2019].
//
// @code
//   PbdParts parts = *pbd_of_mesh(mesh, {.density = 1000, .edge_compliance = 1e-5});
//   parts.inverse_masses[0] = 0;                                // held
//   auto body = PbdBody::create(std::move(parts), {.time_step = 0.005, .sub_steps = 10});
//   body->step(100, arena);
//   Vec3d position = body->position(7);
// @endcode
//
// Any consistent units apply. docs/method/pbd.md defines each constraint and its cost.

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/tasks.h>
#include <pliant/core/vec.h>
#include <pliant/mesh.h>
#include <pliant/result.h>

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

/// A tetrahedron of the stable neo-Hookean law [Smith2018, Macklin2021], or of the one-term law of
/// [Ogden1972], which a negative exponent makes stiffer in compression than in tension. Moduli are
/// those at rest. Needs PbdMethod::Compliance.
struct PbdSolid {
    std::array<std::int32_t, 4> nodes{};
    double young_modulus = 1e5;
    double poisson_ratio = 0.45;  ///< above 0 and below 0.5
    /// Exponent of the stretches, 2 to 40 or −40 to −1; a negative one is below −(1 − 2ν)/ν.
    /// 2 is the neo-Hookean law, several times as fast as any other exponent.
    double ogden_alpha = 2;
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
    std::vector<Vec3d> positions{};        ///< rest positions
    std::vector<double> inverse_masses{};  ///< 0: fixed
    std::vector<PbdDistance> distances{};
    std::vector<PbdBend> bends{};
    std::vector<PbdVolume> volumes{};
    std::vector<PbdSolid> solids{};
    std::vector<PbdAttachment> attachments{};
    std::vector<PbdPlane> planes{};
};

enum class PbdPrecision {
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
    PbdPrecision precision = PbdPrecision::Float;
    bool vectors = true;                   ///< vector instructions; the scalar code gives the same
                                           ///< bits
    std::int32_t domain_particles = 1024;  ///< particles per domain, such that a domain fits the L1
                                           ///< cache
    /// Alternating sweeps: every second iteration of a sub-step visits all constraints in the
    /// opposite order; needs an even number of iterations. In a constant order, many hard
    /// constraints can start to oscillate (docs/method/pbd.md).
    bool alternates = false;
    /// Rate [1/time] at which hard volumes recover under a lasting load: the share of the volume
    /// error by which the target moves the other way. At most the damping, otherwise they can
    /// oscillate; 0: none. Volumes with a compliance are unchanged.
    double volume_recovery = 0;
    /// Repacks the free constraints if many particles are held: faster, but the order changes,
    /// which affects bodies that the sub-steps don't solve completely.
    bool repacks = false;
    /// Sub-steps begin with the forces of the solids in the last one, instead of none. Then forces
    /// at rest are those of the law, whatever the number of sub-steps, if a wave crosses no more
    /// than about an edge in each; see wave_sub_steps(). The forces are a state beside positions
    /// and velocities; recall_forces() sets them to those of the present shape.
    bool warm_starts = false;
};

/// Number of sub-steps that warm_starts needs, for forces within 5 % of the law's at rest: a
/// pressure wave crosses about an edge of the median solid in each. @param duration  of all of them
double wave_sub_steps(const PbdParts& parts, double duration);

/// Rows of the settings; their numbers are in any consistent set of units.
SettingRows<PbdSettings> pbd_rows() noexcept;

enum class PbdKind { Distance, Bend, Volume, Solid };

/// Thread safety: concurrent reads.
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
    /// Begins the next step with the forces of the present shape; see PbdSettings::warm_starts. A
    /// new body does so by itself, and one whose particles have become held or free.
    /// @param trials  first sub-steps that are made for their forces, without moving a particle.
    ///                With them, the forces are those of the last sub-step if contact that is not
    ///                in the body's solution holds it at rest
    void recall_forces(std::int32_t trials = 0) noexcept;

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
/// Volume change of the parts' volumes and solids. @pre positions.size() == parts.positions.size()
VolumeChange volume_change(const PbdParts& parts, std::span<const Vec3d> positions);

/// Material for pbd_of_mesh.
struct PbdMaterial {
    double density = 1;
    double edge_compliance = 0;    ///< of each edge
    double volume_compliance = 0;  ///< of each tetrahedron
    double bend_compliance = 0;    ///< of each edge of the boundary
    bool edges = true, volumes = true, bends = false;
    bool solids = false;  ///< hyperelastic tetrahedra, best as the only constraints
    double young_modulus = 1e5, poisson_ratio = 0.45;
    double ogden_alpha = 2;  ///< of PbdSolid; 2: neo-Hookean
};
/// Makes a particle of each node, with a quarter of its tetrahedra's mass. Each edge occurs once,
/// in lexical order. Bends join two boundary triangles with a common edge.
/// @returns InvalidArgument that names the mesh's cell or the material's field
Result<PbdParts> pbd_of_mesh(const TetMesh& mesh, const PbdMaterial& material);

/// Block of cubes with five tetrahedra each, mirrored alternately so that they conform: the usual
/// benchmark of position-based solvers. Nodes x fastest. @pre cells and side above 0
TetMesh five_tet_block(Vec3i cells, double side);

/// A rotation, w + xi + yj + zk of length 1.
struct Rotation {
    double w = 1, x = 0, y = 0, z = 0;
};
/// Rotation about a vector by its length.
Rotation rotation_by(Vec3d vector);
/// Product: first b, then a.
constexpr Rotation operator*(Rotation a, Rotation b) {
    return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
            a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
constexpr Vec3d rotated(Rotation q, Vec3d v) {
    const Vec3d u{q.x, q.y, q.z};
    const Vec3d t = 2.0 * cross(u, v);
    return v + q.w * t + cross(u, t);
}
/// Inverse of rotation_by, of length 0…π.
Vec3d rotation_vector(Rotation rotation);

// Local simulation near the catheter: the boxes of [VesselPbd2016, Eq. 9-13].
//
//   ┌────┬────┬────┬────┐   space in boxes of side d; each holds the tetrahedra in it and within
//   │    │ ▒▒▒│▒▒▒ │    │   d/3 around it. Boxes near the catheter are active (▒), and so are
//   └────┴────┴────┴────┘   their tetrahedra. The particles of other tetrahedra are held
//
// @code
//   auto boxes = PbdBoxes::create(wall.mesh, {.side = 10});
//   boxes->update(rod_positions, 2, body);      // before each step
// @endcode
//
// Deviations from the paper: the whole catheter activates boxes, not only its tip. Particles become
// movable gradually, and an inactive box stays awake until it has come to rest, so that motion is
// continuous. Boxes have the index of Eq. 10: the paper's hash, Eq. 12, isn't unique.

struct PbdBoxSettings {
    double side = 10;               ///< d
    double span = -1;               ///< margin of a box on each side; negative: d/3
    std::int32_t blend_steps = 16;  ///< steps from held to movable
    double settled = 1e-3;          ///< a box rests if all its particles are within this distance
                                    ///< of their rest positions
};
SettingRows<PbdBoxSettings> pbd_box_rows() noexcept;

/// Thread safety: concurrent reads.
class PbdBoxes {
  public:
    /// @returns InvalidArgument that names the setting, LimitExceeded for more than 2²⁴ boxes
    static Result<PbdBoxes> create(const TetMesh& mesh, const PbdBoxSettings& settings);

    /// Wakes the boxes within reach of the positions, and lets others fall asleep. The body
    /// consists of the mesh's nodes; all are held before the first call.
    Status update(std::span<const Vec3d> positions, double reach, PbdBody& body);

    /// Returns the active boxes and the particles in transition to movable.
    std::vector<std::int32_t> state() const;
    /// @returns InvalidArgument if it is not a state of these boxes
    Status restore(std::span<const std::int32_t> state, PbdBody& body);

    Vec3i box_counts() const { return m_counts; }  ///< Eq. 9
    Vec3i box_at(Vec3d position) const;            ///< clamped to the nearest box
    std::int32_t linear_index(Vec3i box) const;    ///< Eq. 10
    std::span<const std::int32_t> tetrahedra(std::int32_t linear_index) const;
    bool is_active(std::int32_t linear_index) const;
    std::int32_t active_boxes() const { return m_active_boxes; }
    std::int32_t active_tetrahedra() const { return m_active_tetrahedra; }

  private:
    friend class PbdRollback;
    struct Blend {
        std::int32_t particle, age;
    };
    PbdBoxes() = default;
    void mark_around(std::span<const Vec3d> positions, double reach);
    Status wake(std::size_t box, bool active, PbdBody& body);
    Status blend_in(PbdBody& body);
    void keep() noexcept;
    void take_back() noexcept;
    Status check_state(std::span<const std::int32_t> boxes,
                       std::span<const std::int32_t> blends) const;
    bool is_settled(std::size_t box, const PbdBody& body) const;

    PbdBoxSettings m_settings;
    Vec3d m_low{0, 0, 0};
    Vec3i m_counts{1, 1, 1};
    std::vector<Vec3d> m_rest;
    std::vector<std::array<std::int32_t, 4>> m_cells;
    std::vector<std::int32_t> m_starts, m_held;  ///< tetrahedra of each box
    std::vector<std::uint8_t> m_is_active, m_is_wanted;
    std::vector<std::int32_t> m_active_of;  ///< [tetrahedron]: number of its active boxes
    std::vector<std::int32_t> m_asleep;     ///< [particle]: number of its inactive tetrahedra
    std::vector<Blend> m_blends;
    std::int32_t m_active_boxes = 0, m_active_tetrahedra = 0;
    bool m_has_begun = false;

    // Rollback of an update: changed boxes, the first m_changed_count of which are processed.
    std::vector<std::int32_t> m_changed;
    std::size_t m_changed_count = 0;
    std::vector<Blend> m_kept_blends;
    bool m_kept_begun = false;
};

}  // namespace pliant
#pragma GCC visibility pop
