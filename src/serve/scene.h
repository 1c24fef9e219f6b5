// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The one scene of a server: a scan, its lattice, the deformed volume, and what was done to them.
//
// The scene knows no clock: what it is depends on the commands and the number of relaxation's
// sweeps alone. That is why a recorded session gives the same bits again, on any machine and with
// any number of threads. Whoever owns it calls it from one thread.
//
// Undo covers everything: steps of the lattice, which the lattice takes back, and changes of the
// threshold, which are kept here. A step ends when something else begins, so pushes of one stroke,
// and relaxation from start to end, are one step each.

#pragma once

#include <pliant/resample.h>

#include <cstdint>
#include <filesystem>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene/tissue.h"
#include "serve/commands.h"
#include "serve/messages.h"
#include "serve/scene_memo.h"
#include "serve/source.h"

namespace pliant::serve {

class VesselTissue;

class Scene {
  public:
    static Result<std::unique_ptr<Scene>> open(const SceneSource& source, const TaskArena& arena) {
        return open(source, arena, arena);
    }
    /// @param loading  for the work done here, while the other may be in use
    /// @param give_up  asked now and then while the scan is read; may be empty
    static Result<std::unique_ptr<Scene>> open(const SceneSource& source, const TaskArena& arena,
                                               const TaskArena& loading,
                                               const std::function<bool()>& give_up = {}) noexcept;
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;

    /// @param client  whose command it is; strokes, grabs and tools belong to clients
    /// @pre is_command(action)
    /// @returns an outcome that ran_out where memory runs out: nothing was done then, but that the
    ///          step that went on may have ended
    Outcome carry_out(std::uint32_t client, const Action& action) noexcept;
    /// Ends the present step and releases held tissue.
    /// @param client  whose command ran out of memory
    void interrupt(std::uint32_t client) noexcept;
    /// Whether sweep() has something to do.
    bool wants_sweep() const { return m_relaxing && !m_settled; }
    /// What time a sweep stands for [ms]; 0: none, it may be as fast as it can.
    double sweep_time_ms() const { return m_tissue->sweep_time_ms(); }

    /// One sweep of relaxation. @returns how long it took [ms]; LimitExceeded, with nothing done,
    ///          where memory runs out
    Result<double> sweep() noexcept;
    /// Whether the client has hold of tissue, or left a tool that stays in relaxation's way.
    bool has_contact(std::uint32_t client) const;
    bool has_eye(std::uint32_t client) const { return m_tissue->has_eye(client); }
    /// Whether tissue that returns to rest may close over a sphere: the scan at rest shows tissue
    /// in it, or imprints stay.
    bool may_close_over(Vec3d place_mm, double radius_mm) const;
    /// Whether the tissue relaxes by itself, also while it has settled.
    bool is_relaxing() const { return m_relaxing; }
    /// The highest number of a client so far.
    std::uint32_t last_client() const { return m_last_client; }

    /// Whether nobody holds anything and nothing relaxes, so that the scene can rest.
    bool is_quiet() const { return m_holder == 0 && !m_tissue->is_touched() && !wants_sweep(); }
    /// Ends what could go on: the next stroke is a step of its own. @pre is_quiet()
    /// @returns what the scene is beside tissue()
    Result<SceneMemo> rest() noexcept;
    /// Back to where rest() was called, in a scene to which nothing was done yet. What can be
    /// undone begins anew.
    /// @param state  saved by tissue().save_state() then
    Status restore(const std::filesystem::path& state, const SceneMemo& memo);
    /// The oldest steps can't be undone or redone any more. @param count  see SceneMemo::steps
    void forget_steps(std::int64_t count);
    /// No step can be undone any more. @param made  see SceneMemo::steps
    void lose_steps(std::int64_t made) noexcept;
    /// Whether that has happened since the last call: a step was too large to be kept, or there
    /// was no memory for it.
    bool take_lost() noexcept { return std::exchange(m_lost, false); }
    /// That were made so far.
    std::int64_t steps() const { return m_steps; }

    /// What the last command of a tool felt, if it is known now and was not told yet. Takes a while
    /// where much is deformed: for a moment when nobody waits for a picture.
    std::optional<FeltForce> measure_force();

