// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// check_tissue() finds each broken rule in a tissue that is right without it.
// Covers: tissue/tissue_rules.cpp.

#include <gtest/gtest.h>
#include <pliant/check_tissue.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace pliant::test {
namespace {

enum class Fault {
    None,
    DiffersAtRest,
    HasAStepAtRest,
    AppliedWithoutFraction,
    LimitedByNothing,
    RejectedButMoved,
    NotWritten,
    ForgetsTheTool,
    DecaysWhileHeld,
    ReleaseMoves,
    ReleasesOthers,
    TakesNaN,
    TakesNegativeRadii,
    RefusedButMoved,
    StepOfNothing,
    StateWithoutShift,
    TakesAnyState,
    StateKeepsTools,
    VelocityIsNotInTheState,
    RestMoves,
    SettledButMoves,
    MovesAtRest,
    OneStepMore,
    StepsAreNotSweeps,
    GrabMoves,
    KeepsTheDrag,
    DependsOnTheCount,
    ForceOnEveryTool,
    NoNumberAsForce,
    SlidesInTraitsOnly,
    CutsInSecret,
    TakesAnySetting,
    ResetLeavesHalf,
};

int g_toys = 0;

/// A bump that a tool drags along.
class Toy : public NodeTissue {
  public:
    Toy(const Volume& scan, const TaskArena& arena, Fault fault)
        : m_scan(scan),
          m_arena(arena),
          m_fault(fault),
          m_deformation(Deformation::create(scan.grid).value()),
          m_number(g_toys++) {
        if (is(Fault::DiffersAtRest) && m_number % 2 == 1) m_shift.x = 1, m_is_written = false;
    }
    const Volume& volume() const override { return m_scan; }
    const TaskArena& arena() const override { return m_arena; }
    const Deformation& deformation() const override { return m_deformation; }
    Status update_deformation() const override {
        if (m_is_written || is(Fault::NotWritten)) return Ok{};
        m_is_written = true;
        m_deformation.reset();
        const Vec3i c{int(std::lround(m_centre.x)), int(std::lround(m_centre.y)),
                      int(std::lround(m_centre.z))};
        return m_deformation.displace({c - Vec3i{2, 2, 2}, c + Vec3i{3, 3, 3}}, [&](Vec3i e) {
            const Vec3d d = Vec3d{e.x * 1.0, e.y * 1.0, e.z * 1.0} - m_centre;
            return std::exp(-dot(d, d)) * m_shift;
        });
    }
    TissueTraits traits() const noexcept override {
        return {.model = "toy", .slides = is(Fault::SlidesInTraitsOnly), .moves_by_itself = true};
    }
    Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept override {
        const bool is_right = norm(push.point_mm) < 1e3 && norm(push.push_mm) < 100;
        if ((!is_right && !is(Fault::TakesNaN)) ||
            (!(push.sphere_radius_mm >= 0) && !is(Fault::TakesNegativeRadii))) {
            if (is(Fault::RefusedButMoved)) move({4, 4, 4}, {0.5, 0, 0});
            return Error{ErrorCode::InvalidArgument, "push: expected a push"};
        }
        if (is_right) move(push.point_mm, m_shift + push.push_mm);
        m_velocity = 0.1;
        if (!is(Fault::ForgetsTheTool)) m_tools.insert(tool);
        PushReport report{.status = PushStatus::Applied, .step_fraction = 1, .message = {}};
        report.grabbed_elements = 1;
        if (is(Fault::AppliedWithoutFraction)) report.step_fraction = 0;
        if (is(Fault::LimitedByNothing)) report.status = PushStatus::Limited;
        if (is(Fault::RejectedButMoved)) {
            report.status = PushStatus::Rejected;
            report.step_fraction = 0;
        }
        return report;
    }
    Result<GrabReport> grab(std::uint32_t tool, const Push& place,
                            double reach_mm) noexcept override {
        auto report = NodeTissue::grab(tool, place, reach_mm);
        if (is(Fault::GrabMoves)) move(m_centre, {1, 0, 0});
        return report;
    }
    void let_go() noexcept override {
        if (!is(Fault::KeepsTheDrag)) NodeTissue::let_go();
    }
    void release(std::uint32_t tool) noexcept override {
        if (is(Fault::ReleasesOthers)) m_tools.clear();
        if (m_tools.erase(tool) > 0 && is(Fault::ReleaseMoves)) move(m_centre, 0.5 * m_shift);
    }
    bool is_touched_by(std::uint32_t tool) const noexcept override {
        return m_tools.contains(tool);
    }
    bool is_touched() const noexcept override { return !m_tools.empty(); }
    std::optional<Vec3d> force_n(std::uint32_t tool) noexcept override {
        if (is(Fault::NoNumberAsForce)) return Vec3d{std::nan(""), 0, 0};
        return is_touched_by(tool) || is(Fault::ForceOnEveryTool) ? Vec3d{1, 0, 0} : Vec3d{};
    }
    Result<CutReport> cut(const CutSurface& surface) noexcept override {
        if (is(Fault::CutsInSecret)) return CutReport{};
        return NodeTissue::cut(surface);
    }
    Result<Sweep> sweep() noexcept override {
        if (is(Fault::MovesAtRest)) move(m_centre, m_shift + Vec3d{0.1, 0, 0});
        if (is(Fault::DependsOnTheCount) && is_touched())
            move(m_centre, m_shift + Vec3d{0, 1e-3 * (m_number % 7), 0});
        if ((is_touched() && !is(Fault::DecaysWhileHeld)) || norm(m_shift) == 0) return Sweep{};
        move(m_centre, norm(m_shift) < 1e-3 ? Vec3d{} : (0.9 - m_velocity) * m_shift);
        m_velocity *= 0.5;
        return Sweep{.settled = is(Fault::SettledButMoves), .message = {}};
    }
    Result<AdvanceReport> advance(const Budget& budget) noexcept override {
        Budget used = budget;
        if (is(Fault::OneStepMore)) ++used.max_steps;
        auto report = NodeTissue::advance(used);
        if (is(Fault::StepsAreNotSweeps) && report->steps > 0) move(m_centre, 0.99 * m_shift);
        return report;
    }
    Status reset() noexcept override {
        move(m_centre, is(Fault::ResetLeavesHalf) ? 0.5 * m_shift : Vec3d{});
        m_tools.clear();
        return Ok{};
    }
    Record settings() const override { return {{"stiffness", 1.0}}; }
    Status configure(const Record& changes) noexcept override {
        for (const NamedValue& change : changes)
            if (change.name != "stiffness" && !is(Fault::TakesAnySetting))
                return Error{ErrorCode::InvalidArgument, "expected stiffness"};
        return Ok{};
    }
    Status rest() noexcept override {
        if (is(Fault::RestMoves)) move(m_centre, 0.5 * m_shift);
        return NodeTissue::rest();
    }
    int undo_steps() const noexcept override {
        return NodeTissue::undo_steps() + is(Fault::HasAStepAtRest);
    }
    void state(std::vector<double>& n) const override {
        n = {m_centre.x, m_centre.y, m_centre.z, m_shift.x, m_shift.y, m_shift.z, m_velocity};
        if (is(Fault::StateWithoutShift)) n[3] = n[4] = n[5] = 0;
        if (is(Fault::VelocityIsNotInTheState)) n[6] = 0;
        if (is(Fault::StepOfNothing)) n[6] = 1e-9 * ++m_calls;
    }
    Status set_state(std::span<const double> n) noexcept override {
        const bool is_right = n.size() == 7 && std::all_of(n.begin(), n.end(), [](double x) {
                                  return std::isfinite(x);
                              });
        if (!is_right && is(Fault::TakesAnyState)) return Ok{};
        if (!is_right) return Error{ErrorCode::InvalidArgument, "expected seven numbers"};
        move({n[0], n[1], n[2]}, {n[3], n[4], n[5]});
        if (!is(Fault::VelocityIsNotInTheState)) m_velocity = n[6];
        if (!is(Fault::StateKeepsTools)) m_tools.clear();
        return Ok{};
    }

