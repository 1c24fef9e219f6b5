// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tissues of one's own: a class of Python that derives from pliant.Tissue has the methods of a
// NodeTissue, and is pushed, resampled, saved and taken back like the library's own.

#include "own_tissue.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

namespace pliant::python {

Error error_of(const char* method, nb::python_error& raised) {
    const nb::object kind = nb::module_::import_("pliant._error").attr("Error");
    std::string text = shown(nb::borrow(raised.value()));
    if (!raised.matches(kind)) text = shown(raised.type().attr("__name__")) + ": " + text;
    return {ErrorCode::InvalidArgument, std::string(method) + ": " + text, method};
}

namespace {

class PythonTissue final : public NodeTissue {
  public:
    PythonTissue(nb::handle self, const Volume& scan, const TaskArena& arena, Deformation rest)
        : m_self(self), m_scan(scan), m_arena(arena), m_deformation(std::move(rest)) {
        m_model = text_of("model", shown(self.type().attr("__name__")));
        m_traits = {.model = m_model,
                    .moves_by_itself = is_overridden("sweep"),
                    .sweep_ms = number_of("sweep_ms"),
                    .update_hz = number_of("update_hz")};
    }

    Deformation& own_deformation() { return m_deformation; }

    const Volume& volume() const override { return m_scan; }
    const TaskArena& arena() const override { return m_arena; }
    const Deformation& deformation() const override { return m_deformation; }
    TissueTraits traits() const noexcept override { return m_traits; }

    Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept override {
        auto result = called<PushReport>(
            "push",
            [](const nb::object& report) {
                return report.is_none() ? PushReport{.status = PushStatus::Applied,
                                                     .step_fraction = 1,
                                                     .message = {}}
                                        : nb::cast<PushReport>(report);
            },
            push.point_mm, push.push_mm, push.sphere_radius_mm, tool);
        if (!result.ok() || is_touched_by(tool)) return result;
        try {
            m_tools.push_back(tool);
        } catch (const std::bad_alloc&) {
            return Error{ErrorCode::LimitExceeded, "out of memory"};
        }
        return result;
    }
    void release(std::uint32_t tool) noexcept override {
        std::erase(m_tools, tool);
        const nb::gil_scoped_acquire lock;
        if (is_overridden("release")) (void)called<bool>("release", &is_done, tool);
    }
    bool is_touched_by(std::uint32_t tool) const noexcept override {
        return std::find(m_tools.begin(), m_tools.end(), tool) != m_tools.end();
    }
    bool is_touched() const noexcept override { return !m_tools.empty(); }
    std::optional<Vec3d> force_n(std::uint32_t tool) noexcept override {
        const nb::gil_scoped_acquire lock;
        if (!is_overridden("force_n")) return {};
        const auto force = called<std::optional<Vec3d>>(
            "force_n",
            [](const nb::object& f) {
                return f.is_none() ? std::nullopt : std::optional(nb::cast<Vec3d>(f));
            },
            tool);
        return force.ok() ? *force : std::nullopt;
    }
    Result<Sweep> sweep() noexcept override {
        if (!m_traits.moves_by_itself) return Sweep{};
        const auto settled = called<bool>(
            "sweep", [](const nb::object& s) { return s.is_none() || nb::cast<bool>(s); });
        if (!settled.ok()) return settled.error();
        return Sweep{.settled = *settled, .message = {}};
    }
    Status reset() noexcept override { return done("reset"); }

    void state(std::vector<double>& numbers) const override {
        auto found = found_state();
        if (!found.ok()) throw std::bad_alloc();  // callers have tried it before, see below
        numbers = std::move(*found);
    }
    Status set_state(std::span<const double> numbers) noexcept override {
        m_tools.clear();
        const nb::gil_scoped_acquire lock;
        nb::list list;
        for (const double number : numbers) list.append(number);
        return done("set_state", nb::module_::import_("numpy").attr("array")(list));
    }

    // An error of the object's state() is that of the call.
    void begin_group(const std::string& name) override {
        if (const auto found = found_state(); !found.ok()) raise(found.error());
        NodeTissue::begin_group(name);
    }
    Status undo() noexcept override {
        const auto found = found_state();
        return found.ok() ? NodeTissue::undo() : found.error();
    }
    Status redo() noexcept override {
        const auto found = found_state();
        return found.ok() ? NodeTissue::redo() : found.error();
    }
    Status save_state(const std::string& path) const noexcept override {
        const auto found = found_state();
        return found.ok() ? NodeTissue::save_state(path) : found.error();
    }

