// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Shared by all bindings: vectors and arrays, errors, and calls without the interpreter's lock.
//
//   Python thread                     a call of the library
//   ─────────────                     ─────────────────────
//   Arena::run ── releases the lock → loops of the arena ─┬─ every 20 ms: is there a Ctrl-C?
//       raises  ← takes the lock ──── Result, LimitExceeded ← yes: the loop ends as if memory
//                                                              had run out; nothing has changed

#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>
#include <pliant/core/record.h>
#include <pliant/core/tasks.h>
#include <pliant/core/vec.h>
#include <pliant/result.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <thread>
#include <utility>

#include "exclusive.h"

namespace nb = nanobind;

namespace pliant::python {

/// Raises pliant.Error.
[[noreturn]] void raise(const Error& error);

/// The value of a result; its error is raised.
template <class T>
T take(Result<T> result) {
    if (!result.ok()) raise(result.error());
    return std::move(result).value();
}
inline void take(const Status& status) {
    if (!status.ok()) raise(status.error());
}

/// Threads of a tissue or a call.
class Arena {
  public:
    /// @param threads  0: one for each core; 1: the caller's alone, also after fork(); at most 256
    explicit Arena(int threads);
    const TaskArena& tasks() const { return *m_tasks; }
    int threads() const { return m_tasks->thread_count(); }

    /// Calls work() without the lock of the interpreter. Ctrl-C ends it within about 20 ms of a
    /// loop, if the call can fail.
    /// @returns its result; an interruption is raised
    template <class Work>
    auto run(const Work& work) const {
        return run(work, false);
    }
    /// Likewise, of a call that changes nothing, or polls TaskArena::gives_up: Ctrl-C ends it
    /// within about 20 ms of a loop's part.
    template <class Work>
    auto run_reading(const Work& work) const {
        return run(work, true);
    }

  private:
    /// A call that Ctrl-C may end.
    struct Call {
        Call(const Arena& arena, bool is_reading);
        ~Call();
        Call(const Call&) = delete;
        Call& operator=(const Call&) = delete;
        bool look_for_interruption();

        const Arena& arena;
        const bool is_reading;
        const std::thread::id thread;  ///< which began it: Python looks at signals in one thread
        Call* const outer;
        std::atomic<bool> is_interrupted = false;
        std::chrono::steady_clock::time_point next_look;
    };
    /// The call that this thread works for, on any arena; null: none.
    static Call*& current();
    bool is_interrupted(bool in_part) const;

    template <class Work>
    auto run(const Work& work, bool is_reading) const {
        Call call(*this, is_reading);
        try {
            auto result = [&] {
                const nb::gil_scoped_release without_lock;
                return work();
            }();
            if (call.is_interrupted) throw nb::python_error();
            return result;
        } catch (const std::bad_alloc&) {  // of a call that isn't noexcept
            if (call.is_interrupted) throw nb::python_error();
            throw;
        }
    }

    std::unique_ptr<TaskArena> m_workers;  ///< null with one thread
    std::unique_ptr<TaskArena> m_tasks;
};

/// Whether Ctrl-C was pressed, for calls that poll it themselves.
class Interruption {
  public:
    /// Looks every 20 ms. Takes the interpreter's lock.
    bool is_there() {
        const auto now = std::chrono::steady_clock::now();
        if (m_is_there || now < m_next) return m_is_there;
        m_next = now + std::chrono::milliseconds(20);
        const nb::gil_scoped_acquire lock;
        return m_is_there = PyErr_CheckSignals() != 0;
    }
    void raise_if_there() const {
        if (m_is_there) throw nb::python_error();
    }

