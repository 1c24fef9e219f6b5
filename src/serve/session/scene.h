// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The scene of a server: a scan, its lattice, the deformed volume, and the history.
//
// The scene has no clock: its state depends only on the commands, the number of relaxation sweeps
// and of the parts of unfinished ones. So a recorded session replays to the same bits on any
// machine and with any number of threads. The scene is not thread-safe; its owner calls it from one
// thread.
//
// Undo covers steps of the lattice, which the lattice reverts, and changes of the threshold, which
// are stored here. A step ends when another begins, so the pushes of one stroke form one step, and
// so does relaxation from start to end. Strokes of several clients that alternate form one step of
// all of them, and tissue that one client holds is not to be moved by the others.

#pragma once

#include <pliant/resample.h>

#include <cstdint>
#include <filesystem>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <pliant/tissue.h>
#include "protocol/commands.h"
#include "protocol/messages.h"
#include "session/first_model.h"
#include "session/scene_memo.h"
#include "session/source.h"

namespace pliant::serve {

class Scene {
  public:
    static Result<std::unique_ptr<Scene>> open(const SceneSource& source, const TaskArena& arena) {
        return open(source, arena, arena);
    }
    /// @param loading  arena for the construction, if the scene's arena may be in use
    /// @param give_up  polled while the scan is read; may be empty
    static Result<std::unique_ptr<Scene>> open(const SceneSource& source, const TaskArena& arena,
                                               const TaskArena& loading,
                                               const std::function<bool()>& give_up = {}) noexcept;
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;

    /// @param client  sender of the command; strokes, grabs and tools belong to clients
    /// @pre is_command(action)
    /// Throws std::bad_alloc if memory runs out; then the only effect is that of interrupt().
    Outcome carry_out(std::uint32_t client, const Action& action);
    /// Ends the open step and releases held tissue.
    /// @param client  whose command ran out of memory
    void interrupt(std::uint32_t client) noexcept;
    /// Whether sweep() has work to do.
    bool wants_sweep() const { return m_relaxing && !m_settled; }
    /// Simulated time per sweep [ms]; 0 if the model has no time.
    double sweep_time_ms() const { return tissue().traits().sweep_ms; }

    /// Makes a sweep of relaxation, or a part of one. @returns LimitExceeded if memory runs out,
    /// then nothing has changed
    Result<Sweep> sweep(const SweepLimit& limit = {}) noexcept;
    /// Whether the client holds tissue, or has a tool that obstructs relaxation.
    bool has_contact(std::uint32_t client) const;
    bool has_eye(std::uint32_t client) const { return tissue().has_eye(client); }
    /// Whether tissue that returns to rest may close over a sphere: the scan at rest shows tissue
    /// in it, or there are imprints.
    bool may_close_over(Vec3d position_mm, double radius_mm) const;
    /// Whether automatic relaxation is on, even if the tissue has settled.
    bool is_relaxing() const { return m_relaxing; }
    /// Highest client number so far.
    std::uint32_t last_client() const { return m_last_client; }

    /// Whether the scene can rest: no tissue is held, and none relaxes.
    bool is_quiet() const { return m_holder == 0 && !tissue().is_touched() && !wants_sweep(); }
    /// Ends open activities: the next stroke is a step of its own. @pre is_quiet()
    /// @returns the scene's state except tissue()
    Result<SceneMemo> rest() noexcept;
    /// Restores the state at a call of rest(), in a new scene. The history is empty then.
    /// @param state  saved at that time by tissue().save_state()
    Status restore(const std::filesystem::path& state, const SceneMemo& memo);
    /// Replaces the present tissue by one in a saved state. The history is empty then, tissue is
    /// released, and nothing relaxes until a command moves it. On failure nothing changes.
    Status load_state(const std::filesystem::path& state) noexcept;
    /// Drops the oldest steps of undo and redo. @param count  see SceneMemo::steps
    void forget_steps(std::int64_t count);
    /// Drops all steps of undo. @param made  see SceneMemo::steps
    void lose_steps(std::int64_t made) noexcept;
    /// Whether steps were lost since the last call: a step was too large for the history, or memory
    /// was lacking.
    bool take_lost() noexcept { return std::exchange(m_lost, false); }
    /// Number of steps made so far.
    std::int64_t steps() const { return m_steps; }

