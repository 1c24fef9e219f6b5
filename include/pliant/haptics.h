// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Force feedback between two solutions of a tissue.
//
// A tissue is solved some 30 times a second, but a hand needs a force a thousand times a second.
// The tissue therefore posts a *local model*: planes around the tool, and a linear law for the
// force beyond them. The servo moves a proxy on the planes. The law computes the force from the
// depth of the tool beyond the proxy [Zilles1995].
//
//        free          proxy p stays on the free side of all planes;
//     ──────p──────    depth δ = p − x
//           ↑ δ        force F = f₀ + K (δ − δ₀), which never pulls, stays in the friction cone,
//           x          and is at most (largest stiffness)·|δ|, so that it begins at 0
//
// servo_step() is a pure function: the forces at a device can be recomputed bit for bit from a
// recording. HapticServo (haptics_servo.h) runs it on a thread. Positions are in mm, LPS; forces in
// N, stiffness in N/m. docs/haptics.md has the details.

#pragma once

#include <pliant/result.h>
#include <pliant/vec.h>

#include <cstdint>

#pragma GCC visibility push(default)
namespace pliant {

/// The tool stays on the side to which the normal points.
struct HapticPlane {
    Vec3d point_mm{0, 0, 0};
    Vec3d normal{0, 0, 1};  ///< unit
};

/// Local model of a tissue around a tool. Immutable once it is posted.
struct HapticModel {
    static constexpr int kMaxPlanes = 8;

