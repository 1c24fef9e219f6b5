// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Objects that serve one call at a time. The interpreter's lock is free during a solve, so a second
// thread, or a handler of a signal, may call an object that is in use: that call raises.
//
//   method(self, …) ── caster of self ── claims it ── call ── releases it
//
// Claims are made and released with the interpreter's lock, which protects their counters.

#pragma once

#include <nanobind/nanobind.h>

#include <thread>
#include <type_traits>

namespace pliant::python {

/// Base of classes whose objects serve one call at a time. Every bound function that takes
/// such an object claims it.
class Exclusive {
  public:
    Exclusive() = default;
    Exclusive(Exclusive&&) noexcept {}  // a moved object is another one
    ~Exclusive() = default;

  protected:
    /// Lets the calling thread call the object again during a call, for methods of Python.
    void allow_inner_calls() { m_has_inner_calls = true; }

  private:
    friend class Claim;
    int m_calls = 0;
    bool m_has_inner_calls = false;
    std::thread::id m_thread;  ///< of the calls
};

/// Keeps an object for a call.
class Claim {
  public:
    Claim() = default;
    /// Raises pliant.Error with the code "busy" if the object is in use.
    Claim(const Exclusive& object, nanobind::handle type) { take(object, type); }
    ~Claim() {
        if (m_object) --m_object->m_calls;
    }
    Claim(const Claim&) = delete;
    Claim& operator=(const Claim&) = delete;
    void take(const Exclusive& object, nanobind::handle type);

  private:
    Exclusive* m_object = nullptr;
};

}  // namespace pliant::python

namespace nanobind::detail {

/// A reference or pointer to an exclusive object claims it as long as the caster lives: for the
/// call. Constructors take a pointer_and_handle, whose object isn't there yet, and code that looks
/// for an object calls inst_ptr().
template <class T>
struct type_caster<T, enable_if_t<std::is_base_of_v<pliant::python::Exclusive, T>>>
    : type_caster_base<T> {
    using Base = type_caster_base<T>;
    operator T*() {
        T* const object = Base::operator T*();
        if (object) m_claim.take(*object, type<T>());
        return object;
    }
    operator T&() { return *operator T*(); }

  private:
    pliant::python::Claim m_claim;
};

}  // namespace nanobind::detail
