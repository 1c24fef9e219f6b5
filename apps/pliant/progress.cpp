// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "progress.h"

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <system_error>
#include <utility>

namespace pliant::app {
namespace {

std::atomic<bool> g_line_is_drawn = false;

}  // namespace

void clear_progress_line() noexcept {
    if (g_line_is_drawn.exchange(false)) std::fprintf(stderr, "\r\033[K");
}

ProgressBar::ProgressBar(std::string work)
    : m_what(std::move(work)),
      m_terminal(::isatty(STDERR_FILENO) != 0),
      m_start(std::chrono::steady_clock::now()) {
    if (m_terminal) {
        draw(0);
        return;
    }
    // Signals are handled by the other threads.
    sigset_t all, before;
    sigfillset(&all);
    ::pthread_sigmask(SIG_BLOCK, &all, &before);
    try {
        m_teller = std::thread([this] { tell_at_times(); });
    } catch (const std::system_error&) {
    }
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

ProgressBar::~ProgressBar() {
    if (m_teller.joinable()) {
        {
            const std::lock_guard guard(m_mutex);
            m_over = true;
        }
        m_over_changed.notify_all();
        m_teller.join();
    }
    clear_progress_line();
}

void ProgressBar::show(double fraction) {
    m_percent = std::clamp(int(fraction * 100), 0, 100);
    if (m_terminal) draw(m_percent);
}

void ProgressBar::draw(int percent) {
    if (percent == m_drawn) return;
    m_drawn = percent;
    g_line_is_drawn = true;
    constexpr int kWidth = 30;
    const std::string filled(std::size_t(percent * kWidth / 100), '#');
    std::fprintf(stderr, "\r%-22s [%-*s] %3d %%", m_what.c_str(), kWidth, filled.c_str(), percent);
}

void ProgressBar::tell_at_times() {
    constexpr std::chrono::seconds kFirst(2), kBetween(5);
    auto next = m_start + kFirst;
    std::unique_lock lock(m_mutex);
    while (!m_over_changed.wait_until(lock, next, [this] { return m_over; })) {
        const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(next - m_start);
        std::fprintf(stderr, "pliant: %s: %d %% after %lld s\n", m_what.c_str(), m_percent.load(),
                     static_cast<long long>(seconds.count()));
        next += kBetween;
    }
}

}  // namespace pliant::app
