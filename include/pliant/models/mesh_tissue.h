// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The base of tissues whose elements are the nodes of a mesh: bodies, networks, lattices of
// springs, and tissues of your own.
//
// A push holds the nodes in the tool, or those of the cell around its point, and moves them in
// strides, between which the other nodes follow:
//
//     (●)●●●    (●)●●●     (●●)●●      nodes on the way of a sphere join
//     ○ ○ ○  →    ○ ○ ○  →   ○ ○ ○
//
// A stride that folds the mesh is undone and tried in halves, down to an eighth; then the tissue
// gives way for some steps to the tool that stands still; then the push ends. A slide moves a
// sphere that keeps the mesh's surface out, in the same strides. A call that fails is undone.
//
// A model supplies
//
//   at_rest(), positions_mm(), is_fixed()    its nodes
//   stride(), step(), is_calm()              the motion of held nodes; time, and its end
//   hold_nodes(), put()                      changes of the held nodes and of positions
//
// and further state: velocities, a surface, rules of its own. tests/tissue/test_mesh_tissue.cpp
// has a small one.

#pragma once

#include <pliant/mesh.h>
#include <pliant/models/cut_mesh.h>
#include <pliant/models/springs.h>
#include <pliant/own_tissue.h>
#include <pliant/tissue.h>
#include <pliant/tool.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// A mesh at rest.
struct RestMesh {
    std::vector<Vec3d> nodes_mm{};
    std::vector<std::array<std::int32_t, 4>> cells{};  ///< tetrahedra; none: cells of another kind
    std::vector<double> volumes_mm3{};                 ///< [tetrahedron]
    double edge_mm = 0;                                ///< mean edge of the tetrahedra
};
RestMesh rest_mesh(TetMesh mesh);
/// The first tetrahedron without a volume above 0.
std::optional<std::size_t> inverted_cell(const RestMesh& mesh);

/// Thread safety: one thread.
class MeshTissue : public NodeTissue {
  public:
    /// Copies the present positions [mm, LPS]. @param[out] positions_mm  one for each node
    virtual void positions_mm(std::span<Vec3d> positions_mm) const = 0;
    std::int32_t node_count() const { return std::int32_t(at_rest().nodes_mm.size()); }
    /// The mesh with its cuts: its nodes are those of positions_mm(), the first ones those of the
    /// mesh without cuts. Null if there are none; valid until the next change.
    virtual const CutMesh* cut_mesh() const { return nullptr; }

    Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept override;
    /// @returns Unsupported if the traits say so
    Result<SlideReport> slide(std::uint32_t tool, const Push& way,
                              const TissueValues& tissue_values) noexcept override;
    void release(std::uint32_t tool) noexcept override;
    bool is_touched_by(std::uint32_t tool) const noexcept override {
        return m_tools.contains(tool) || m_spheres.contains(tool);
    }
    bool is_touched() const noexcept override { return !m_tools.empty() || !m_spheres.empty(); }
    /// An eye keeps the surface out; without a surface, or in the tissue, it has no effect.
    Status place_eye(std::uint32_t tool, Vec3d position_mm, double radius_mm) noexcept override;
    bool has_eye(std::uint32_t tool) const noexcept override { return m_eyes.contains(tool); }
    Result<Sweep> sweep() noexcept override;
    Status reset() noexcept override;

    /// Three numbers for each node, its position, by default: a restored tissue has no velocity.
    void state(std::vector<double>& numbers) const override;
    Status set_state(std::span<const double> numbers) noexcept override;

    const Volume& volume() const override { return m_carried->volume(); }
    const Deformation& deformation() const override;
    const TaskArena& arena() const override { return m_carried->arena(); }
    Status update_deformation() const override;

  protected:
    using Tools = std::map<std::uint32_t, std::vector<std::int32_t>>;
    using Spheres = std::map<std::uint32_t, TouchTool>;

    /// Lets tetrahedra carry a scan: voxels within reach of the mesh move with it.
    /// @returns InvalidArgument for a mesh beside the scan; LimitExceeded if memory runs out
    static Result<std::unique_ptr<MovingScan>> carry(const Volume& scan, const TetMesh& mesh,
                                                     double reach_mm, const TaskArena& arena);
    /// @param carried  by carry(), or a scan that place_scan() of the model moves
    MeshTissue(std::unique_ptr<MovingScan> carried, std::size_t node_count);

    // The model's nodes.

    virtual const RestMesh& at_rest() const = 0;
    virtual bool is_fixed(std::int32_t node) const = 0;
    /// Sets all nodes except fixed ones.
    virtual void put(std::span<const Vec3d> positions_mm,
                     std::span<const Vec3d> velocities_mm_s) noexcept = 0;
    /// Copies the velocities. By default they stay 0: nodes of an undone stride stop.
    virtual void velocities_mm_s(std::span<Vec3d>) const {}
    /// Keeps the state for take_back(), which is called after hold_nodes(). By default it is
    /// positions and velocities.
    virtual void keep();
    virtual void take_back() noexcept;

    // Its motion.

