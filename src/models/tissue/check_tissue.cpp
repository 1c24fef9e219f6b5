// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Each rule is a function that makes its tissues anew, so that one broken rule doesn't hide in the
// consequences of another one.

#include <pliant/check_tissue.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "base/errors.h"
#include "base/text.h"
#include "tissue/tissue_rules.h"

namespace pliant::rules {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

void check_make(const Subject& subject) {
    const auto tissue = subject.make();
    const TissueTraits traits = tissue->traits();
    expect(!traits.model.empty(), "a name in traits().model", "none");
    expect(traits.sweep_ms >= 0 && traits.sweep_ms < kInfinity, "sweep_ms of 0 or more",
           text_of(traits.sweep_ms));
    expect(traits.update_hz >= 0 && traits.update_hz < kInfinity, "update_hz of 0 or more",
           text_of(traits.update_hz));
    expect(&tissue->deformation() == &tissue->deformation(), "one deformation", "several");
    expect(tissue->deformation().grid().size == tissue->volume().grid.size,
           "a deformation of the scan's grid", text_of_size(tissue->deformation().grid().size));
    expect(!tissue->is_touched() && !tissue->is_touched_by(kTool), "no tool at rest", "one");
    expect(tissue->undo_steps() == 0, "no step to undo", text_of(tissue->undo_steps()));
    expect_error(tissue->undo(), ErrorCode::NotFound, "undo() without a step");
    expect_error(tissue->redo(), ErrorCode::NotFound, "redo() without a step");
    expect(tissue->hash() == tissue->hash(), "the same hash twice", "two");
    expect(tissue->hash() == subject.make()->hash(), "the hash of another tissue at rest",
           "another one");
}

void check_push(const Subject& subject) {
    const auto tissue = subject.make();
    const std::uint64_t at_rest = tissue->hash();
    const PushReport report = subject.push_with(*tissue);
    const double fraction = report.step_fraction;
    const std::string found = std::string(name_of(report.status)) + ", " + text_of(fraction);
    switch (report.status) {
        case PushStatus::Applied:
            expect(fraction == 1, "step_fraction 1, applied", found);
            break;
        case PushStatus::Limited:
            expect(fraction >= 0 && fraction <= 1, "step_fraction 0 to 1, limited", found);
            expect(report.limited_by != LimitedBy::None, "limited_by of a limited push", "none");
            break;
        case PushStatus::Rejected:
            expect(fraction == 0, "step_fraction 0, rejected", found);
            expect(tissue->hash() == at_rest, "the same hash after a rejected push", "another");
    }
    expect(report.grabbed_elements >= 0 && report.moved_elements >= 0, "counts of 0 or more",
           text_of(double(std::min(report.grabbed_elements, report.moved_elements))));
    expect(report.solve_ms >= 0 && report.solve_ms < kInfinity, "solve_ms of 0 or more",
           text_of(report.solve_ms));
    if (report.status == PushStatus::Rejected) return;
    expect(tissue->hash() != at_rest, "another hash after the push", "the same");
    expect(!is_empty(tissue->deformation().moved_box()), "elements of the deformation to move",
           "none (does update_deformation() write them?)");
}

void check_hold(const Subject& subject) {
    const auto tissue = subject.make();
    if (!subject.moves(*tissue)) return;
    expect(tissue->is_touched_by(kTool), "is_touched_by() of the tool that pushed", "false");
    expect(tissue->is_touched(), "is_touched() while a tool holds tissue", "false");
    expect(!tissue->is_touched_by(kOther), "is_touched_by() false of another tool", "true");
    const Vec3i element = most_moved_element(*tissue);
    const Vec3d held = tissue->deformation().displacement_mm(element);
    for (int n = 0; n < kSweeps; ++n) (void)take(tissue->sweep(), "sweep()");
    (void)take(tissue->update_deformation(), "update_deformation()");
    const double left = norm(tissue->deformation().displacement_mm(element));
    expect(left >= 0.5 * norm(held), "held tissue to stay at " + text_of(norm(held)) + " mm",
           text_of(left) + " mm after " + text_of(kSweeps) + " sweeps");
    expect(tissue->is_touched_by(kTool), "the tool's hold to last until its release", "none");
    const std::uint64_t before = tissue->hash();
    tissue->release(kOther);
    expect(tissue->is_touched_by(kTool), "no effect of a release of another tool", "one");
    tissue->release(kTool);
    expect(!tissue->is_touched_by(kTool) && !tissue->is_touched(), "no hold after the release",
           "one");
    expect(tissue->hash() == before, "nothing to move in release()", "another hash");
    tissue->release(kTool);
}

void check_refused(const Subject& subject) {
    const auto tissue = subject.make();
    const Push& good = subject.push();
    std::vector<Push> refused(5, good);
    refused[0].point_mm.x = kNan;
    refused[1].push_mm.y = kInfinity;
    refused[2].push_mm.z = kNan;
    refused[3].sphere_radius_mm = -1;
    refused[4].sphere_radius_mm = kNan;
    const auto check = [&](const char* when) {
        const std::uint64_t before = tissue->hash();
        const bool was_held = tissue->is_touched_by(kTool);
        for (const Push& push : refused) {
            const std::string call = "push() at " + text_of(push.point_mm) + " by " +
                                     text_of(push.push_mm) + " with radius " +
                                     text_of(push.sphere_radius_mm);
            expect_error(tissue->push(kTool, push), ErrorCode::InvalidArgument, call);
            expect(tissue->hash() == before, std::string("the same hash ") + when,
                   "another after a refused " + call);
            expect(tissue->is_touched_by(kTool) == was_held, std::string("the same hold ") + when,
                   "another after a refused " + call);
        }
    };
    check("at rest");
    if (subject.moves(*tissue)) check("of a pushed tissue");
}

void check_group(const Subject& subject) {
    const auto tissue = subject.make();
    tissue->begin_group("nothing");
    expect(tissue->end_group() == 0, "0 from end_group()", "another number");
    expect(tissue->undo_steps() == 0, "no step of a group without a change",
           text_of(tissue->undo_steps()));
    if (!subject.moves_in_group(*tissue)) return;
    expect(tissue->undo_steps() == 1, "one step of a group with a push",
           text_of(tissue->undo_steps()));
    Push back = subject.push();
    back.point_mm = back.point_mm + back.push_mm;
    back.push_mm = -0.5 * back.push_mm;
    tissue->begin_group("two pushes");
    for (int n = 0; n < 2; ++n) (void)tissue->push(kTool, back);  // they may miss the tissue
    tissue->end_group();
    expect(tissue->undo_steps() <= 2, "one step of a group with two pushes",
           text_of(tissue->undo_steps() - 1));
}

void check_undo(const Subject& subject) {
    const auto tissue = subject.make();
    const std::uint64_t at_rest = tissue->hash();
    if (!subject.moves_in_group(*tissue)) return;
    const std::uint64_t pushed = tissue->hash();
    for (int n = 0; n < 2; ++n) {
        (void)take(tissue->undo(), "undo()");
        expect(tissue->hash() == at_rest, "the hash before the push after undo()", "another");
        (void)take(tissue->redo(), "redo()");
        expect(tissue->hash() == pushed, "the hash after the push after redo()", "another");
    }
    expect(tissue->undo_steps() == 1, "one step after undo() and redo()",
           text_of(tissue->undo_steps()));
    (void)take(tissue->undo(), "undo()");
    expect(tissue->undo_steps() == 0, "no step after undo()", text_of(tissue->undo_steps()));
    if (!subject.moves_in_group(*tissue)) return;
    expect_error(tissue->redo(), ErrorCode::NotFound, "redo() after a new step");
}

void check_state(const Subject& subject) {
    const auto tissue = subject.make();
    auto* const nodes = dynamic_cast<NodeTissue*>(tissue.get());
    if (!nodes) return;
    const auto state_of = [](const NodeTissue& of) {
        std::vector<double> numbers;
        of.state(numbers);
        return numbers;
    };
    std::vector<double> at_rest = state_of(*nodes);
    const std::uint64_t hash_at_rest = tissue->hash();
    const auto refuse = [&](const std::vector<double>& numbers, const char* call) {
        const std::uint64_t before = tissue->hash();
        expect_error(nodes->set_state(numbers), ErrorCode::InvalidArgument, call);
        expect(tissue->hash() == before, "the same hash after a refused state", "another");
    };
    std::vector<double> longer = at_rest;
    longer.push_back(0);
    refuse(longer, "set_state() with a number too many");
    refuse(std::vector<double>(std::max<std::size_t>(1, at_rest.size()), kNan),
           "set_state() of numbers that aren't finite");
    if (!subject.moves(*tissue)) return;
    const std::vector<double> pushed = state_of(*nodes);
    const std::uint64_t hash_pushed = tissue->hash();
    expect(pushed != at_rest, "state() to show the push", "that at rest");
    (void)take(nodes->set_state(pushed), "set_state() of the present state");
    expect(tissue->hash() == hash_pushed && state_of(*nodes) == pushed,
           "nothing to change by the present state", "another state");
    expect(!tissue->is_touched(), "set_state() to release the tools", "a hold");
    (void)take(nodes->set_state(at_rest), "set_state() of the state at rest");
    expect(tissue->hash() == hash_at_rest, "the hash at rest of the state at rest", "another");
}

void check_file(const Subject& subject) {
    const StateFile file;
    const auto tissue = subject.make();
    (void)subject.moves_in_group(*tissue);
    tissue->release(kTool);
    const std::uint64_t before = tissue->hash();
    (void)take(tissue->rest(), "rest()");
    expect(tissue->hash() == before, "the same hash after rest()", "another");
    (void)take(tissue->save_state(file.path()), "save_state()");
    expect(tissue->hash() == before, "the same hash after save_state()", "another");
    const auto twin = subject.make();
    (void)take(twin->load_state(file.path()), "load_state()");
    expect(twin->hash() == before, "the hash of the saved tissue after load_state()", "another");
    for (int n = 1; n <= kSweeps; ++n) {
        (void)take(tissue->sweep(), "sweep()");
        (void)take(twin->sweep(), "sweep()");
        expect(twin->hash() == tissue->hash(), "a loaded tissue to go on like the saved one",
               "another hash after sweep " + text_of(n));
    }
    (void)take(tissue->load_state(file.path()), "load_state() into a tissue with a history");
    expect(tissue->hash() == before, "the hash of the saved state after load_state()", "another");
    expect(tissue->undo_steps() == 0, "no history after load_state()",
           text_of(tissue->undo_steps()));
    const std::uint64_t moved = twin->hash();
    file.damage();
    expect_error(twin->load_state(file.path()), ErrorCode::Unreadable,
                 "load_state() of a damaged file");
    expect(!twin->load_state(file.path() + "_missing").ok(), "an error of a missing file", "none");
    expect(twin->hash() == moved, "the same hash after a refused file", "another");
}

void check_sweep(const Subject& subject) {
    const auto tissue = subject.make();
    const std::uint64_t at_rest = tissue->hash();
    const Sweep idle = take(tissue->sweep(), "sweep() at rest");
    expect(idle.ms >= 0, "a time of 0 or more", text_of(idle.ms));
    expect(tissue->hash() == at_rest, "tissue at rest to stay there", "another hash");
    if (!subject.moves(*tissue)) return;
    tissue->release(kTool);
    for (int n = 0; n < kSweeps; ++n) {
        const bool settled = take(tissue->sweep(), "sweep()").settled;
        const std::uint64_t before = tissue->hash();
        const Sweep next = take(tissue->sweep(), "sweep()");
        if (settled)
            expect(next.settled && tissue->hash() == before, "no effect of sweeps once settled",
                   "another hash");
    }
}

void check_advance(const Subject& subject) {
    const auto whole = subject.make(), parts = subject.make();
    for (Tissue* tissue : {whole.get(), parts.get()}) {
        (void)subject.moves(*tissue);
        tissue->release(kTool);
    }
    const std::uint64_t before = whole->hash();
    const auto none = take(whole->advance({.max_steps = 0}), "advance() by no step");
    expect(none.steps == 0 && whole->hash() == before, "no step for max_steps 0",
           text_of(double(none.steps)));
    const auto late = take(whole->advance({.max_ms = 0}), "advance() without time");
    expect(late.steps <= 1, "one step at most for max_ms 0", text_of(double(late.steps)));
    for (std::int64_t n = 0; n < late.steps; ++n)
        (void)take(parts->advance({.max_steps = 1}), "advance()");
    const auto report = take(whole->advance({.max_steps = kSweeps}), "advance()");
    expect(report.steps >= 0 && report.steps <= kSweeps, "max_steps to be kept",
           text_of(double(report.steps)));
    expect(report.ms >= 0, "a time of 0 or more", text_of(report.ms));
    for (std::int64_t n = 0; n < report.steps; ++n)
        (void)take(parts->advance({.max_steps = 1}), "advance()");
    expect(whole->hash() == parts->hash(), "the same state of as many single steps", "another");
}

void check_drag(const Subject& subject) {
    const auto tissue = subject.make();
    expect_error(tissue->drag_to({0, 0, 0}), ErrorCode::InvalidArgument, "drag_to() without grab");
    const std::uint64_t at_rest = tissue->hash();
    if (!subject.moves(*subject.make())) return;
    const Push& push = subject.push();
    const auto grabbed = take(tissue->grab(kTool, push, norm(push.push_mm)), "grab()");
    expect(grabbed.grabbed_elements > 0, "grab() to hold what push() moves",
           "nothing: " + grabbed.message);
    expect(tissue->hash() == at_rest, "nothing to move in grab()", "another hash");
    const auto there = take(tissue->drag_to(push.push_mm), "drag_to()");
    expect(there.step_fraction >= 0 && there.step_fraction <= 1, "step_fraction 0 to 1",
           text_of(there.step_fraction));
    expect(tissue->hash() != at_rest, "drag_to() to move what push() moves", "the same hash");
    tissue->let_go();
    expect(!tissue->is_touched(), "no hold after let_go()", "one");
    expect_error(tissue->drag_to({0, 0, 0}), ErrorCode::InvalidArgument,
                 "drag_to() after let_go()");
}

void check_threads(const Subject& subject) {
    std::vector<std::uint64_t> first;
    for (int n = 0; n < 3; ++n) {
        const auto tissue = subject.make();
        std::vector<std::uint64_t> hashes;
        (void)subject.moves(*tissue);
        hashes.push_back(tissue->hash());
        for (int k = 0; k < kSweeps / 2; ++k) (void)take(tissue->sweep(), "sweep()");
        hashes.push_back(tissue->hash());
        tissue->release(kTool);
        for (int k = 0; k < kSweeps / 2; ++k) (void)take(tissue->sweep(), "sweep()");
        hashes.push_back(tissue->hash());
        if (n == 0) first = hashes;
        expect(hashes == first, "the same hashes of tissues with the same calls", "others");
    }
}

void check_force(const Subject& subject) {
    const auto tissue = subject.make();
    const auto check = [&](std::uint32_t tool, bool may_push) {
        const auto force = tissue->force_n(tool);
        if (!force) return;
        const double size = norm(*force);
        expect(size < kInfinity, "a finite force", text_of(*force));
        expect(may_push || size == 0, "no force on a tool that holds nothing", text_of(*force));
    };
    check(kTool, false);
    const bool moved = subject.moves(*tissue);
    const std::uint64_t before = tissue->hash();
    check(kTool, moved);
    check(kOther, false);
    expect(tissue->hash() == before, "nothing to move in force_n()", "another hash");
}

void check_capabilities(const Subject& subject) {
    const auto tissue = subject.make();
    const TissueTraits traits = tissue->traits();
    const Push& push = subject.push();
    const std::uint64_t at_rest = tissue->hash();
    Push way = push;
    way.sphere_radius_mm = std::max(1.0, way.sphere_radius_mm);
    const Vec3d along = push.push_mm.x == 0 ? Vec3d{3, 0, 0} : Vec3d{0, 3, 0};
    const CutSurface surface{.line_mm = {push.point_mm - along, push.point_mm + along},
                             .depth_mm = push.push_mm};
    const CarveTool carve{.from_mm = push.point_mm, .to_mm = push.point_mm, .radius_mm = 2};
    const auto check = [&](bool can, const auto& result, const std::string& call) {
        if (!can) {
            expect_error(result, ErrorCode::Unsupported, call + ", which traits() exclude");
            expect(tissue->hash() == at_rest, "no effect of an unsupported " + call,
                   "another hash");
        } else {
            expect(result.ok() || result.error().code != ErrorCode::Unsupported,
                   call + ", which traits() have", result.ok() ? "" : result.error().message);
        }
    };
    check(traits.slides, subject.make()->slide(kTool, way, {}), "slide()");
    check(traits.cuts, subject.make()->cut(surface), "cut()");
    check(traits.carves, subject.make()->carve(carve), "carve()");
    expect(!traits.has_energy || tissue->energy_mm2().has_value(), "an energy, as of traits()",
           "none");
    const PushReport report = subject.push_with(*tissue);
    expect(traits.takes_pushes || report.status == PushStatus::Rejected,
           "pushes to be rejected, as of traits()", std::string(name_of(report.status)));
}

void check_settings(const Subject& subject) {
    const auto tissue = subject.make();
    (void)subject.moves(*tissue);
    const std::uint64_t before = tissue->hash();
    const Record settings = tissue->settings();
    expect(!tissue->configure({{"no_such_setting", 1}}).ok(), "an error of an unknown setting",
           "none");
    expect(tissue->settings() == settings, "the same settings after a refused change", "others");
    if (!settings.empty()) (void)take(tissue->configure(settings), "configure() with settings()");
    expect(tissue->settings() == settings, "the settings that were set", "others");
    expect(tissue->hash() == before, "nothing to move by the same settings", "another hash");
}

void check_reset(const Subject& subject) {
    const auto tissue = subject.make();
    const std::uint64_t at_rest = tissue->hash();
    (void)subject.moves(*tissue);
    (void)take(tissue->sweep(), "sweep()");
    (void)take(tissue->reset(), "reset()");
    expect(tissue->hash() == at_rest, "the hash at rest after reset()", "another");
    (void)take(tissue->update_deformation(), "update_deformation()");
    expect(is_empty(tissue->deformation().moved_box()), "no moved element after reset()", "some");
}

struct Rule {
    std::string_view name;
    void (*check)(const Subject&);
};
constexpr Rule kRules[] = {{"make", &check_make},         {"push", &check_push},
                           {"hold", &check_hold},         {"refused", &check_refused},
                           {"group", &check_group},       {"undo", &check_undo},
                           {"state", &check_state},       {"file", &check_file},
                           {"sweep", &check_sweep},       {"advance", &check_advance},
                           {"drag", &check_drag},         {"threads", &check_threads},
                           {"force", &check_force},       {"capabilities", &check_capabilities},
                           {"settings", &check_settings}, {"reset", &check_reset}};

}  // namespace
}  // namespace pliant::rules