    std::int64_t number = 0;  ///< number of the solution, ascending; 0: none yet
    int plane_count = 0;      ///< 0 and not held: no tissue nearby
    HapticPlane planes[kMaxPlanes]{};
    /// The tool holds the tissue, which then also pulls. The proxy stays at the anchor.
    bool held = false;
    Vec3d anchor_mm{0, 0, 0};
    double friction = 0;      ///< Coulomb friction coefficient
    Vec3d depth_mm{0, 0, 0};  ///< δ₀ at the solution
    Vec3d force_n{0, 0, 0};   ///< f₀, force of the tissue on the tool at δ₀
    Mat3d stiffness_n_m{};    ///< K, symmetric, positive semi-definite
};

/// Projects a stiffness onto the range of a device: the symmetric part, with eigenvalues clamped to
/// 0…largest.
Mat3d capped_stiffness(const Mat3d& stiffness_n_m, double largest_n_m);

/// Prepares a model for the servo: unit normals, capped stiffness.
/// @returns InvalidArgument that names the field: a number that isn't finite, a normal without
///          length, a friction below 0, too many planes
Result<HapticModel> checked_model(HapticModel model, double largest_stiffness_n_m);

/// Model of a tool that touches one surface: it is `depth` beyond it [mm], and the tissue pushes it
/// with force_n. If the linear law vanished beyond the surface or in front of it, it is corrected
/// there.
/// @param change_n_m  derivative dF/dx of the force with the tool's position, as in SpringReaction
HapticModel model_of_contact(Vec3d surface_mm, Vec3d normal, Vec3d place_mm, Vec3d force_n,
                             const Mat3d& change_n_m);
/// Model of a tool that holds tissue at a position.
HapticModel model_of_grip(Vec3d place_mm, Vec3d force_n, const Mat3d& change_n_m);

/// Position on the free side of all planes that is nearest to x. Exact, without iteration.
/// @param[out] is_boxed_in  no such position exists, and the result is that of the deepest plane;
///                          may be null
Vec3d nearest_free_place(const HapticModel& model, Vec3d x_mm, bool* is_boxed_in = nullptr);

/// Force between two solutions.
enum class HapticScheme {
    LinearLaw,    ///< the local model
    Hold,         ///< the last force
    Extrapolate,  ///< linear extrapolation of the last two forces [Choi2004, 3.3.1]
};

/// Scene from device: x_scene = origin + scale · rotation · x_device.
struct HapticWorkspace {
    Mat3d rotation = kIdentity3;
    double scale = 1;  ///< mm in the scene per mm of the device
    Vec3d origin_mm{0, 0, 0};
    double force_scale = 1;  ///< factor of the force at the hand
};

struct HapticSettings {
    HapticScheme scheme = HapticScheme::LinearLaw;
    /// Limit of Extrapolate, in update periods. The paper has no limit.
    double extrapolated_updates = 1;
    double max_force_n = 3;  ///< at the device
    double max_force_rate_n_s = 1000;
    double max_stiffness_n_m = 600;  ///< at the device
    double damping_n_s_m = 0;        ///< of the coupling between tool and proxy, in contact
    /// Passivity of a contact: it never returns more energy than it took, and force along the
    /// tool's motion is reduced accordingly. LinearLaw only. Without it, tissue that moves by
    /// itself moves the hand.
    bool bounded_energy = true;
    double blend_s = 0.05;  ///< maximum; a new model is blended in over its period
    double stale_s = 0.1;   ///< a model older than this is ignored
    double ramp_s = 0.1;    ///< time in which force then goes to 0, and comes back
    HapticWorkspace workspace{};
};

/// @returns InvalidArgument that names the setting
Status check_haptic_settings(const HapticSettings& settings);

/// Reading of one period. Times count from a common start.
struct HapticReading {
    std::int64_t time_ns = 0;
    Vec3d position_mm{0, 0, 0};  ///< in the device's frame
    bool stop = false;           ///< the user or a client requests zero force
    std::uint32_t buttons = 0;   ///< bit 0: the first; unused by the servo
    double roll_rad = 0;         ///< about the device's z axis, −π…π; 0 if unknown
};

/// Complete state of servo_step().
struct HapticState {
    HapticModel model{};
    std::int64_t time_ns = -1;        ///< of the last reading; −1: no reading yet
    std::int64_t model_time_ns = -1;  ///< arrival of the model
    std::int64_t update_ns = 0;       ///< time between the last two models
    Vec3d position_mm{0, 0, 0};       ///< in the scene
    Vec3d velocity_mm_s{0, 0, 0};     ///< filtered
    Vec3d proxy_mm{0, 0, 0};
    bool in_contact = false;
    Vec3d correction_n{0, 0, 0};  ///< force step at the last model change, which is blended out
    Vec3d earlier_force_n{0, 0, 0};
    double gain = 0;         ///< 0…1, of the safe stop
    Vec3d force_n{0, 0, 0};  ///< in the scene, as sent
    double energy_j = 0;     ///< energy that the contact has taken from the tool minus energy
                             ///< returned
    double swap_step_n = 0;  ///< force step that the newest model would have caused without
                             ///< blending
};

enum HapticFlags : std::uint32_t {
    kHapticContact = 1,
    kHapticStale = 2,          ///< the model is too old, or a stop was requested: force goes to 0
    kHapticForceLimit = 4,     ///< reduced to max_force_n
    kHapticRateLimit = 8,      ///< reduced to max_force_rate_n_s
    kHapticNewModel = 16,      ///< a new model arrived in this period
    kHapticBoxedIn = 32,       ///< no position is free of all planes
    kHapticDeviceLost = 64,    ///< the device couldn't be read
    kHapticEnergyLimit = 256,  ///< reduced to the energy that the contact has taken
    kHapticLate = 128,         ///< periods were skipped before this one
};

struct HapticForce {
    Vec3d force_n{0, 0, 0};   ///< at the device, in its frame
    std::uint32_t flags = 0;  ///< HapticFlags
};

/// Computes one period of the servo. Takes no lock, doesn't allocate and can't fail. The result
/// depends on the arguments only.
/// @param fresh  a model from checked_model() that arrived since the last period, or null
HapticForce servo_step(const HapticSettings& settings, const HapticModel* fresh,
                       const HapticReading& reading, HapticState& state);

}  // namespace pliant
#pragma GCC visibility pop
