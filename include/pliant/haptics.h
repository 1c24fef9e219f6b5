// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Force feedback: what is felt of a tissue between two of its solutions.
//
// A tissue is solved some 30 times a second; a hand needs a force a thousand times a second. So the
// tissue hands over a *local model*: planes around the tool, and a linear law of the force beyond
// them. The servo moves a proxy on the planes, and the law makes the force of how far the tool has
// gone beyond the proxy [Zilles1995].
//
//        free          proxy p stays on the free side of all planes;
//     ──────p──────    depth δ = p − x
//           ↑ δ        force F = f₀ + K (δ − δ₀), which never pulls, stays in the friction cone,
//           x          and is at most (largest stiffness)·|δ|, so that it begins at 0
//
// servo_step() is a function of its arguments alone: what a device felt can be computed again from
// what was recorded, bit for bit. HapticServo (haptics_servo.h) runs it on a thread of its own.
// Places are in mm, LPS; forces in N, stiffness in N/m. docs/haptics.md has the whole of it.

#pragma once

#include <pliant/result.h>
#include <pliant/vec.h>

#include <cstdint>

#pragma GCC visibility push(default)
namespace pliant {

/// The tool stays where the normal points to.
struct HapticPlane {
    Vec3d point_mm{0, 0, 0};
    Vec3d normal{0, 0, 1};  ///< unit
};

/// What a tissue says of the surroundings of a tool; immutable once it is posted.
struct HapticModel {
    static constexpr int kMaxPlanes = 8;

    std::int64_t number = 0;  ///< of the solution, ascending; 0: none yet
    int plane_count = 0;      ///< 0 and not held: nothing near
    HapticPlane planes[kMaxPlanes]{};
    /// The tool has hold of the tissue, which then pulls too; the proxy stays at the anchor.
    bool held = false;
    Vec3d anchor_mm{0, 0, 0};
    double friction = 0;      ///< Coulomb's
    Vec3d depth_mm{0, 0, 0};  ///< δ₀ of the solution
    Vec3d force_n{0, 0, 0};   ///< f₀, of the tissue on the tool, at δ₀
    Mat3d stiffness_n_m{};    ///< K, symmetric, positive semi-definite
};

/// A stiffness that a device can render: its symmetric part, with eigenvalues within 0…largest.
Mat3d capped_stiffness(const Mat3d& stiffness_n_m, double largest_n_m);

/// A model as the servo wants it: unit normals, capped stiffness.
/// @returns InvalidArgument that names the field: a number that is none, a normal without length, a
///          friction below 0, too many planes
Result<HapticModel> checked_model(HapticModel model, double largest_stiffness_n_m);

/// Of a tool that touches one surface: it is `depth` beyond it [mm], and tissue pushes it with
/// force_n. Where the law would vanish beyond the surface or before it, it is as it is.
/// @param change_n_m  of the force with the tool's place, dF/dx; as SpringReaction has it
HapticModel model_of_contact(Vec3d surface_mm, Vec3d normal, Vec3d place_mm, Vec3d force_n,
                             const Mat3d& change_n_m);
/// Of a tool that holds tissue at a place.
HapticModel model_of_grip(Vec3d place_mm, Vec3d force_n, const Mat3d& change_n_m);

/// The place on the free side of all planes that is nearest to x. Exact: no iteration.
/// @param[out] is_boxed_in  there is no such place; then it is that of the deepest plane. May be
///                          null
Vec3d nearest_free_place(const HapticModel& model, Vec3d x_mm, bool* is_boxed_in = nullptr);

/// How the time between two solutions is filled.
enum class HapticScheme {
    LinearLaw,    ///< as above
    Hold,         ///< the last force
    Extrapolate,  ///< along the last two forces [Choi2004, 3.3.1]
};

/// Scene from device: x_scene = origin + scale · rotation · x_device.
struct HapticWorkspace {
    Mat3d rotation = kIdentity3;
    double scale = 1;  ///< mm in the scene for each of the device's
    Vec3d origin_mm{0, 0, 0};
    double force_scale = 1;  ///< of what the hand feels
};

struct HapticSettings {
    HapticScheme scheme = HapticScheme::LinearLaw;
    /// Of Extrapolate, in updates: how far the last two forces are followed. The paper has no
    /// limit.
    double extrapolated_updates = 1;
    double max_force_n = 3;  ///< at the device
    double max_force_rate_n_s = 1000;
    double max_stiffness_n_m = 600;  ///< at the device
    double damping_n_s_m = 0;        ///< of the coupling between tool and proxy, in contact
    /// A contact never gives back more energy than it took: force that moves the tool along is
    /// cut where it would. Of LinearLaw. Without it tissue that moves by itself moves the hand.
    bool bounded_energy = true;
    double blend_s = 0.05;  ///< a new model is blended in over its period, at most so long
    double stale_s = 0.1;   ///< a model older than this isn't believed any more
    double ramp_s = 0.1;    ///< in which force then goes to 0, and comes back
    HapticWorkspace workspace{};
};

/// @returns InvalidArgument that names the setting
Status check_haptic_settings(const HapticSettings& settings);

/// Of one period. Times from a start that is the same for all.
struct HapticReading {
    std::int64_t time_ns = 0;
    Vec3d position_mm{0, 0, 0};  ///< in the device's frame
    bool stop = false;           ///< somebody wants no force
    std::uint32_t buttons = 0;   ///< bit 0: the first; not looked at
    double roll_rad = 0;         ///< about the device's z axis, −π…π; 0 where it isn't known
};

/// All that servo_step() remembers.
struct HapticState {
    HapticModel model{};
    std::int64_t time_ns = -1;        ///< of the last reading; −1: there was none
    std::int64_t model_time_ns = -1;  ///< when the model came
    std::int64_t update_ns = 0;       ///< between it and the one before
    Vec3d position_mm{0, 0, 0};       ///< in the scene
    Vec3d velocity_mm_s{0, 0, 0};     ///< filtered
    Vec3d proxy_mm{0, 0, 0};
    bool in_contact = false;
    Vec3d correction_n{0, 0, 0};  ///< what the newest model would have changed at once
    Vec3d earlier_force_n{0, 0, 0};
    double gain = 0;         ///< 0…1, of the safe stop
    Vec3d force_n{0, 0, 0};  ///< in the scene, as it was sent
    double energy_j = 0;     ///< that the contact took from the tool and has not given back
    double swap_step_n = 0;  ///< by which the newest model would have changed the force at once
};

enum HapticFlags : std::uint32_t {
    kHapticContact = 1,
    kHapticStale = 2,          ///< the model is too old, or somebody stopped: force goes to 0
    kHapticForceLimit = 4,     ///< cut to max_force_n
    kHapticRateLimit = 8,      ///< cut to max_force_rate_n_s
    kHapticNewModel = 16,      ///< the model came with this period
    kHapticBoxedIn = 32,       ///< the planes leave no room
    kHapticDeviceLost = 64,    ///< the device couldn't be read
    kHapticEnergyLimit = 256,  ///< cut to what the contact has taken
    kHapticLate = 128,         ///< periods were left out before this one
};

struct HapticForce {
    Vec3d force_n{0, 0, 0};   ///< at the device, in its frame
    std::uint32_t flags = 0;  ///< HapticFlags
};

/// One period of the servo. It takes no lock, allocates nothing and can't fail; nothing but the
/// arguments goes into the result.
/// @param fresh  a model that came since the last period, as checked_model() made it; or null
HapticForce servo_step(const HapticSettings& settings, const HapticModel* fresh,
                       const HapticReading& reading, HapticState& state);

}  // namespace pliant
#pragma GCC visibility pop