    /// The deformed volume is brought up to date; see LiveDeformation.
    Result<LiveUpdate> update() { return m_live->update(); }
    const Volume& deformed() const { return m_live->volume(); }
    /// For overlays; see LiveDeformation.
    bool keep_sources(bool keep) { return m_live->keep_sources(keep); }
    const LiveDeformation& live() const { return *m_live; }
    const Tissue& tissue() const { return *m_tissue; }
    Tissue& tissue() { return *m_tissue; }
    /// Null: the tissue is another one.
    const VesselTissue* vessel() const;
    const TissueChoice& choice() const { return m_choice; }
    const VolumeInfo& info() const { return m_loaded->info; }
    void set_volume_id(std::uint32_t id) { m_loaded->info.id = id; }
    /// The scan, for those who look at it for longer than the scene is there.
    std::shared_ptr<const LoadedScan> loaded() const { return m_loaded; }
    std::uint64_t scan_hash() const { return m_loaded->hash; }
    /// Fills in what the scene knows: all but step, clients and timing.
    void describe(SharedState& state) const;

  private:
    /// The scan as whatever tissue there now is moves it.
    struct Shown : MovingScan {
        explicit Shown(const std::unique_ptr<Tissue>& t) : tissue(t) {}
        const Volume& volume() const override { return tissue->volume(); }
        const Lattice& lattice() const override { return tissue->lattice(); }
        const TaskArena& arena() const override { return tissue->arena(); }
        Status update_lattice() const override { return tissue->update_lattice(); }
        const std::unique_ptr<Tissue>& tissue;
    };
    enum class StepKind { Tissue, Iso };
    struct Step {
        StepKind kind = StepKind::Tissue;
        std::string name{};
        double iso_hu = 0;  ///< the other one: before if done, after if undone
        Polarity polarity = Polarity::Rising;
        std::uint32_t client = 0, stroke = 0;
        std::int64_t number = 0;  ///< 1 for the scene's first step
    };
    /// The step that is going on: everything that is done to the tissue belongs to it.
    struct OpenStep {
        std::string name;
        std::uint32_t client = 0;
        std::uint32_t stroke = 0;
        int undo_steps_before = 0;
    };

    Scene(std::shared_ptr<LoadedScan> loaded, const TissueChoice& choice,
          std::unique_ptr<Tissue> tissue);

    static Result<std::unique_ptr<Scene>> load(const SceneSource& source, const TaskArena& arena,
                                               const TaskArena& loading,
                                               const std::function<bool()>& give_up);
    /// Makes another tissue of the scan. Nothing changes where it can't be made.
    Status choose(const TissueChoice& choice);

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

    void reserve_step();
    void begin_step(const std::string& name, std::uint32_t client, std::uint32_t stroke);
    void end_step() noexcept;
    void keep(std::list<Step>& step) noexcept;
    void forget(int tissue_steps);
    void swap_iso(Step& step);
    Outcome slide(std::uint32_t client, const Push& push);

    /// The elastic energy, if it was measured and nothing changed since, or can be had quickly.
    std::optional<double> energy();
    /// Tells what is known without measuring, and notes what there is to measure.
    void add_force(std::uint32_t client, std::optional<double> before, Vec3d way_mm,
                   Outcome& outcome);
    void measure_energy() noexcept;
    void tissue_changed();

    std::shared_ptr<LoadedScan> m_loaded;  ///< the lattice refers to its volume
    std::unique_ptr<Tissue> m_tissue;
    TissueChoice m_choice;
    Shown m_shown;
    std::optional<LiveDeformation> m_live;  ///< always there once the scene is
    double m_iso_hu;
    Polarity m_polarity;
    bool m_relaxing = false, m_settled = true;
    std::uint32_t m_last_client = 0;
    std::uint32_t m_holder = 0;
    Vec3d m_drag_mm{0, 0, 0};  ///< how far the holder has come
    std::optional<OpenStep> m_open;
    std::list<Step> m_done, m_undone;  ///< the next one last
    std::list<Step> m_spare;           ///< one, for the step that goes on
    std::int64_t m_changes = 0;        ///< of all steps, the open one included
    bool m_lost = false;
    std::int64_t m_steps = 0;  ///< made so far
    int m_unreachable = 0;     ///< the lattice's oldest steps, which forget_steps hides
    /// A command whose energy is not measured yet.
    struct Unmeasured {
        std::uint32_t client = 0;
        std::optional<double> before;
        Vec3d way_mm;
    };
    std::optional<Unmeasured> m_unmeasured;
    std::optional<FeltForce> m_felt;
    std::optional<double> m_energy;
    std::int64_t m_energy_elements = 0;  ///< in the box of what was deformed when it was measured
    std::int64_t m_energy_rests = 0;     ///< commands for which it isn't measured again
};

}  // namespace pliant::serve
