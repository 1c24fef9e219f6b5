// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Outputs of `pliant vessel`: measures of each step, frames for ParaView and 3D Slicer, a picture,
// and the log of the hand's motion for replays.

#pragma once

#include <pliant/core/files.h>
#include <pliant/core/output_file.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>
#include <pliant/models/catheter.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pliant::app {

/// Shortest digits that round-trip.
std::string exact(double value);

/// A text file, written atomically.
class TextFile {
  public:
    /// @returns Unwritable
    Status open(const std::string& file, StagedFiles& staged);
    bool is_open() const { return m_out.has_value(); }
    void line(const std::string& text) { m_out->write(text + '\n'); }
    Status close();

  private:
    std::optional<OutputFile> m_out;
};

std::string csv_names();
std::string csv_line(const CatheterMeasures& measures);

/// A folder of frames: wall_….vtu, ghost_….vtp, catheter_….vtp, and a .pvd for each.
class Frames {
  public:
    /// @returns Unwritable
    Status open(const std::string& folder, StagedFiles& staged);
    Status add(const CatheterScene& scene);
    Status close();

  private:
    std::filesystem::path m_folder;
    std::vector<SeriesFile> m_wall, m_ghost, m_catheter;
};

/// Picture of the inner wall, translucent, in the colours of its displacement, and of the catheter
/// in it, from outside. @param path  of a PNG file
Status write_vessel_picture(const std::filesystem::path& path, const CatheterScene& scene);

/// Log of the hand's motion: `step insert rotate bend bend`, one line per change.
struct HandLog {
    struct Line {
        std::int64_t step;
        CatheterCommand command;
    };
    std::vector<Line> lines;
    std::int64_t steps = 0;
    std::uint64_t hash = 0;
};
Status write_log(const std::string& file, const HandLog& log);
Result<HandLog> read_log(const std::string& file);

}  // namespace pliant::app