  private:
    bool is(Fault fault) const { return m_fault == fault; }
    void move(Vec3d centre, Vec3d shift) {
        m_is_written = m_is_written && centre == m_centre && shift == m_shift;
        m_centre = centre;
        m_shift = shift;
    }

    const Volume& m_scan;
    const TaskArena& m_arena;
    const Fault m_fault;
    mutable Deformation m_deformation;
    mutable bool m_is_written = true;
    mutable int m_calls = 0;
    int m_number;
    Vec3d m_centre{0, 0, 0}, m_shift{0, 0, 0};
    double m_velocity = 0;
    std::set<std::uint32_t> m_tools;
};

Volume toy_scan() {
    Volume scan;
    scan.grid = {{12, 12, 12}, {1, 1, 1}};
    scan.voxels = std::vector<std::int16_t>(12 * 12 * 12, 40);
    return scan;
}

const Push kToyPush{.point_mm = {6, 6, 6}, .push_mm = {2, 0, 0}};

/// Name of the first broken rule; empty: none.
std::string broken_rule(Fault fault) {
    const Volume scan = toy_scan();
    const MakeTissue make = [&](const Volume& of, const TaskArena& arena) {
        return Result<std::unique_ptr<Tissue>>(std::make_unique<Toy>(of, arena, fault));
    };
    const Status kept = check_tissue(make, scan, kToyPush);
    if (kept.ok()) return "";
    EXPECT_NE(kept.error().message.find(": expected "), std::string::npos);
    EXPECT_NE(kept.error().message.find(", found "), std::string::npos) << kept.error().message;
    return kept.error().field;
}

TEST(CheckTissue, FindsEachBrokenRule) {
    EXPECT_EQ(broken_rule(Fault::None), "");
    const std::vector<std::pair<Fault, std::string>> faults{
        {Fault::DiffersAtRest, "make"},
        {Fault::HasAStepAtRest, "make"},
        {Fault::AppliedWithoutFraction, "push"},
        {Fault::LimitedByNothing, "push"},
        {Fault::RejectedButMoved, "push"},
        {Fault::NotWritten, "push"},
        {Fault::ForgetsTheTool, "hold"},
        {Fault::DecaysWhileHeld, "hold"},
        {Fault::ReleaseMoves, "hold"},
        {Fault::ReleasesOthers, "hold"},
        {Fault::TakesNaN, "refused"},
        {Fault::TakesNegativeRadii, "refused"},
        {Fault::RefusedButMoved, "refused"},
        {Fault::StepOfNothing, "group"},
        {Fault::StateWithoutShift, "undo"},
        {Fault::TakesAnyState, "state"},
        {Fault::StateKeepsTools, "state"},
        {Fault::VelocityIsNotInTheState, "file"},
        {Fault::RestMoves, "file"},
        {Fault::SettledButMoves, "sweep"},
        {Fault::MovesAtRest, "sweep"},
        {Fault::OneStepMore, "advance"},
        {Fault::StepsAreNotSweeps, "advance"},
        {Fault::GrabMoves, "drag"},
        {Fault::KeepsTheDrag, "drag"},
        {Fault::DependsOnTheCount, "threads"},
        {Fault::ForceOnEveryTool, "force"},
        {Fault::NoNumberAsForce, "force"},
        {Fault::SlidesInTraitsOnly, "capabilities"},
        {Fault::CutsInSecret, "capabilities"},
        {Fault::TakesAnySetting, "settings"},
        {Fault::ResetLeavesHalf, "reset"},
    };
    std::set<std::string> found;
    for (const auto& [fault, rule] : faults) {
        EXPECT_EQ(broken_rule(fault), rule) << "fault " << int(fault);
        found.insert(rule);
    }
    // Each fault is tried, and each rule has one.
    EXPECT_EQ(faults.size(), std::size_t(Fault::ResetLeavesHalf));
    for (const std::string_view rule : tissue_rules())
        EXPECT_TRUE(found.contains(std::string(rule))) << rule;
}

TEST(CheckTissue, NamesAFailedMaker) {
    const MakeAnother none = [] { return std::shared_ptr<Tissue>(); };
    EXPECT_EQ(check_tissue(none, kToyPush).error().field, "make");
    const MakeAnother failing = []() -> Result<std::shared_ptr<Tissue>> {
        return Error{ErrorCode::NotFound, "no such scan"};
    };
    const Status failed = check_tissue(failing, kToyPush);
    EXPECT_NE(failed.error().message.find("no such scan"), std::string::npos);
}

}  // namespace
}  // namespace pliant::test
