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
// recording. HapticServo (haptics.h) runs it on a thread. Positions are in mm, LPS; forces in
// N, stiffness in N/m. docs/method/haptics.md has the details.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/core/record.h>
#include <pliant/core/vec.h>
#include <pliant/models/catheter.h>
#include <pliant/models/springs.h>
#include <pliant/render.h>
#include <pliant/result.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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
HapticModel model_of_contact(Vec3d surface_mm, Vec3d normal, Vec3d position_mm, Vec3d force_n,
                             const Mat3d& change_n_m);
/// Model of a tool that holds tissue at a position.
HapticModel model_of_grip(Vec3d position_mm, Vec3d force_n, const Mat3d& change_n_m);

/// Position on the free side of all planes that is nearest to x. Exact, without iteration.
/// @param[out] is_boxed_in  no such position exists, and the result is that of the deepest plane;
///                          may be null
Vec3d nearest_free_position(const HapticModel& model, Vec3d x_mm, bool* is_boxed_in = nullptr);

/// Scene from device: x_scene = origin + scale · rotation · x_device.
struct HapticWorkspace {
    Mat3d rotation = kIdentity3;
    double scale = 1;  ///< mm in the scene per mm of the device
    Vec3d origin_mm{0, 0, 0};
    double force_scale = 1;  ///< factor of the force at the hand
};

struct HapticSettings {
    double max_force_n = 3;  ///< at the device
    double max_force_rate_n_s = 1000;
    double max_stiffness_n_m = 600;  ///< at the device
    double damping_n_s_m = 0;        ///< of the coupling between tool and proxy, in contact
    /// Passivity of a contact: it never returns more energy than it took, and force along the
    /// tool's motion is reduced accordingly. Without it, tissue that moves by itself moves the
    /// hand.
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
    double gain = 0;              ///< 0…1, of the safe stop
    Vec3d force_n{0, 0, 0};       ///< in the scene, as sent
    double energy_j = 0;          ///< energy that the contact has taken from the tool minus energy
                                  ///< returned
    double swap_step_n = 0;       ///< force step that the newest model would have caused without
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

// Local models (haptics.h) for each tissue.
//
//   ChainMail  the iso surface of the scan, stiffness from its grey values, and the slack of the
//              links, which limits how far the wall can be pushed
//   any other  forces only, for example of position-based constraints: the stiffness is estimated
//
// Call these functions on the thread that owns the tissue. Pass their models through
// checked_model().

/// Estimate of a symmetric stiffness from the last positions and forces of a tool: each new pair
/// makes the minimal change [Powell1970].
/// Thread safety: concurrent reads.
class LearntStiffness {
  public:
    explicit LearntStiffness(double start_n_m, double largest_n_m);
    /// Restarts from a known stiffness; the last position and force are kept.
    void begin_with(const Mat3d& change_n_m);
    /// Adds a pair. @param force_n  of the tissue on the tool
    void add(Vec3d position_mm, Vec3d force_n);
    /// dF/dx for model_of_contact: symmetric, negative semi-definite.
    Mat3d change_n_m() const;

  private:
    double m_largest_n_m;
    Mat3d m_stiffness_n_m;
    bool m_has_position = false;
    Vec3d m_position_mm{0, 0, 0}, m_force_n{0, 0, 0};
};

struct ChainMailFeelSettings {
    double tool_radius_mm = 1.5;
    double iso_hu = -300;
    Polarity polarity = Polarity::Rising;
    double young_modulus_pa = 7500;  ///< of tissue of 40 HU; other values scale by the law's
                                     ///< softness
    double bone_n_m = 1e5;           ///< stiffness of tissue that can't give way any more
    double friction = 0.2;
    double reach_mm = 10;  ///< surfaces and limits farther away are ignored
};

/// Rows of these settings.
SettingRows<ChainMailFeelSettings> chainmail_feel_rows() noexcept;

/// Local models for the wall of a scan that ChainMail deforms. A round tool of radius a at depth d
/// beyond the surface is pushed back by
///
///   F = k d / (1 − d/L),  k = 2 a E/(1 − ν²),
///
/// the law of a flat punch [Boussinesq1885] for d far below L. L is the distance by which the wall
/// can be pushed before links are taut down to bone, or elements are at their movement limit.
/// Thread safety: one thread.
class ChainMailFeel {
  public:
    /// Keeps references: volume and arena must outlive it. Trial pushes run on an internal
    /// ChainMail, so the displayed one isn't changed.
    /// @returns InvalidArgument that names the setting
    static Result<std::unique_ptr<ChainMailFeel>> create(const Volume& volume,
                                                         const ChainMailSettings& materials,
                                                         const ChainMailFeelSettings& settings,
                                                         const TaskArena& arena);
    /// The same for a scan that deforms. Walls are those of `shown`; L is that of the scan minus
    /// the displacement so far.
    static Result<std::unique_ptr<ChainMailFeel>> create(const Volume& scan, const Volume& shown,
                                                         const ChainMailSettings& materials,
                                                         const ChainMailFeelSettings& settings,
                                                         const TaskArena& arena);
    ~ChainMailFeel();

