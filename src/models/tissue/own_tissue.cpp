// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/own_tissue.h>

#include <exception>
#include <new>
#include <stdexcept>
#include <string>

namespace pliant {
namespace {

Error error_of(const char* name, const char* text) noexcept {
    const Result<Ok> composed = attempt([&]() -> Status {
        return Error{ErrorCode::InvalidArgument, std::string(name) + ": " + text, name};
    });
    return composed.error();
}

/// Converts every exception to an error.
template <class Call>
auto caught(const char* name, const Call& call) noexcept -> decltype(call()) {
    try {
        return call();
    } catch (const std::bad_alloc&) {
        return out_of_memory();
    } catch (const std::length_error&) {  // thrown by a container beyond its size limit
        return out_of_memory();
    } catch (const std::exception& thrown) {
        return error_of(name, thrown.what());
    } catch (...) {
        return error_of(name, "expected an exception with a text");
    }
}

}  // namespace

/// Runs a call that may change the tissue. After an error the state is the one before.
template <class Call>
auto OwnTissue::guarded(const char* name, const Call& call) noexcept -> decltype(call()) {
    const Status kept = caught(name, [&]() -> Status {
        state(m_kept);
        m_left.reserve(m_kept.size());
        return Ok{};
    });
    if (!kept.ok()) return kept.error();
    auto result = caught(name, call);
    if (result.ok()) return result;
    const Status same = caught(name, [&]() -> Status {
        state(m_left);
        return m_left == m_kept ? Status(Ok{}) : Status(result.error());
    });
    if (!same.ok()) (void)caught(name, [&] { return do_set_state(m_kept); });
    return result;
}

Result<PushReport> OwnTissue::push(std::uint32_t tool, const Push& push) noexcept {
    return guarded("push", [&] { return do_push(tool, push); });
}

Result<GrabReport> OwnTissue::grab(std::uint32_t tool, const Push& position,
                                   double reach_mm) noexcept {
    return guarded("grab", [&] { return do_grab(tool, position, reach_mm); });
}

Result<PushReport> OwnTissue::drag_to(Vec3d offset_mm) noexcept {
    return guarded("drag", [&] { return do_drag_to(offset_mm); });
}

Result<SlideReport> OwnTissue::slide(std::uint32_t tool, const Push& way,
                                     const TissueValues& tissue_values) noexcept {
    return guarded("slide", [&] { return do_slide(tool, way, tissue_values); });
}

Result<CutReport> OwnTissue::cut(const CutSurface& surface) noexcept {
    return guarded("cut", [&] { return do_cut(surface); });
}

Result<CarveReport> OwnTissue::carve(const CarveTool& tool) noexcept {
    return guarded("carve", [&] { return do_carve(tool); });
}

std::optional<Vec3d> OwnTissue::force_n(std::uint32_t tool) noexcept try {
    return do_force_n(tool);
} catch (...) {
    return {};
}

Result<Sweep> OwnTissue::sweep() noexcept {
    return guarded("sweep", [&] { return do_sweep(); });
}

Status OwnTissue::reset() noexcept {
    return guarded("reset", [&] { return do_reset(); });
}

Status OwnTissue::configure(const Record& changes) noexcept {
    return guarded("settings", [&] { return do_configure(changes); });
}

Status OwnTissue::set_state(std::span<const double> numbers) noexcept {
    return guarded("state", [&] { return do_set_state(numbers); });
}

Result<GrabReport> OwnTissue::do_grab(std::uint32_t tool, const Push& position, double reach_mm) {
    return NodeTissue::grab(tool, position, reach_mm);
}

Result<PushReport> OwnTissue::do_drag_to(Vec3d offset_mm) {
    return NodeTissue::drag_to(offset_mm);
}

std::optional<Vec3d> OwnTissue::do_force_n(std::uint32_t tool) {
    return NodeTissue::force_n(tool);
}

Result<SlideReport> OwnTissue::do_slide(std::uint32_t tool, const Push& way,
                                        const TissueValues& tissue_values) {
    return NodeTissue::slide(tool, way, tissue_values);
}

Result<CutReport> OwnTissue::do_cut(const CutSurface& surface) {
    return NodeTissue::cut(surface);
}

Result<CarveReport> OwnTissue::do_carve(const CarveTool& tool) {
    return NodeTissue::carve(tool);
}

Status OwnTissue::do_configure(const Record& changes) {
    return NodeTissue::configure(changes);
}

}  // namespace pliant
