// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace pliant::app {

ProgressBar::ProgressBar(std::string what)
    : m_what(std::move(what)), m_terminal(::isatty(STDERR_FILENO) != 0) {
    show(0);
}

ProgressBar::~ProgressBar() {
    if (m_terminal) std::fprintf(stderr, "\r\033[K");
}

void ProgressBar::show(double fraction) {
    const int percent = std::clamp(int(fraction * 100), 0, 100);
    if (!m_terminal || percent == m_percent) return;
    m_percent = percent;
    constexpr int kWidth = 30;
    const std::string filled(std::size_t(percent * kWidth / 100), '#');
    std::fprintf(stderr, "\r%-22s [%-*s] %3d %%", m_what.c_str(), kWidth, filled.c_str(), percent);
}

}  // namespace pliant::app
