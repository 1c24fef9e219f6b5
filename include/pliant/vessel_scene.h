// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The scene file of `pliant vessel` and `pliant serve`, and the construction of its scene.
// docs/vessel.md lists its keys.
//
//   auto file = read_vessel_file("aorta.toml");
//   auto made = make_vessel(*file, arena);
//   auto scene = CatheterScene::create(std::move(made->wall), made->settings);
//
// If memory runs out, functions return LimitExceeded.

#pragma once

#include <pliant/catheter.h>
#include <pliant/volume.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Largest value of `most_steps`, and largest number of steps of a log of the hand.
inline constexpr std::int64_t kMaxVesselSteps = 10'000'000;

/// Motion of the hand until the first of the given bounds.
struct VesselAct {
    CatheterCommand command{};
    bool follow = false;  ///< the tip is steered along the path
    std::optional<double> for_s, until_inserted_mm, until_way_mm;
};

struct VesselFile {
    std::string file;  ///< path of this file

    // Exactly one source: a phantom, a surface, a centreline, a label volume, a scan.
    std::string phantom, surface, centreline, labels_file, scan;
    std::string ends;  ///< a centreline whose ends cut off a closed surface
    double trim = 0.5;
    std::vector<int> labels{1};
    double low_hu = 0, high_hu = 0, within_mm = 15, smoothing_voxels = 0.8;
    WallSettings wall{};

    std::string way_file;
    int way_branch = 1;
    bool way_reverse = false;
    std::vector<Vec3d> way_mm;  ///< points of the path; with a scan: start and end
    double ahead_mm = 15, gain = 1.5, most_deg = 120;

    int entry_end = 1;  ///< number of the open end
    double entry_inwards = 0.5;
    bool entry_given = false;  ///< the entry is given as a position and a direction
    CatheterSettings settings{};
    std::vector<VesselAct> acts;  ///< may be empty
    double most_steps = 1e6;      ///< limit of the script's steps
};

/// Rows of a scene file, without those of catheter_rows().
SettingRows<VesselFile> vessel_file_rows() noexcept;
/// Rows of a [[script]] table.
SettingRows<VesselAct> vessel_act_rows() noexcept;

/// Reads a scene file. Its relative paths refer to its folder.
/// @returns one line with the file and the key
Result<VesselFile> read_vessel_file(const std::string& file) noexcept;

struct MadeVessel {
    VesselWall wall;
    std::vector<Vec3d> way;      ///< path [mm, LPS]; may be empty
    std::optional<Volume> scan;  ///< the scan that the file names
    CatheterSettings settings;   ///< including the entry
};
/// @returns one line with the faulty file
Result<MadeVessel> make_vessel(const VesselFile& file, const TaskArena& arena) noexcept;

/// Plays the acts of a scene file in order:
///
///   while (script.next(scene, command)) { scene.command(command); scene.step(1, arena); }
class VesselScript {
  public:
    VesselScript(const VesselFile& file, const std::vector<Vec3d>& way);
    /// Sets the command of the next step. @returns false after the last act
    bool next(const CatheterScene& scene, CatheterCommand& command);
    /// Distance of the tip along the path [mm]; 0 without a path.
    double way_mm(const CatheterScene& scene) const;
    double progress() const;  ///< share of finished acts, 0…1

  private:
    bool is_over(const CatheterScene& scene, const CatheterMeasures& now) const;

    std::vector<VesselAct> m_acts;
    WayPilot m_pilot;
    bool m_has_way;
    std::size_t m_act = 0;
    CatheterMeasures m_began{};  ///< at the start of the act
    double m_began_way = 0;
};

/// Makes a synthetic scan of a vessel with contrast agent, for scenes without a scan: the lumen at
/// 300 HU, its wall at 90, tissue around it at 20 to 60 in a pattern that makes motion visible. The
/// voxels have an edge of 1 mm, or more if an axis would need over 256 of them. The key values
/// recommend a view.
/// @returns InvalidArgument if the wall's boundary isn't closed
Result<Volume> scan_of_vessel(const VesselWall& wall, const TaskArena& arena) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
