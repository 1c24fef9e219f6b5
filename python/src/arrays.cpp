// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "arrays.h"

#include <algorithm>
#include <array>

namespace pliant::python {
namespace {

constexpr auto kLookEvery = std::chrono::milliseconds(20);

const char* name_of(ErrorCode code) {
    switch (code) {
        case ErrorCode::InvalidArgument:
            return "invalid_argument";
        case ErrorCode::NotFound:
            return "not_found";
        case ErrorCode::Unreadable:
            return "unreadable";
        case ErrorCode::Unsupported:
            return "unsupported";
        case ErrorCode::Unwritable:
            return "unwritable";
        case ErrorCode::LimitExceeded:
            return "limit_exceeded";
    }
    return "";
}

/// A setting of a table of a file, "[material] offset", as the keyword that it is here; an entry is
/// one keyword.
std::string without_table(const std::string& text) {
    for (const char* part : {"[entry] place_mm", "[entry] direction"})
        if (text.starts_with(part))
            return "entry" + text.substr(std::min(text.find(':'), text.size()));
    const std::size_t end = text.find("] ");
    return text.starts_with('[') && !text.starts_with("[[") && end != std::string::npos
               ? text.substr(end + 2)
               : text;
}

}  // namespace

void raise(const Error& error) {
    const nb::object kind = nb::module_::import_("pliant._error").attr("Error");
    const std::string below = error.field == "series" ? "\n" + error.expected : "";
    const nb::object raised = kind(without_table(error.message) + below, name_of(error.code),
                                   without_table(error.field), error.expected, error.found);
    PyErr_SetObject(kind.ptr(), raised.ptr());
    throw nb::python_error();
}

void Claim::take(const Exclusive& object, nb::handle type) {
    if (m_object) return;
    const auto thread = std::this_thread::get_id();
    if (object.m_calls > 0 && !(object.m_has_inner_calls && object.m_thread == thread)) {
        const nb::object kind = nb::module_::import_("pliant._error").attr("busy_error");
        const nb::object raised = kind(type.attr("__name__"));
        PyErr_SetObject(nb::handle(raised.type()).ptr(), raised.ptr());
        throw nb::python_error();
    }
    m_object = const_cast<Exclusive*>(&object);
    m_object->m_thread = thread;
    ++m_object->m_calls;
}

Arena::Arena(int threads) {
    constexpr int kMost = 256;  // as of the program
    if (threads < 0 || threads > kMost) {
        const std::string expected = "0 (one for each core) to " + std::to_string(kMost);
        const std::string found = std::to_string(threads);
        raise({ErrorCode::InvalidArgument, "threads: expected " + expected + ", found " + found,
               "threads", expected, found});
    }
    const int count =
        threads > 0 ? threads : int(std::max(1u, std::thread::hardware_concurrency()));
    HostJobs jobs{.thread_count = count};
    if (count > 1) {
        m_workers = std::make_unique<TaskArena>(count);
        jobs.run = [this](std::int64_t number, const std::function<void(std::int64_t)>& job) {
            Call* const call = current();
            m_workers->for_each(number, 1, [&](std::int64_t begin, std::int64_t end) {
                Call* const before = std::exchange(current(), call);
                for (std::int64_t n = begin; n < end; ++n) job(n);
                current() = before;
            });
        };
    }
    jobs.give_up = [this] { return is_interrupted(false); };
    jobs.give_up_within = [this] { return is_interrupted(true); };
    m_tasks = std::make_unique<TaskArena>(std::move(jobs));
}

Arena::Call*& Arena::current() {
    thread_local Call* call = nullptr;
    return call;
}

bool Arena::is_interrupted(bool in_part) const {
    Call* const call = current();
    if (!call || &call->arena != this || (in_part && !call->is_reading)) return false;
    return call->look_for_interruption();
}

Arena::Call::Call(const Arena& its_arena, bool reading)
    : arena(its_arena),
      is_reading(reading),
      thread(std::this_thread::get_id()),
      outer(std::exchange(current(), this)),
      next_look(std::chrono::steady_clock::now() + kLookEvery) {}
Arena::Call::~Call() {
    current() = outer;
}

bool Arena::Call::look_for_interruption() {
    if (is_interrupted) return true;
    if (std::this_thread::get_id() != thread) return false;
    const auto now = std::chrono::steady_clock::now();
    if (now < next_look) return false;
    next_look = now + kLookEvery;
    const nb::gil_scoped_acquire lock;
    return is_interrupted = PyErr_CheckSignals() != 0;
}

nb::object points_of(std::vector<Vec3d> points) {
    auto* const kept = new std::vector<Vec3d>(std::move(points));
    const nb::capsule owner(kept,
                            [](void* p) noexcept { delete static_cast<std::vector<Vec3d>*>(p); });
    return nb::cast(nb::ndarray<nb::numpy, double, nb::shape<-1, 3>>(
        reinterpret_cast<double*>(kept->data()), {kept->size(), 3}, owner));
}

nb::object array_in(const nb::object& given, const char* name, const char* type,
                    bool must_be_finite) {
    return exchange("array_in")(given, name, type, must_be_finite);
}

std::vector<double> numbers_of(const std::optional<nb::object>& nested, const char* name) {
    if (!nested) return {};
    const nb::object flat = array_in(*nested, name, "float64").attr("ravel")();
    return nb::cast<std::vector<double>>(flat.attr("tolist")());
}

bool numbers_from(nb::handle from, std::span<double> to) noexcept {
    PyObject* const fast = PySequence_Fast(from.ptr(), "");
    if (!fast) {
        PyErr_Clear();
        return false;
    }
    bool ok = PySequence_Fast_GET_SIZE(fast) == Py_ssize_t(to.size());
    for (std::size_t n = 0; ok && n < to.size(); ++n) {
        to[n] = PyFloat_AsDouble(PySequence_Fast_GET_ITEM(fast, Py_ssize_t(n)));
        if (PyErr_Occurred()) {
            PyErr_Clear();
            ok = false;
        }
    }
    Py_DECREF(fast);
    return ok;
}

bool vector_from(nb::handle from, Vec3d& to) noexcept {
    std::array<double, 3> numbers;
    if (!numbers_from(from, numbers)) return false;
    to = {numbers[0], numbers[1], numbers[2]};
    return true;
}

}  // namespace pliant::python
