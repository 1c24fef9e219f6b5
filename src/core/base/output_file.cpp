// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/core/output_file.h>

#include <fcntl.h>

#include <cerrno>
#include <system_error>

#include "base/descriptor.h"

namespace pliant {
namespace {

constexpr std::size_t kPieceBytes = std::size_t(1) << 16;

}  // namespace

OutputFile::OutputFile(const std::filesystem::path& path, const std::string& name)
    : m_name(name.empty() ? path.string() : name),
      m_file(open_file(path, O_WRONLY | O_CREAT | O_TRUNC, 0666).release()) {
    if (m_file < 0) m_error = errno;
}

OutputFile::~OutputFile() {
    (void)Descriptor(m_file).close();
}

void OutputFile::write(std::string_view bytes) {
    if (m_buffer.size() + bytes.size() > kPieceBytes) flush();
    if (bytes.size() < kPieceBytes)
        m_buffer += bytes;
    else if (m_error == 0)
        m_error = write_all(m_file, bytes.data(), bytes.size());
}

void OutputFile::flush() {
    if (m_error == 0) m_error = write_all(m_file, m_buffer.data(), m_buffer.size());
    m_buffer.clear();
}

Status OutputFile::status() const {
    if (m_error == 0) return Ok{};
    return Error{ErrorCode::Unwritable,
                 m_name + ": can't be written (" + std::generic_category().message(m_error) + ")"};
}

Status OutputFile::close() {
    flush();
    const int error = Descriptor(std::exchange(m_file, -1)).close();
    if (m_error == 0) m_error = error;
    return status();
}

}  // namespace pliant