    /// Returns the energy of a tool's last command if it is known and unreported. Takes a while for
    /// large deformations: call it while no picture is due.
    std::optional<FeltEnergy> measure_force();

    /// Updates the deformed volume; see LiveDeformation.
    Result<LiveUpdate> update() { return m_live->update(); }
    Result<LiveUpdate> approach(std::int64_t max_elements) {
        return m_live->approach(max_elements);
    }
    const Volume& deformed() const { return m_live->volume(); }
    /// Keeps sources for overlays; see LiveDeformation.
    bool keep_sources(bool keep) { return m_live->keep_sources(keep); }
    const LiveDeformation& live() const { return *m_live; }
    const Tissue& tissue() const { return *m_tissue; }
    Tissue& tissue() { return *m_tissue; }
    const TissueChoice& choice() const { return m_choice; }
    /// Model that a session records in the scene's source, so that it opens with the same tissue,
    /// and the reason if it was chosen.
    const FirstModel& first_model() const { return m_first_model; }
    const VolumeInfo& info() const { return m_loaded->info; }
    void set_volume_id(std::uint32_t id) { m_loaded->info.id = id; }
    /// The scan, for uses that outlive the scene.
    std::shared_ptr<const LoadedScan> loaded() const { return m_loaded; }
    std::uint64_t scan_hash() const { return m_loaded->hash; }
    /// Fills in all fields except step, clients and timing.
    void describe(SharedState& state) const;

  private:
    enum class StepKind { Tissue, Iso };
    /// Actions of one client from pressing a tool to lifting it.
    struct Stroke {
        std::string name{};
        std::uint32_t client = 0;  ///< 0: no client
        std::uint32_t number = 0;  ///< 0: doesn't go on
        friend bool operator==(const Stroke&, const Stroke&) = default;
    };
    struct Step {
        StepKind kind = StepKind::Tissue;
        double iso_hu = 0;  ///< the other value: old if done, new if undone
        Polarity polarity = Polarity::Rising;
        std::vector<Stroke> strokes{};
        int tissue_steps = 1;     ///< of the tissue's history, for Tissue
        std::int64_t number = 0;  ///< 1 for the scene's first step

        const std::string& name() const { return strokes.front().name; }
    };
    /// The current step, which collects all changes of the tissue.
    struct OpenStep {
        std::vector<Stroke> strokes;
        int undo_steps_before = 0;
        int joined = 0;  ///< latest steps of m_done that it goes on

        const std::string& name() const { return strokes.front().name; }
    };

    Scene(FirstModel first_model, std::shared_ptr<LoadedScan> loaded, const TissueChoice& choice,
          std::unique_ptr<Tissue> tissue);

    static Result<std::unique_ptr<Scene>> load(const SceneSource& source, const TaskArena& arena,
                                               const TaskArena& loading,
                                               const std::function<bool()>& give_up);
    /// Switches the scan's tissue model. Nothing changes on failure.
    /// @param state  file of its state; empty: at rest
    Status choose(const TissueChoice& choice, const std::filesystem::path& state = {});