  private:
    bool m_is_there = false;
    std::chrono::steady_clock::time_point m_next{};
};

/// Takes the result of work(give_up), without the interpreter's lock. Ctrl-C raises.
template <class Work>
auto take_until_interrupted(const Work& work) {
    Interruption interruption;
    auto result = [&] {
        const nb::gil_scoped_release without_lock;
        return work([&] { return interruption.is_there(); });
    }();
    interruption.raise_if_there();
    return take(std::move(result));
}

/// Calls work(n) for 0…count without the interpreter's lock. Ctrl-C raises.
template <class Work>
void for_each_row(std::size_t count, const Work& work) {
    constexpr std::size_t kPiece = 4096;
    Interruption interruption;
    {
        const nb::gil_scoped_release without_lock;
        for (std::size_t n = 0; n < count && !interruption.is_there();)
            for (const std::size_t end = std::min(count, n + kPiece); n < end; ++n) work(n);
    }
    interruption.raise_if_there();
}

/// The settings in a call's keyword arguments. Raises for other kinds of values.
Record record_of(const nb::dict& arguments);
/// A setting's name: `yield`, a word of Python's own, is given as `yield_`.
std::string name_of_keyword(std::string keyword);
nb::dict dict_of(const Record& record);
nb::object object_of(const SettingValue& value);

/// str(object)
inline std::string shown(const nb::object& object) {
    return nb::cast<std::string>(nb::str(nb::handle(object)));
}
/// Raises an error about the value of an argument or setting.
[[noreturn]] inline void raise_value(const std::string& name, const std::string& expected,
                                     nb::handle found) {
    const std::string text = nb::cast<std::string>(nb::repr(found));
    raise({ErrorCode::InvalidArgument, name + ": expected " + expected + ", found " + text, name,
           expected, text});
}

/// Changes settings by keyword arguments, all or none. None leaves an optional one as it is.
template <class T>
void change(T& settings, const nb::dict& arguments, std::type_identity_t<SettingRows<T>> rows) {
    nb::dict given;
    for (const auto& [key, value] : arguments) {
        const std::string name = name_of_keyword(nb::cast<std::string>(key));
        const Setting<T>* const row = value.is_none() ? find_setting<T>(name, rows) : nullptr;
        if (!row)
            given[key] = value;
        else if (!row->is_optional)
            raise_value(name, checked_value(*row, {}).error().expected, value);
    }
    take(apply(record_of(given), rows, settings));
}
/// Defaults with some of them changed by keyword arguments.
template <class T>
T settings_from(const nb::dict& arguments, SettingRows<T> rows) {
    T settings;
    change(settings, arguments, rows);
    return settings;
}

/// The object of a class of the module in an argument. @param kind  its class, in messages
template <class T>
const T& object_in(nb::handle given, const char* name, const char* kind) {
    const T* found = nullptr;
    if (!nb::try_cast(given, found) || !found) raise_value(name, kind, given);
    return *found;
}

/// A function of pliant._exchange.
inline nb::object exchange(const char* name) {
    return nb::module_::import_("pliant._exchange").attr(name);
}
/// An array (n, 3) that keeps the points.
nb::object points_of(std::vector<Vec3d> points);
/// numpy.asarray(given); masked values and ragged rows are refused.
inline nb::object array_of_argument(const nb::object& given, const char* name) {
    return exchange("array_of_argument")(given, name);
}
/// An array in C order of a type ("float64", …), viewed where it has both. Masked values, text,
/// objects and complex numbers are refused, as are whole numbers that the type can't hold, and NaN,
/// infinite and too large ones if all must be finite.
nb::object array_in(const nb::object& given, const char* name, const char* type,
                    bool must_be_finite = false);
/// The numbers of a nested sequence or an array, by rows; none without one.
std::vector<double> numbers_of(const std::optional<nb::object>& nested, const char* name);
/// Three numbers of any sequence.
bool vector_from(nb::handle from, Vec3d& to) noexcept;
/// Reads a sequence of as many numbers; false for other objects.
bool numbers_from(nb::handle from, std::span<double> to) noexcept;

// Parts of the module.
void bind_settings(nb::module_& m);
void bind_volumes(nb::module_& m);
void bind_fields(nb::module_& m);
void bind_meshes(nb::module_& m);
void bind_tissues(nb::module_& m);
void bind_render(nb::module_& m);
void bind_surfaces(nb::module_& m);
void bind_vessels(nb::module_& m);
void bind_springs(nb::module_& m);
void bind_elastic(nb::module_& m);
void bind_fits(nb::module_& m);
void bind_organs(nb::module_& m);
void bind_augment(nb::module_& m);
void bind_gym(nb::module_& m);
void bind_catheter_gym(nb::module_& m);
void bind_truth(nb::module_& m);
/// @pre all of them are bound
void finish_functions(nb::module_& m);

}  // namespace pliant::python

namespace nanobind::detail {

/// A sequence of three numbers ↔ Vec3d.
template <>
struct type_caster<pliant::Vec3d> {
    NB_TYPE_CASTER(pliant::Vec3d, io_name("collections.abc.Sequence[float] | "
                                          "numpy.typing.NDArray[typing.Any]",
                                          "tuple[float, float, float]"))
    bool from_python(handle from, uint8_t, cleanup_list*) noexcept {
        return pliant::python::vector_from(from, value);
    }
    static handle from_cpp(const pliant::Vec3d& v, rv_policy, cleanup_list*) noexcept {
        return make_tuple(v.x, v.y, v.z).release();
    }
};

/// A name of a file. (nanobind's own caster has types that mypy doesn't take.)
template <>
struct type_caster<std::filesystem::path> {
    NB_TYPE_CASTER(std::filesystem::path, const_name("str | os.PathLike[str]"))
    bool from_python(handle from, uint8_t, cleanup_list*) noexcept {
        PyObject* bytes = nullptr;
        if (!PyUnicode_FSConverter(from.ptr(), &bytes)) {
            PyErr_Clear();
            return false;
        }
        const object owner = steal(bytes);
        char* const name = PyBytes_AsString(bytes);
        if (name) value = name;
        return name;
    }
};

}  // namespace nanobind::detail
