// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/dicom_input.h"

#include "base/errors.h"
#include "base/memory_budget.h"
#include "formats/inflated_file.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <span>
#include <utility>

namespace pliant {
namespace {

constexpr std::size_t kMaxInflatedBytes = std::size_t(1) << 30;

}  // namespace

DicomInput::DicomInput(std::filesystem::path path) : m_path(std::move(path)), m_file(m_path) {}

Status DicomInput::inflate_from(std::uint64_t start) {
    constexpr int kRawDeflate = -15;
    InflatedFile file(m_path, m_path, start, kRawDeflate);
    std::string bytes;
    std::size_t count = 0;
    while (!file.ended()) {
        if (count == bytes.size()) {
            if (count >= kMaxInflatedBytes)
                return Error{ErrorCode::LimitExceeded,
                             m_path.string() + ": inflates to more than 1 GiB, expected less"};
            const std::size_t more = std::max(count, InflatedFile::kPieceBytes);
            if (!has_memory_for(more + count)) throw std::bad_alloc();
            bytes.resize(count + more);
        }
        const auto room = std::as_writable_bytes(std::span(bytes)).subspan(count);
        const auto read = file.read_some(room);
        if (!read) return read.error();
        count += *read;
    }
    bytes.resize(count);
    m_inflated = std::move(bytes);
    m_deflated_from = start;
    return Ok{};
}

std::uint64_t DicomInput::size() const {
    return m_deflated_from ? *m_deflated_from + m_inflated.size() : m_file.size();
}

std::size_t DicomInput::read(void* out, std::size_t count) {
    if (!m_deflated_from || m_at < *m_deflated_from) {
        if (m_file.at() != m_at) m_file.seek(m_at);
        count = m_file.read(out, count);
    } else {
        const std::uint64_t from =
            std::min<std::uint64_t>(m_at - *m_deflated_from, m_inflated.size());
        count = std::min<std::size_t>(count, m_inflated.size() - std::size_t(from));
        std::memcpy(out, m_inflated.data() + from, count);
    }
    m_at += count;
    return count;
}

}  // namespace pliant
