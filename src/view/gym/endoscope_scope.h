// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One endoscope of an arena: its tip and its tissue.

#pragma once

#include <pliant/data/gym.h>
#include <pliant/own_tissue.h>

#include <memory>
#include <optional>
#include <vector>

namespace pliant {

/// The parts that all endoscopes of an arena share.
struct ArenaScan {
    ArenaScan(const Volume& v, const EndoscopeArenaSettings& s, const TaskArena& t)
        : volume(v), settings(s), threads(t), rest(v, t) {}

    const Volume& volume;
    EndoscopeArenaSettings settings;
    const TaskArena& threads;
    TaskArena one{HostJobs{}};  ///< a tissue's own loops: the endoscopes are the parallel part
    RayCaster rest;             ///< of the scan at rest
};

class Scope {
  public:
    static Result<std::unique_ptr<Scope>> create(const ArenaScan& scan);

    // After LimitExceeded, follow() may have to bring the deformed scan up to date.

    /// @returns InvalidArgument, with nothing changed; LimitExceeded, with the scope placed
    Status place(const EndoscopePose& pose);
    /// @returns LimitExceeded, with the tip where it was; tissue has moved or not
    Status step(const double* action);
    /// @returns InvalidArgument, with nothing changed; LimitExceeded, tissue has moved or not
    Result<PushReport> push(const Push& push);
    Status save(std::vector<std::byte>& bytes) const;
    /// @returns Unreadable, Unwritable or InvalidArgument, with nothing changed; LimitExceeded, and
    ///          the state has been loaded or not
    Status load(std::span<const std::byte> bytes);
    /// Brings the deformed scan up to date. @returns LimitExceeded
    Status follow();

    const EndoscopeState& state() const { return m_state; }
    const Volume& volume() const { return m_live ? m_live->volume() : m_scan.volume; }
    const RayCaster& rays() const { return m_rays ? *m_rays : m_scan.rest; }
    /// Null: rigid.
    const Tissue* tissue() const { return m_tissue.get(); }
    Endoscope camera() const;
    std::uint64_t hash() const;

  private:
    explicit Scope(const ArenaScan& scan) : m_scan(scan) {}

    bool is_free(Vec3d position_mm) const;
    void turn(const double* action);
    Vec3d end_in_scan(Vec3d end_mm) const;
    Status push_through(Vec3d wanted_mm);
    Status push_elastic(Vec3d wanted_mm);
    Status slide(Vec3d wanted_mm);
    void slide_along(Vec3d wanted_mm);
    Status advance(const double* action);
    bool is_time_to_settle() const;
    void feel(Vec3d wanted_mm);
    void measure();

    const ArenaScan& m_scan;
    std::unique_ptr<Tissue> m_tissue;
    NodeTissue* m_elastic = nullptr;  ///< m_tissue, if it is the elastic scan
    std::vector<double> m_before;     ///< its state before a step
    std::optional<LiveDeformation> m_live;
    std::optional<RayCaster> m_rays;
    EndoscopeState m_state;
    std::uint64_t m_seen_version = 0;  ///< of the deformation at the last update of the volume
    bool m_rays_are_behind = false;    ///< the rays lack changes of the volume
};

}  // namespace pliant
