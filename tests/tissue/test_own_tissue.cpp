// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A tissue whose functions throw: exceptions become errors, and the state is the one before.

#include <gtest/gtest.h>
#include <pliant/own_tissue.h>

#include <new>
#include <set>
#include <stdexcept>

namespace pliant::test {
namespace {

enum class Throws { Nothing, NoMemory, TooLong, Text, Number };

/// One number, which a push changes before it throws.
class Throwing final : public OwnTissue {
  public:
    Throwing(const Volume& scan, const TaskArena& arena)
        : m_scan(scan), m_arena(arena), m_rest(Deformation::create(scan.grid).value()) {}
    const Volume& volume() const override { return m_scan; }
    const TaskArena& arena() const override { return m_arena; }
    const Deformation& deformation() const override { return m_rest; }
    TissueTraits traits() const noexcept override { return {.model = "throwing"}; }
    void release(std::uint32_t tool) noexcept override { m_tools.erase(tool); }
    bool is_touched_by(std::uint32_t tool) const noexcept override {
        return m_tools.contains(tool);
    }
    bool is_touched() const noexcept override { return !m_tools.empty(); }
    void state(std::vector<double>& numbers) const override { numbers = {value}; }

    double value = 1;
    Throws throws = Throws::Nothing;
    bool refuses = false;

  protected:
    Result<PushReport> do_push(std::uint32_t tool, const Push& push) override {
        m_tools.insert(tool);
        change(push.push_mm.x);
        if (refuses) return Error{ErrorCode::InvalidArgument, "push: refused"};
        return PushReport{.status = PushStatus::Applied, .step_fraction = 1, .message = {}};
    }
    Result<Sweep> do_sweep() override { return change(1), Sweep{}; }
    Status do_reset() override { return change(-value), Ok{}; }
    Status do_set_state(std::span<const double> numbers) override {
        if (numbers.size() != 1) return Error{ErrorCode::InvalidArgument, "expected one number"};
        value = numbers[0];
        m_tools.clear();
        return Ok{};
    }
    std::optional<Vec3d> do_force_n(std::uint32_t) override { return change(0), Vec3d{1, 0, 0}; }
    Result<CutReport> do_cut(const CutSurface&) override { return change(5), CutReport{}; }

  private:
    void change(double by) {
        value += by;
        switch (throws) {
            case Throws::Nothing:
                break;
            case Throws::NoMemory:
                throw std::bad_alloc();
            case Throws::TooLong:
                throw std::length_error("too long");
            case Throws::Text:
                throw std::domain_error("expected a better day");
            case Throws::Number:
                throw 7;
        }
    }

    const Volume& m_scan;
    const TaskArena& m_arena;
    Deformation m_rest;
    std::set<std::uint32_t> m_tools;
};

class OwnTissues : public testing::Test {
  protected:
    OwnTissues() {
        m_scan.grid = {{4, 4, 4}, {1, 1, 1}};
        m_scan.voxels = std::vector<std::int16_t>(64, 40);
    }

    const TaskArena m_arena{1};
    Volume m_scan;
};

TEST_F(OwnTissues, MayThrowAndAreRestored) {
    Throwing tissue(m_scan, m_arena);
    ASSERT_TRUE(tissue.push(3, {.push_mm = {2, 0, 0}}).ok());
    EXPECT_EQ(tissue.value, 3);
    for (const Throws throws : {Throws::NoMemory, Throws::TooLong, Throws::Text, Throws::Number}) {
        tissue.throws = throws;
        const bool is_memory = throws == Throws::NoMemory || throws == Throws::TooLong;
        const auto check = [&](const auto& result, const std::string& name) {
            ASSERT_FALSE(result.ok());
            EXPECT_EQ(result.error().code,
                      is_memory ? ErrorCode::LimitExceeded : ErrorCode::InvalidArgument);
            EXPECT_EQ(result.error().message, is_memory ? "out of memory"
                                              : throws == Throws::Text
                                                  ? name + ": expected a better day"
                                                  : name + ": expected an exception with a text");
            EXPECT_EQ(tissue.value, 3) << name;
        };
        check(tissue.push(3, {.push_mm = {2, 0, 0}}), "push");
        check(tissue.sweep(), "sweep");
        check(tissue.reset(), "reset");
        check(tissue.cut({}), "cut");
        EXPECT_FALSE(tissue.force_n(3).has_value());
    }
    tissue.throws = Throws::Nothing;
    EXPECT_TRUE(tissue.force_n(3).has_value());
    EXPECT_TRUE(tissue.sweep().ok());
    EXPECT_EQ(tissue.value, 4);
}

TEST_F(OwnTissues, KeepTheirToolsAfterARefusalThatChangedNothing) {
    Throwing tissue(m_scan, m_arena);
    ASSERT_TRUE(tissue.push(3, {}).ok());
    tissue.refuses = true;
    EXPECT_EQ(tissue.push(3, {.push_mm = {0, 0, 0}}).error().message, "push: refused");
    EXPECT_TRUE(tissue.is_touched_by(3));
    // One that left another state is restored by set_state, which releases the tools.
    EXPECT_EQ(tissue.push(3, {.push_mm = {2, 0, 0}}).error().message, "push: refused");
    EXPECT_EQ(tissue.value, 1);
    EXPECT_FALSE(tissue.is_touched());
}

TEST_F(OwnTissues, LeaveOutCapabilitiesByDefault) {
    Throwing tissue(m_scan, m_arena);
    EXPECT_EQ(tissue.slide(1, {}, {}).error().code, ErrorCode::Unsupported);
    EXPECT_EQ(tissue.carve({}).error().code, ErrorCode::Unsupported);
    EXPECT_EQ(tissue.configure({}).error().code, ErrorCode::Unsupported);
    EXPECT_EQ(tissue.set_state({}).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(tissue.value, 1);
}

}  // namespace
}  // namespace pliant::test
