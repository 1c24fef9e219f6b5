// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The set-ups of the two papers: objects, settings, and measurements. The page's numbers come from
// here, and the test checks them.

#pragma once

#include <pliant/chainmail.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <vector>

#include "slices.h"

namespace pliant::results {

/// The set-ups are fixed, so an error in one is a bug of this program.
template <class T>
T must(Result<T> result) {
    if (!result.ok()) {
        std::fprintf(stderr, "results: %s\n", result.error().message.c_str());
        std::exit(1);
    }
    return std::move(result).value();
}

/// A scan, its tissue, and the reports of the pushes so far.
struct Scenario {
    std::unique_ptr<Volume> scan;
    std::unique_ptr<ChainMail> tissue;
    std::vector<PushReport> reports;

    PushReport& push(const Push& push);
    PushReport& push(const std::vector<Vec3i>& elements, Vec3d push_mm);
};
Scenario make_scenario(Volume scan, const ChainMailSettings& settings, const TaskArena& arena);

// --- [Gibson1996] ---

/// Elements of a flat or solid object: `inside` selects tissue, `fixed` selects fixed elements.
/// Links to the empty surroundings carry no motion.
struct ObjectShape {
    Vec3i size;
    std::function<bool(Vec3i)> inside;
    std::function<bool(Vec3i)> fixed;
};
/// @param range, shear  maximum compression and stretch, and shear, of a link; fraction
/// @param yield  strain beyond this fraction of the limits stays; 0: none
Scenario gibson_object(const ObjectShape& shape, double range, double shear, const TaskArena& arena,
                       double yield = 0);
/// A chain of links of 1 mm in one dimension, each between (1 ± kChainRange) mm long; the element
/// kChainHeld is moved.
inline constexpr int kChainElements = 9, kChainHeld = 4;
inline constexpr double kChainRange = 0.4;
Scenario chain_scenario(const TaskArena& arena);
/// A sheet fixed at its left and right edges, pulled in its middle, relaxed while the tool holds
/// it, then released and relaxed until it is at rest.
struct Recovery {
    Scenario sheet;
    double pulled_mm = 0;  ///< largest displacement while the tool holds the sheet
    double left_mm = 0;    ///< after the release
};
inline constexpr int kRecoverySide = 60;
/// @param seen  called twice: while the tool holds the sheet, and at the end; may be empty
Recovery recovery_of(double yield, const TaskArena& arena,
                     const std::function<void(const Scenario&)>& seen = {});

// --- [Draeger2005] ---

struct CubeSettings {
    double offset = 0.2;
    double scale = 1.2;
    double z_scale = 1;      ///< distance of slices, for pixels of 1 mm
    bool z_adjusted = true;  ///< false: links along z have the limits of those along x
    double max_movement_mm = 20;
    LinkLimits limits = LinkLimits::Box;
};
ChainMailSettings settings_of(const CubeSettings& cube);
/// The thesis's cube, 60 mm wide, of the value 2000 on its scale, in air.
Scenario cube_scenario(const CubeSettings& cube, const TaskArena& arena);
/// A tool on the middle of the cube's face, opposite to the thesis's vector (0,1,0).
inline constexpr Vec3d kFace_mm{0, -29.5, 0};
inline constexpr Vec3d kThesisPush_mm{0, 1, 0};
/// The same material without a surface, pushed in its middle.
Scenario solid_scenario(const CubeSettings& cube, const TaskArena& arena);

/// The dent of a push in the surface at a threshold, along +y: the difference of the first
/// crossings on rays through the scan at rest and the deformed scan.
struct Dent {
    double depth_mm = 0, volume_mm3 = 0, area_mm2 = 0;  ///< area: deeper than kDented_mm
    /// Distance from the tool to half of the dent's depth, towards −z and towards +z.
    double half_below_mm = 0, half_above_mm = 0;
    double slope = 0;  ///< steepest, along z
};
inline constexpr double kDented_mm = 0.1;
Dent dent_of(const Scenario& scenario, Vec3d position_mm, double threshold_hu,
             const TaskArena& arena);
/// The same without resampling: displacement along +y of surface points at rest.
Dent moved_dent_of(const Scenario& scenario, Vec3d position_mm, double threshold_hu,
                   const TaskArena& arena);

/// Figures 5.7 and 5.8: a soft cuboid (0 HU) on a stiff one, 1000 to 1500 HU or all of 1000 HU.
enum class StiffHalf { Graded, Even };
Scenario layers_scenario(StiffHalf stiff, const TaskArena& arena);
inline constexpr Vec3d kBorder_mm{0, -24.5, 0}, kSoft_mm{0, -24.5, 15}, kStiff_mm{0, -24.5, -15};

/// Contours of half the push around the grabbed cell, in the three planes through it.
struct Roundness {
    Contour across_push;      ///< xz
    Contour along_push;       ///< xy
    Contour along_push_in_z;  ///< zy
};
Roundness roundness_of(const Scenario& scenario, Vec3d grabbed_mm, double push_mm);

/// A row of figure 6.2, or the other setting of section 6.1.
struct TimingCase {
    double offset, scale;
    std::int64_t elements_2005;
    double deform_2005_ms, map_2005_ms;
};
std::vector<TimingCase> timing_cases();
Scenario timing_scenario(const TimingCase& timing, int brick_size, const TaskArena& arena);
Push timing_push(const Scenario& scenario);
/// Elements that moved by more than rounding: a micrometre.
std::int64_t visibly_moved(const ChainMail& tissue);

/// Two walls that face each other over a gap of six voxels, 1 mm each.
Scenario passage_scenario(bool air, const TaskArena& arena);
inline constexpr Vec3i kNearWall{41, 32, 32}, kFarWall{48, 32, 32};
inline constexpr double kGap_mm = 6;
/// Elements of the near wall's face within 4 mm of its middle.
std::vector<Vec3i> near_wall_patch();
/// Bumps that protrude from a wall by ten voxels, 1 mm each.
enum class Bump {
    Column,    ///< nine voxels wide
    Overhang,  ///< a head on a stalk, with six voxels of air below it
    Finger,    ///< three voxels wide
};
Scenario bump_scenario(Bump bump, bool air, const TaskArena& arena);
inline constexpr Vec3i kBumpTip{40, 20, 32};
inline constexpr Vec3i kHeadEnd{51, 20, 32};  ///< of the overhang, at its free end
inline constexpr int kWallFront = 30;         ///< first element of the wall, along y

/// Push on the tip of the column by 8 mm, or on the overhang's free end by 6 mm; a sphere of 2.5
/// mm.
Push bump_push(Bump bump);

/// A sphere of 3 mm that descends 2 mm beside the finger's axis, to 9 mm below its contact with the
/// tip's height.
inline constexpr double kFingerTool_mm = 3, kBesideFinger_mm = 2;
/// The sphere carries along the elements that it holds at a depth of 1 mm.
void push_finger(Scenario& scenario);
/// The finger slides off the sphere.
SlideReport slide_off_finger(Scenario& scenario);

}  // namespace pliant::results