  private:
    Result<std::vector<double>> found_state() const {
        return called<std::vector<double>>(
            "state", [](const nb::object& s) { return numbers_of(std::optional(s), "state"); });
    }
    static bool is_done(const nb::object&) { return true; }

    /// Whether the object's class has a method that pliant.Tissue doesn't have, or another one.
    /// @pre the interpreter's lock is held
    bool is_overridden(const char* method) const {
        const nb::object none = nb::none();
        const nb::object base = nb::module_::import_("pliant._core").attr("Tissue");
        const nb::object own = nb::getattr(m_self.type(), method, none);
        return !own.is_none() && !own.is(nb::getattr(base, method, none));
    }
    std::string text_of(const char* name, const std::string& otherwise) const {
        return is_overridden(name) ? nb::cast<std::string>(m_self.attr(name)) : otherwise;
    }
    double number_of(const char* name) const {
        return is_overridden(name) ? nb::cast<double>(m_self.attr(name)) : 0;
    }

    /// Calls a method of the object. @param from  makes the result from that of the method
    template <class T, class From, class... Arguments>
    Result<T> called(const char* method, const From& from, const Arguments&... arguments) const {
        const nb::gil_scoped_acquire lock;
        try {
            if (!is_overridden(method))
                return Error{ErrorCode::Unsupported,
                             std::string(method) + ": expected " +
                                 shown(m_self.type().attr("__name__")) + " to have this method",
                             method};
            return T(from(m_self.attr(method)(arguments...)));
        } catch (nb::python_error& raised) {
            return error_of(method, raised);
        } catch (const std::exception& error) {
            return Error{ErrorCode::InvalidArgument,
                         std::string(method) + ": unexpected result (" + error.what() + ")",
                         method};
        }
    }
    template <class... Arguments>
    Status done(const char* method, const Arguments&... arguments) const {
        const auto result = called<bool>(method, &is_done, arguments...);
        if (!result.ok()) return result.error();
        return Ok{};
    }

    nb::handle m_self;
    const Volume& m_scan;
    const TaskArena& m_arena;
    Deformation m_deformation;
    std::string m_model;
    TissueTraits m_traits;
    std::vector<std::uint32_t> m_tools;  ///< that have pushed, and weren't released
};

}  // namespace

std::unique_ptr<Tissue> make_own_tissue(nb::handle self, const Volume& scan,
                                        const TaskArena& arena) {
    return std::make_unique<PythonTissue>(self, scan, arena, take(Deformation::create(scan.grid)));
}

void displace_own(Tissue& tissue, Vec3d first, const nb::object& displacements_mm) {
    constexpr double kFarthest = 1e6;
    Vec3i begin;
    for (int a = 0; a < 3; ++a) {
        if (!(std::abs(first[a]) <= kFarthest) || first[a] != std::floor(first[a]))
            raise_value("first", "three whole numbers up to 1000000", nb::cast(first));
        begin[a] = int(first[a]);
    }
    auto* const own = dynamic_cast<PythonTissue*>(&tissue);
    if (!own) raise({ErrorCode::Unsupported, "displace: expected a tissue of a class of your own"});
    const nb::object array = array_in(displacements_mm, "displacements_mm", "float64");
    nb::ndarray<const double, nb::ndim<4>, nb::c_contig, nb::device::cpu> values;
    if (!nb::try_cast(array, values) || values.shape(3) != 3)
        raise({ErrorCode::InvalidArgument,
               "displacements_mm: expected an array (k, j, i, 3), found one of shape " +
                   shown(array.attr("shape")),
               "displacements_mm", "an array (k, j, i, 3)", shown(array.attr("shape"))});
    const Vec3i size{int(values.shape(2)), int(values.shape(1)), int(values.shape(0))};
    static_assert(sizeof(Vec3d) == 3 * sizeof(double));
    const auto* const from = reinterpret_cast<const Vec3d*>(values.data());
    const std::span<const Vec3d> vectors(from, values.size() / 3);
    const Status written = [&] {
        const nb::gil_scoped_release without_lock;
        return own->own_deformation().write({begin, begin + size}, vectors);
    }();
    take(written);
}

}  // namespace pliant::python
