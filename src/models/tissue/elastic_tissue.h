// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The elastic scan (make_elastic): equilibrium on nested lattices (elastic/levels.h) under tools
// that hold nodes, or that nodes slide along.
//
// A push goes in strides of half the tool's radius, each one solved roughly; sweeps go on while the
// tools rest. Without the tools that hold it, tissue returns as a Kelvin-Voigt solid whose
// viscosity is proportional to its stiffness, η = τ E: all its displacements decay as exp(−t/τ).

#pragma once

#include <pliant/models/elastic_scan.h>
#include <pliant/own_tissue.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "elastic/levels.h"
#include "elastic/shown_displacement.h"
#include "field/element_edits.h"

namespace pliant {

class ElasticTissue final : public OwnTissue {
  public:
    /// @pre checked settings with moduli
    ElasticTissue(const Volume& scan, const ElasticScanSettings& settings, const TaskArena& arena);

    TissueTraits traits() const noexcept override;
    void let_go() noexcept override;
    void release(std::uint32_t tool) noexcept override;
    bool is_touched_by(std::uint32_t tool) const noexcept override;
    Status place_eye(std::uint32_t tool, Vec3d position_mm, double radius_mm) noexcept override;
    bool has_eye(std::uint32_t tool) const noexcept override { return m_eyes.contains(tool); }
    bool is_touched() const noexcept override { return !m_tools.empty(); }
    void state(std::vector<double>& numbers) const override;
    std::uint64_t file_kind() const noexcept override { return 0x35'6c'65'73'6c'70'00'00; }
    const Volume& volume() const override { return m_scan; }
    const Deformation& deformation() const override { return m_deformation; }
    const TaskArena& arena() const override { return m_arena; }
    Status update_deformation() const override;
    Result<bool> approach_deformation(std::int64_t max_elements) const override;
    Record figures() const override;

  protected:
    Result<PushReport> do_push(std::uint32_t tool, const Push& push) override;
    Result<GrabReport> do_grab(std::uint32_t tool, const Push& position, double reach_mm) override;
    Result<PushReport> do_drag_to(Vec3d offset_mm) override;
    Result<SlideReport> do_slide(std::uint32_t tool, const Push& way,
                                 const TissueValues& tissue_values) override;
    Result<CutReport> do_cut(const CutSurface& surface) override;
    Result<CarveReport> do_carve(const CarveTool& tool) override;
    Result<Sweep> do_sweep() override;
    Status do_reset() override;
    Status do_set_state(std::span<const double> numbers) override;
    std::optional<Vec3d> do_force_n(std::uint32_t tool) override;

  private:
    /// A tool at rest: nodes that it holds, or a sphere that they slide along.
    struct Tool {
        std::vector<HeldNode> nodes;
        // While it slides:
        std::vector<Vec3d> forces_un{};   ///< [node] of the last solution, lattice; or empty
        std::vector<Vec3d> surface_mm{};  ///< [node] place on the sphere, from its centre
        Vec3d held_at_mm{0, 0, 0};        ///< the centre for which nodes are held
        bool slides = false;
        Vec3d centre_mm{0, 0, 0};  ///< lattice: along the scan's axes, from its first voxel
        double radius_mm = 0;
        TissueValues tissue{};
        Vec3d force_un{0, 0, 0};  ///< on the tool, lattice
    };

    struct Way {
        Vec3d from_mm, shift_mm;  ///< of the tool's centre, lattice
        double radius_mm = 0, longest_mm = 0;
    };
    struct WayEnd {
        double fraction = 0;
        LimitedBy limited_by = LimitedBy::None;
        std::optional<Vec3d> bone_mm{};  ///< world
        std::string message{};
    };

    /// The last step of a tool, if no cell was smoothed and nothing else has moved the tissue.
    struct Step {
        std::uint32_t tool;
        Vec3d shift_mm;                 ///< lattice; 0 after a sweep
        std::vector<double> earlier{};  ///< state before, if there was a shift
    };
    /// A drag: the tissue goes on as it moved last; where the tool turns, by its linear response.
    struct Drag {
        std::uint32_t tool;
        Vec3d from_mm;  ///< of the tool, lattice
        double radius_mm;
        HeldResponse response{};
    };

    void find_response();
    Vec3d go_on(std::uint32_t tool, Vec3d shift_mm);
    bool predict(Vec3d shift_mm);
    PushReport report_of(const WayEnd& end, const Tool& tool) const;
    Vec3d lattice_of(Vec3d world_mm) const;
    Vec3d rest_mm(Vec3i voxel) const;
    template <class Visit>
    void visit_near(Vec3d centre_mm, double radius_mm, const Visit& visit) const;
    std::vector<HeldNode> nodes_at(const Push& push, Vec3d centre_mm, bool or_around) const;
    void gather(Tool& tool, const Push& push, Vec3d centre_mm, Vec3d shift_mm);
    void look_at(const Way& way);
    template <class Move>
    WayEnd follow(const Way& way, Tool& tool, const Move& move);
    double shortest_edge_mm() const;
    void stay(Tool& tool) const;
    void press(Tool& tool);
    void find_forces();
    void hold_all();
    int stride_iterations() const;
    void solve(int iterations);
    ElementFacts facts() const;
    void edit(EditMap& bricks);
    std::optional<EditMap> edits_of(std::span<const double> numbers) const;
    std::optional<Vec3d> bone_in(Vec3d centre_mm, double radius_mm) const;
    void find_contacts(Tool& tool) const;

    const Volume& m_scan;
    const TaskArena& m_arena;
    ElasticScanSettings m_settings;
    mutable ShownDisplacement m_field;  ///< with the edits
    StiffnessMap m_map;
    ElasticLevels m_levels;
    std::map<std::uint32_t, Tool> m_tools, m_eyes;
    std::optional<Drag> m_drag;
    std::optional<Step> m_step;
    bool m_settled = true;
    bool m_is_fresh = false;  ///< a tool has moved since the last sweep, with a solution
    int m_sweeps = 0;         ///< with tools at rest
    bool m_returns = false;   ///< a tool has let go since the tissue last was in equilibrium
    Deformation m_deformation;
    mutable bool m_is_shown = true;
    std::vector<double> m_before;  ///< state at the beginning of a stride
};

}  // namespace pliant