    Outcome act(std::uint32_t client, const PushCommand& command);
    Outcome act(std::uint32_t client, const GrabCommand& command);
    Outcome act(std::uint32_t client, const DragCommand& command);
    Outcome act(std::uint32_t client, const LetGoCommand& command);
    Outcome act(std::uint32_t client, const CutCommand& command);
    Outcome act(std::uint32_t client, const CarveCommand& command);
    Outcome act(std::uint32_t client, const RelaxCommand& command);
    Outcome act(std::uint32_t client, const ReleaseCommand& command);
    Outcome act(std::uint32_t client, const EyeCommand& command);
    Outcome act(std::uint32_t client, const ResetCommand& command);
    Outcome act(std::uint32_t client, const MaterialsCommand& command);
    Outcome act(std::uint32_t client, const IsoCommand& command);
    Outcome act(std::uint32_t client, const UndoCommand& command);
    Outcome act(std::uint32_t client, const RedoCommand& command);
    Outcome act(std::uint32_t client, const TissueCommand& command);
    Outcome act(std::uint32_t client, const DepthCommand& command);
    Outcome act(std::uint32_t client, const DriveCommand& command);
    template <class T>
    Outcome act(std::uint32_t, const T&) {
        return {.error_code = "out_of_range", .message = "expected a command"};
    }

    /// Setting that every tissue with ChainMail's materials has.
    static constexpr std::string_view kMaterial = "offset";
    /// Whether a setting of the tissue can be changed during use.
    bool has_setting(std::string_view name) const;

    void reserve_step();
    /// Begins a step unless the present one goes on. @returns whether it did begin one
    bool begin_step(const std::string& name, std::uint32_t client, std::uint32_t stroke);
    bool goes_on(const Stroke& stroke);
    void end_step() noexcept;
    /// The client's strokes don't go on.
    void end_strokes(std::uint32_t client) noexcept;
    /// Releases held tissue. The step stays open, for the tissue's way back.
    void let_go() noexcept;
    /// @returns the refusal of a command while another client holds tissue
    std::optional<Outcome> held_from(std::uint32_t client, const Action& action) const;
    Outcome step_back(Step& step, bool undo);
    void stir() { m_settled = m_is_still = false; }
    void keep(std::list<Step>& step) noexcept;
    void forget(int tissue_steps);
    Outcome slide(std::uint32_t client, const Push& push);

    /// Returns the elastic energy if it is up to date or can be computed quickly.
    std::optional<double> energy();
    /// Reports a known force, or registers one for measurement.
    void add_force(std::uint32_t client, std::optional<double> before, Vec3d way_mm,
                   Outcome& outcome);
    void measure_energy() noexcept;
    void tissue_changed();

    FirstModel m_first_model;
    std::shared_ptr<LoadedScan> m_loaded;  ///< the lattice refers to its volume
    std::unique_ptr<Tissue> m_tissue;
    TissueChoice m_choice;
    std::optional<LiveDeformation> m_live;  ///< set after construction
    double m_iso_hu;
    Polarity m_polarity;
    bool m_relaxing = false, m_settled = true;
    bool m_is_still = false;  ///< remaining motion can't be seen
    std::string m_trouble;    ///< reason why the last sweep stopped the tissue; empty: none
    std::uint32_t m_last_client = 0;
    std::uint32_t m_holder = 0;
    Vec3d m_drag_mm{0, 0, 0};  ///< offset of the holder's drag
    std::optional<OpenStep> m_open;
    std::list<Step> m_done, m_undone;  ///< the next one is last
    std::list<Step> m_spare;           ///< preallocated, for the open step
    bool m_lost = false;
    std::int64_t m_steps = 0;  ///< made so far
    int m_unreachable = 0;     ///< oldest steps of the lattice that forget_steps has dropped
    /// A command with a pending energy measurement.
    struct Unmeasured {
        std::uint32_t client = 0;
        std::optional<double> before;
        Vec3d way_mm;
    };
    std::optional<Unmeasured> m_unmeasured;
    std::optional<FeltEnergy> m_felt;
    std::optional<double> m_energy;
    std::int64_t m_energy_elements = 0;  ///< elements in the deformed box at the measurement
    std::int64_t m_energy_rests = 0;     ///< commands without another measurement
};

}  // namespace pliant::serve
