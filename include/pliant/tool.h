// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Motions of tools, and the reports of a tissue on them: the same for every model.
//
// A cutting surface is the path of a blade through the deformed scan: a line swept along the depth
// vector. Links that cross this ribbon are cut.
//
//        line[0]      line[1]   line[2]
//           +-----------+---------+
//          /           /         /
//         /           /         /         depth
//        +-----------+---------+
//

#pragma once

#include <pliant/core/vec.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// A tool of a shape of its own, such as a spatula, in its present orientation.
class ToolShape {
  public:
    virtual ~ToolShape() = default;
    /// @param offset_mm  from the tool's contact point, LPS
    virtual bool contains(Vec3d offset_mm) const noexcept = 0;
};

struct Push {
    Vec3d point_mm{0, 0, 0};  ///< contact point of the tool, LPS
    Vec3d push_mm{0, 0, 0};   ///< motion of the tool, LPS
    /// 0: grabs the eight elements of the cell that holds the point. Else all tissue elements in
    /// the sphere; if it is smaller than a voxel along some axis, also the elements of every
    /// cell whose trilinear value is tissue somewhere in it.
    double sphere_radius_mm = 0;
    /// If set, only elements or nodes in this shape are taken; the sphere then bounds the search.
    /// It must outlive the push, and a drag that began with it. Slides take spheres alone.
    const ToolShape* shape = nullptr;
};

enum class PushStatus { Applied, Limited, Rejected };
/// Wall: an obstacle outside of the tissue, or the wall that a slide meets; Fold: only for springs.
enum class LimitedBy { None, Bone, Movement, Wall, Fold };

/// Name in reports and messages: `applied`, `limited`, `rejected`.
std::string_view name_of(PushStatus status);
/// Likewise: `none`, `bone`, `movement`, `wall`, `fold`.
std::string_view name_of(LimitedBy limit);

struct PushReport {
    PushStatus status = PushStatus::Rejected;
    LimitedBy limited_by = LimitedBy::None;
    double step_fraction = 0;  ///< executed part of the scaled push, 0…1
    std::int64_t grabbed_elements = 0;
    std::int64_t moved_elements = 0;  ///< elements whose displacement changed
    double solve_ms = 0;
    int forgotten_steps = 0;         ///< oldest steps that were dropped from the history; see Undo
    std::string message{};           ///< reason, if it isn't simply applied
    std::optional<Vec3d> bone_mm{};  ///< the bone that stopped it nearest to the tool [LPS]
};

/// Elements that a tool grabbed, and elements that can follow it.
struct GrabReport {
    std::int64_t grabbed_elements = 0;  ///< 0: nothing to grab, and nothing is held
    std::int64_t reach_elements = 0;    ///< elements in the drag's reach; 0: not computed
    std::int64_t field_bytes = 0;       ///< memory for the fields, beside the bricks of the reach
    double grab_ms = 0;
    std::string message{};  ///< reason if nothing is held
};

/// Values that are tissue for a tool: values from a threshold upwards, or values below it.
struct TissueValues {
    double threshold_hu = -500;
    bool is_above = true;

    bool hold(double value_hu) const { return (value_hu >= threshold_hu) == is_above; }
};

struct SlideReport {
    double way_fraction = 0;  ///< executed part of the scaled path, in whole steps, 0…1
    /// Cause of the end: Bone; Movement; Wall if tissue closes around the sphere's centre.
    LimitedBy limited_by = LimitedBy::None;
    /// The sphere's centre at the end [mm, LPS]: way_fraction of the path, or the nearest free
    /// position if tissue moved there. An endoscope's eye can stay here.
    Vec3d end_mm{0, 0, 0};
    bool ends_in_tissue = false;       ///< no free position was found within reach
    int contacts = 0;                  ///< moves of tissue out of the sphere's way
    std::int64_t inside_elements = 0;  ///< tissue elements in the sphere at end_mm
    double slide_ms = 0;
    int forgotten_steps = 0;         ///< oldest steps that were dropped from the history
    std::string message{};           ///< reason, if it ended early
    std::optional<Vec3d> bone_mm{};  ///< as in PushReport
};

/// A line swept along a vector.
struct CutSurface {
    std::vector<Vec3d> line_mm;  ///< two or more points in the deformed scan, LPS
    Vec3d depth_mm{0, 0, 0};     ///< LPS; not along the line
};

struct CutReport {
    std::int64_t cut_links = 0;  ///< newly cut
    double cut_ms = 0;
    int forgotten_steps = 0;  ///< oldest steps that were dropped from the history
};

/// A sphere that moves between two positions: a capsule, or a sphere if they are equal.
struct CarveTool {
    Vec3d from_mm{0, 0, 0};  ///< centre, in the deformed scan, LPS
    Vec3d to_mm{0, 0, 0};
    double radius_mm = 0;      ///< above 0, up to 500
    bool spare_fixed = false;  ///< spares elements that never move (bone)
};

struct CarveReport {
    std::int64_t carved_elements = 0;  ///< newly carved
    double carve_ms = 0;
    int forgotten_steps = 0;
};

}  // namespace pliant
#pragma GCC visibility pop