    /// Tells that the displayed volume has changed in these boxes of voxels only.
    void update(std::span<const Box3i> boxes);
    /// Switches to another iso surface.
    void set_wall(double iso_hu, Polarity polarity);

    /// Model around a tool. @param proxy_mm  the servo's last proxy
    HapticModel model(Vec3d tool_mm, Vec3d proxy_mm);

    /// Compliance of the surface at a position: stiffness at zero depth [N/m], and L [mm], infinite
    /// if it exceeds the reach.
    struct Give {
        double stiffness_n_m = 0;
        double limit_mm = 0;
    };
    Give give_at(Vec3d surface_mm, Vec3d normal);

  private:
    struct Impl;
    explicit ChainMailFeel(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

// A simulated force-feedback device and a simulated hand, for tests of stability without hardware.
//
// @code
//   VirtualDevice device({.damping_n_s_m = 0.5, .hand = active_hand({0, 0, 2}, 10)});
//   device.advance({0, 0, 0.5}, 1e-3);               // in each period, the force of servo_step()
//   double energy_j = device.passivity_j();          // never below 0: the hand gains no energy
// @endcode
//
// The device is one mass with viscous and Coulomb friction, isotropic. The servo sees its position
// quantised by the encoder, and holds its force for a period [Colgate1997, Abbott2005].

/// A hand that applies steady and sine forces, and is coupled to a target by a spring and a damper.
struct VirtualHand {
    double stiffness_n_m = 0, damping_n_s_m = 0;
    Vec3d target_mm{0, 0, 0};
    Vec3d steady_n{0, 0, 0};
    Vec3d sine_n{0, 0, 0};
    double frequency_hz = 0;
};
/// A relaxed grip that follows the target.
VirtualHand spring_hand(Vec3d target_mm, double stiffness_n_m = 300, double damping_n_s_m = 5);
/// A hand that applies a sinusoidal force.
VirtualHand active_hand(Vec3d amplitude_n, double frequency_hz);

struct VirtualDeviceSettings {
    double mass_kg = 0.1;
    double damping_n_s_m = 0.5;
    double coulomb_n = 0;   ///< friction independent of the speed
    double encoder_mm = 0;  ///< resolution of the position; 0: exact
    int sub_steps = 20;     ///< per period
    Vec3d position_mm{0, 0, 0};
    Vec3d velocity_mm_s{0, 0, 0};
    VirtualHand hand{};
};

/// Thread safety: one thread.
class VirtualDevice {
  public:
    explicit VirtualDevice(const VirtualDeviceSettings& settings);

    /// Advances time under a constant force of the servo.
    void advance(Vec3d force_n, double seconds);
    /// Position quantised by the encoder.
    Vec3d seen_position_mm() const;

    Vec3d position_mm() const { return m_position_mm; }
    Vec3d velocity_mm_s() const { return m_velocity_mm_s; }
    double time_s() const { return m_time_s; }
    VirtualHand& hand() { return m_settings.hand; }
    const VirtualDeviceSettings& settings() const { return m_settings; }

    // Sums since the start [J].
    double kinetic_j() const;
    double work_of_servo_j() const { return m_work_of_servo_j; }
    double work_of_hand_j() const { return m_work_of_hand_j; }
    double lost_j() const { return m_lost_j; }  ///< dissipated by the device's friction
    /// Energy that the device and the displayed tissue have taken from the hand, without the
    /// device's kinetic energy: −(work of the servo) + losses. Negative: energy was generated.
    double passivity_j() const { return m_lost_j - m_work_of_servo_j; }
    double lowest_passivity_j() const { return m_lowest_passivity_j; }

  private:
    void kick(Vec3d servo_n, double seconds);
    void rub(double seconds);
    Vec3d hand_force_n() const;

    VirtualDeviceSettings m_settings;
    Vec3d m_position_mm, m_velocity_mm_s;
    double m_time_s = 0;
    double m_work_of_servo_j = 0, m_work_of_hand_j = 0, m_lost_j = 0, m_lowest_passivity_j = 0;
};

// The servo thread, and the devices that it can run.
//
// @code
//   auto device = open_haptic_device("virtual:active");          // or "./libmaker.so"
//   auto servo = HapticServo::start(std::move(*device), {});
//   // 30 times a second:
//   (*servo)->post(*checked_model(model, (*servo)->largest_stiffness_n_m()));
//   const HapticRecord now = (*servo)->latest();  // position of the tool, and its force
// @endcode
//
// The thread takes no lock, doesn't allocate and prints nothing. Models reach it by one atomic
// exchange. It writes its records to a ring that every thread may read.

struct HapticLimits {
    double max_force_n = 3;
    double max_stiffness_n_m = 600;
    double max_damping_n_s_m = 5;
    Vec3d workspace_mm{150, 150, 150};
};

/// A kind of device and its limits.
struct HapticDeviceKind {
    std::string_view name;
    HapticLimits limits;
};
/// Known devices, with force, stiffness and damping as in CHAI3D.
std::span<const HapticDeviceKind> known_haptic_devices();

/// Thread safety: one thread at a time; read() and write() are called on the servo's.
class HapticDevice {
  public:
    virtual ~HapticDevice() = default;
    virtual std::string name() const = 0;
    virtual HapticLimits limits() const = 0;
    // Called on the servo's thread: no lock, no allocation, no waiting.
    /// @param[out] reading  position, roll and buttons, at the time of the call
    virtual bool read(HapticReading& reading) noexcept = 0;
    virtual bool write(Vec3d force_n) noexcept = 0;
};

/// Opens `virtual[:free|spring|tap|active]`, `replay:FILE`, `spacemouse[:LIBRARY]` (loads libspnav
/// now), or a plug-in: `FILE.so[:WHICH]`, a path with a / in it or a name known to the system's
/// loader.
/// @returns NotFound, Unsupported or Unreadable, with one line that names the missing part and the
///          remedy
Result<std::unique_ptr<HapticDevice>> open_haptic_device(const std::string& what);
/// Creates a simulated device that moves in real time.
std::unique_ptr<HapticDevice> make_virtual_device(const VirtualDeviceSettings& settings);

/// Record of one period. Times count from the servo's start.
struct HapticRecord {
    std::int64_t period = 0;  ///< from 0
    std::int64_t time_ns = 0;
    std::int64_t period_ns = 0;   ///< since the previous period
    std::int64_t compute_ns = 0;  ///< to read, compute and write
    std::int64_t age_ns = -1;     ///< age of the model; −1: no model
    std::int64_t model = 0;       ///< number of the model
    Vec3d position_mm{0, 0, 0};   ///< of the tool in the scene
    Vec3d proxy_mm{0, 0, 0};
    Vec3d force_n{0, 0, 0};    ///< on the tool, in the scene
    double swap_step_n = 0;    ///< as in HapticState
    double energy_j = 0;       ///< work of the device on the servo so far
    Vec3d device_mm{0, 0, 0};  ///< raw reading, for replay
    double roll_rad = 0;       ///< raw reading, for replay
    std::uint32_t flags = 0;   ///< HapticFlags
    std::uint32_t buttons = 0;
};

/// Writes one line per period for `replay:FILE`: time_ns x y z [mm] roll [rad], in the device's
/// frame.
Status write_haptic_recording(const std::filesystem::path& path,
                              std::span<const HapticRecord> records);

struct HapticServoSettings {
    HapticSettings step{};
    double rate_hz = 1000;  ///< 500…5000
    int priority = 40;      ///< real-time priority, if the system allows it; 0: none
};
SettingRows<HapticServoSettings> haptic_servo_rows() noexcept;

/// Thread safety: const calls on any thread; all others on the thread that posts the models.
class HapticServo {
  public:
    /// Starts the thread. The limits of the device and of the settings both hold.
    /// @returns InvalidArgument that names the setting
    static Result<std::unique_ptr<HapticServo>> start(std::unique_ptr<HapticDevice> device,
                                                      const HapticServoSettings& settings);
    /// Ramps the force down and stops the thread and the device.
    ~HapticServo();
    HapticServo(const HapticServo&) = delete;
    HapticServo& operator=(const HapticServo&) = delete;

    /// Posts a model, always from the same thread. @param model  from checked_model(), ascending
    /// number
    void post(const HapticModel& model);
    double largest_stiffness_n_m() const;  ///< in the scene

    /// Ramps the force to 0, and keeps it there until a call with false.
    void set_stop(bool stop);

    HapticRecord latest() const;
    /// Reads records from number `next` on, and advances `next`. @param[out] lost  incremented by
    /// the number of overwritten records
    std::size_t read(std::uint64_t& next, std::span<HapticRecord> records,
                     std::uint64_t& lost) const;

    const HapticDevice& device() const;
    /// Whether the system granted real-time priority; if not, note() is one line with the remedy.
    bool is_real_time() const;
    const std::string& note() const;

  private:
    struct Impl;
    explicit HapticServo(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

/// A loop that only keeps time: measures the jitter of the machine.
/// Thread safety: one thread.
class IdleLoop {
  public:
    explicit IdleLoop(double rate_hz, int priority = 40);
    ~IdleLoop();
    IdleLoop(const IdleLoop&) = delete;
    IdleLoop& operator=(const IdleLoop&) = delete;

    /// Returns the periods since the last call [ns].
    std::vector<std::int64_t> take();

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

// Force feedback of a catheter: the device is a rail on which the hand holds the base of the wire.
//
//     hand ●──/\/\/──■═══════ guide ═══════╗────────● tip        forward: into the vessel
//          x   k_c   s                     ╚
//
// Motion along the rail inserts the wire, rotation about the rail rotates it. A virtual coupling
// k_c joins the hand at x to the wire's base at s. The base moves to s*, where the coupling
// balances the wire's force F. F is extrapolated with the stiffness k_w of its last change:
//
//   k_c (x − s*) = F + k_w (s* − s)
//
// The hand feels F + k_w (s* − s). Between two solutions the stiffness is
//
//   k = k_c k_w/(k_c + k_w) ≤ k_c
//
// So a free wire isn't felt, and a stuck one is as stiff as the coupling. At rest the hand feels F,
// the force at the wire's base. docs/method/haptics.md, "Catheters".

struct CatheterFeelSettings {
    Vec3d forward{0, 0, -1};    ///< direction of the rail in the scene; unit
    double coupling_n_m = 300;  ///< k_c; the servo caps it at the device's limit
    double length_mm = 600;     ///< length of the wire, the limit of insertion
    double max_mm_s = 100;      ///< at higher speeds the hand feels the coupling
    double max_deg_s = 720;
    double follow_s = 1.0 / 30;  ///< simulation time in which the base goes to s*
};

/// Thread safety: one thread.
class CatheterFeel {
  public:
    /// @returns InvalidArgument that names the setting
    static Result<CatheterFeel> create(const CatheterFeelSettings& settings);

    /// Couples the hand to the wire at their current positions.
    void take_hold(Vec3d tool_mm, double roll_rad, const CatheterMeasures& now);
    void let_go() { m_holds = false; }
    bool holds() const { return m_holds; }

    struct Motion {
        double insert_mm_s = 0, rotate_deg_s = 0;
    };
    /// Speeds of the wire's base until the next call. @pre holds()
    /// @param now  current measures of the simulation
    Motion follow(Vec3d tool_mm, double roll_rad, const CatheterMeasures& now);
    /// Local model at the hand; without force if it holds no wire.
    HapticModel model(Vec3d tool_mm, const CatheterMeasures& now) const;

    /// Distance of the hand ahead of the wire's base.
    double ahead_mm(Vec3d tool_mm, const CatheterMeasures& now) const;
    /// Estimated stiffness k_w of the wire.
    double wire_n_m() const { return 1000 * m_wire_n_mm; }

  private:
    /// Response to the distance between the hand and the wire's base.
    struct Pull {
        double way_mm = 0;  ///< motion of the base to s*
        double felt_n = 0, stiffness_n_mm = 0;
    };
    explicit CatheterFeel(const CatheterFeelSettings& settings) : m_settings(settings) {}
    Pull pull(Vec3d tool_mm, const CatheterMeasures& now) const;
    void learn(const CatheterMeasures& now);

    CatheterFeelSettings m_settings;
    bool m_holds = false, m_moves = false;    ///< the hand holds the wire; the base is moving
    Vec3d m_first_mm{0, 0, 0};                ///< position of the hand at the start of the hold
    double m_start_mm = 0, m_start_deg = 0;   ///< of the wire at the start of the hold
    double m_roll_deg = 0, m_turned_deg = 0;  ///< of the hand: last reading; sum since the start
    double m_time_s = 0, m_span_s = 0;        ///< time of the last follow(), and its period
    double m_wire_n_mm = 0;                   ///< k_w
    double m_known_mm = 0, m_known_n = 0;     ///< F at an earlier s
};

}  // namespace pliant
#pragma GCC visibility pop