namespace pliant {

Status check_tissue(const MakeAnother& make, const Push& push) noexcept {
    return attempt([&]() -> Status {
        const rules::Subject subject(make, push);
        for (const rules::Rule& rule : rules::kRules) {
            try {
                rule.check(subject);
            } catch (const rules::Broken& broken) {
                return expected_error(std::string(rule.name), broken.expected, broken.found);
            }
        }
        return Ok{};
    });
}

Status check_tissue(const MakeTissue& make, const Volume& scan, const Push& push) noexcept {
    return attempt([&]() -> Status {
        const std::array<TaskArena, 3> arenas{TaskArena(1), TaskArena(2), TaskArena(4)};
        std::size_t count = 0;
        const MakeAnother another = [&]() -> Result<std::shared_ptr<Tissue>> {
            auto made = make(scan, arenas[count++ % arenas.size()]);
            if (!made) return made.error();
            return std::shared_ptr<Tissue>(std::move(made).value());
        };
        return check_tissue(another, push);
    });
}

std::span<const std::string_view> tissue_rules() noexcept {
    static constexpr auto kNames = [] {
        std::array<std::string_view, std::size(rules::kRules)> names{};
        for (std::size_t n = 0; n < names.size(); ++n) names[n] = rules::kRules[n].name;
        return names;
    }();
    return kNames;
}

}  // namespace pliant
