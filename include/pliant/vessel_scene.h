// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The scene file of `pliant vessel` and `pliant serve`, and what it makes: docs/vessel.md lists its
// keys.
//
//   auto file = read_vessel_file("aorta.toml");
//   auto made = make_vessel(*file, arena);
//   auto scene = CatheterScene::create(std::move(made->wall), made->settings);
//
// Where memory runs out, functions return LimitExceeded.

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

/// What the hand does for a while: until the first of the bounds that are given.
struct VesselAct {
    CatheterCommand command{};
    bool follow = false;  ///< the tip is steered along the way
    std::optional<double> for_s, until_inserted_mm, until_way_mm;
};

struct VesselFile {
    std::string file;  ///< its own name

    // One of: a phantom, a surface, a centreline, a label volume, a scan.
    std::string phantom, surface, centreline, labels_file, scan;
    std::string ends;  ///< a centreline at whose ends a closed surface is cut off
    double trim = 0.5;
    std::vector<int> labels{1};
    double low_hu = 0, high_hu = 0, within_mm = 15, smoothing_voxels = 0.8;
    WallSettings wall{};

    std::string way_file;
    int way_branch = 1;
    bool way_reverse = false;
    std::vector<Vec3d> way_mm;  ///< points, or with a scan from and to
    double ahead_mm = 15, gain = 1.5, most_deg = 120;

    int entry_end = 1;  ///< number of the open end
    double entry_inwards = 0.5;
    bool entry_given = false;  ///< as a place and a direction
    CatheterSettings settings{};
    std::vector<VesselAct> acts;  ///< may be empty
    double most_steps = 1e6;      ///< the script ends after so many at the latest
};

/// Rows of a scene file beside catheter_rows().
SettingRows<VesselFile> vessel_file_rows() noexcept;
/// Rows of a [[script]] table.
SettingRows<VesselAct> vessel_act_rows() noexcept;

/// Files that it names are found from its own folder.
/// @returns one line that names the file and the key
Result<VesselFile> read_vessel_file(const std::string& file) noexcept;

struct MadeVessel {
    VesselWall wall;
    std::vector<Vec3d> way;      ///< [mm]; may be empty
    std::optional<Volume> scan;  ///< that the file names
    CatheterSettings settings;   ///< with the entry
};
/// @returns one line that names the file that is at fault
Result<MadeVessel> make_vessel(const VesselFile& file, const TaskArena& arena) noexcept;

/// Plays the acts of a scene file, one after the other:
///
///   while (script.next(scene, command)) { scene.command(command); scene.step(1, arena); }
class VesselScript {
  public:
    VesselScript(const VesselFile& file, const std::vector<Vec3d>& way);
    /// Sets the command of the next step. @returns false after the last act
    bool next(const CatheterScene& scene, CatheterCommand& command);
    /// Distance of the tip along the way [mm]; 0 without one.
    double way_mm(const CatheterScene& scene) const;
    double progress() const;  ///< share of the acts that are over, 0…1

  private:
    bool is_over(const CatheterScene& scene, const CatheterMeasures& now) const;

    std::vector<VesselAct> m_acts;
    WayPilot m_pilot;
    bool m_has_way;
    std::size_t m_act = 0;
    CatheterMeasures m_began{};  ///< when the act began
    double m_began_way = 0;
};

/// A scan as a vessel full of contrast agent would give, for those that come without one: the lumen
/// at 300 HU, its wall at 90, tissue around it at 20 to 60 in a pattern that shows how it moves.
/// Voxels of a millimetre, or larger where more than 256 were needed along an axis; its key values
/// say how it wants to be looked at.
/// @returns InvalidArgument where the wall's boundary isn't closed
Result<Volume> scan_of_vessel(const VesselWall& wall, const TaskArena& arena) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
