// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tools of the rules that check_tissue() checks: expectations, and a tissue under test.

#pragma once

#include <pliant/check_tissue.h>

#include <filesystem>
#include <string>
#include <utility>

namespace pliant::rules {

constexpr std::uint32_t kTool = 1, kOther = 7;
constexpr int kSweeps = 20;

/// Thrown by expect(): a rule is broken.
struct Broken {
    std::string expected, found;
};
inline void expect(bool kept, std::string expected, std::string found) {
    if (!kept) throw Broken{std::move(expected), std::move(found)};
}

/// The value of a result that should have one.
template <class T>
T take(Result<T> result, const std::string& call) {
    expect(result.ok(), call + " to succeed", result.ok() ? "" : result.error().message);
    return std::move(result).value();
}

/// @param call  description of the call that returned the result
template <class T>
void expect_error(const Result<T>& result, ErrorCode code, const std::string& call) {
    expect(!result.ok(), "an error of " + call, "none");
    const char* const name = code == ErrorCode::InvalidArgument ? "InvalidArgument"
                             : code == ErrorCode::NotFound      ? "NotFound"
                             : code == ErrorCode::Unsupported   ? "Unsupported"
                                                                : "Unreadable";
    expect(result.error().code == code, std::string(name) + " from " + call,
           "another code: \"" + result.error().message + '"');
}

/// Makes the tissues, and pushes them.
class Subject {
  public:
    Subject(const MakeAnother& make, const Push& push) : m_make(make), m_push(push) {}

    const Push& push() const { return m_push; }
    std::shared_ptr<Tissue> make() const {
        auto tissue = take(m_make(), "the function that makes a tissue");
        expect(tissue != nullptr, "a tissue from the function that makes it", "null");
        return tissue;
    }
    PushReport push_with(Tissue& tissue) const {
        PushReport report = take(tissue.push(kTool, m_push), "push()");
        (void)take(tissue.update_deformation(), "update_deformation()");
        return report;
    }
    /// Pushes. @returns whether the tissue can be pushed
    bool moves(Tissue& tissue) const { return push_with(tissue).status != PushStatus::Rejected; }
    /// Pushes in a step of the history.
    bool moves_in_group(Tissue& tissue) const {
        tissue.begin_group("push");
        const bool moved = moves(tissue);
        expect(tissue.end_group() == 0, "0 from end_group(): no step is forgotten",
               "another number");
        return moved;
    }

  private:
    const MakeAnother& m_make;
    const Push& m_push;
};

/// A file for a tissue's state, in a folder for temporary files; it is removed at the end.
class StateFile {
  public:
    StateFile();
    ~StateFile();
    StateFile(const StateFile&) = delete;
    StateFile& operator=(const StateFile&) = delete;
    std::string path() const { return m_path.string(); }
    /// Removes the second half.
    void damage() const;

  private:
    std::filesystem::path m_path;
};

/// The element with the largest displacement. @pre the deformation is up to date
Vec3i most_moved_element(const Tissue& tissue);

}  // namespace pliant::rules