    /// The nodes of m_tools, m_spheres or m_eyes have changed.
    virtual void hold_nodes() noexcept = 0;
    /// Moves these nodes, which a tool holds, while time passes. @returns the reason if it can't
    virtual Status stride(std::span<const std::int32_t> nodes, Vec3d shift) = 0;
    /// Lets time pass. @returns the reason why all motion ends
    virtual Status step() = 0;
    /// Whether the motion is at its end, after a step that led to m_memory.positions.
    virtual bool is_calm() = 0;
    /// A free tissue that has come to rest so near to its rest positions is moved to them.
    virtual double home_mm() const { return 0.02; }

    // Its tools.

    struct Rules {
        double longest_mm = 1;       ///< longest stride
        double tolerated_folds = 0;  ///< folded_cells() that a push may leave
        bool gathers = true;         ///< nodes on the way of a sphere join
        bool halts = false;          ///< all nodes stop at the end of a push or slide
        std::string_view folds = "cells would fold; larger ones go farther";
    };
    /// By default strides are a quarter of the mean edge and half of a sphere's radius at most.
    virtual Rules rules(const Push& push) const;
    /// Whether a push may begin.
    virtual Status check_push(const Push&) { return Ok{}; }
    /// Called at the end of a push that has met no node.
    virtual Status check_free_push(const Push&) const { return Ok{}; }
    /// Whether a node belongs to the material, so that a sphere may hold it.
    virtual bool has_material(std::int32_t) const { return true; }
    /// Whether a tetrahedron contains a point, at m_memory.positions.
    virtual bool is_in_cell(std::size_t cell, Vec3d point_mm) const;
    /// Nodes of the cell around a push's point.
    virtual std::vector<std::int32_t> nodes_around(const Push& push) const;
    /// Measure of folds at some positions: volume at rest of tetrahedra with less than a tenth of
    /// it left [mm³]. A stride must not raise it above the tolerated volume.
    virtual double folded_cells(std::span<const Vec3d> positions_mm);

    // Its surface, if traits().slides.

    /// Whether a point lies in the tissue, where the centre of a sphere must not enter.
    virtual bool contains(std::span<const Vec3d>, Vec3d) const { return false; }
    virtual bool can_begin(TouchTool&) { return true; }
    struct SlideStep {
        Vec3d shift, to;
    };
    /// The sphere's n-th stride of so many.
    virtual SlideStep slide_step(const TouchTool& sphere, const Push& way, int n, int count) const;
    /// Moves a sphere, of a tool, while time passes. @returns the reason if it can't
    virtual Result<LimitedBy> slide_by(std::uint32_t, TouchTool&, Vec3d) { return LimitedBy::None; }
    /// Whether the sphere has touched the surface in its last stride.
    virtual bool touches(const TouchTool& sphere) const { return !sphere.triangles.empty(); }

    // Its scan.

    virtual Status place_scan(std::span<const Vec3d> positions_mm) const;

    // For models.

    /// Nodes that a tool holds, ascending.
    std::span<const std::int32_t> held_by(std::uint32_t tool) const;
    /// Whether a sphere that touches nothing stays clear of the nodes' box, at m_memory.positions.
    bool is_free(const TouchTool& sphere, Vec3d way_mm) const;
    /// Tissue moves again.
    void wake() noexcept;
    /// Stops all nodes.
    void halt() noexcept;

    std::unique_ptr<MovingScan> m_carried;
    Tools m_tools;
    Spheres m_spheres, m_eyes;  ///< tools that slide, and observers
    bool m_settled = true;
    int m_sweeps = 0;  ///< since tissue last began to move
    mutable bool m_is_shown = true;
    mutable bool m_is_near = false;  ///< the shown state is only near the present one
    /// [node], memory of noexcept functions.
    struct Memory {
        Memory() = default;
        explicit Memory(std::size_t nodes);
        std::vector<Vec3d> first, first_velocities;  ///< at the beginning of a call
        std::vector<Vec3d> positions, velocities;    ///< the present ones
        std::vector<Vec3d> stepped;                  ///< after a stride
        std::vector<Vec3d> shown;                    ///< of the deformation
    };
    mutable Memory m_memory;

  private:
    Result<PushReport> push_nodes(std::uint32_t tool, const Push& push);
    Result<SlideReport> slide_sphere(std::uint32_t tool, const Push& way);
    Result<LimitedBy> slide_stride(std::uint32_t tool, const SlideStep& step, double tolerated);
    Result<bool> end_stride(const Status& went, double tolerated);
    template <class Act>
    auto undone_on_error(const Act& act);
    std::vector<std::int32_t> nodes_met(const Push& push, Vec3d point_mm, bool or_around) const;
    std::vector<std::int32_t> nodes_at(const Push& push, Vec3d point_mm, bool or_around) const;
    void take(std::uint32_t tool, std::vector<std::int32_t> nodes);
    void gather(std::uint32_t tool, const Push& push, Vec3d centre_mm);
    void come_to_rest() noexcept;
    Status show() const;

    double m_folded = 0;  ///< folded_cells() at m_memory.positions, during a push or slide
};

}  // namespace pliant
#pragma GCC visibility pop
