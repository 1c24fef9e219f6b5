// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Displacement and Jacobian as a client holds them, against the same scene played in this process:
// there from the forward displacement alone, as write_displacement would write it, or from the
// resampler's one-shot form.
// Covers: hub/overlay_feed.cpp, hub/box_feed.cpp.

#include <cmath>

#include "hub/twin_scene.h"
#include "protocol/half.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using serve::float_from_half;

/// φ(x) of a forward displacement field, trilinear between its voxels [voxels].
struct ForwardMap {
    const VectorField& field;

    Vec3d operator()(Vec3d x) const {
        const Vec3i low{int(std::floor(x.x)), int(std::floor(x.y)), int(std::floor(x.z))};
        Vec3d u{0, 0, 0};
        for (int c = 0; c < 8; ++c) {
            Vec3i e = low + Vec3i{c & 1, c >> 1 & 1, c >> 2};
            double weight = 1;
            for (int a = 0; a < 3; ++a) weight *= c >> a & 1 ? x[a] - low[a] : 1 - x[a] + low[a];
            if (!contains(voxel_box(field.grid), e)) continue;
            const Vec3f v = field.vectors_mm[voxel_index(field.grid, e)];
            u = u + weight * Vec3d{v.x, v.y, v.z};
        }
        return x + voxel_from_world(field.grid, field.grid.origin_mm + u);
    }
    /// φ⁻¹(p), where halving steps lead there.
    std::optional<Vec3d> inverse(Vec3d p) const {
        Vec3d x = p;
        for (int step = 0; step < 400; ++step) {
            const Vec3d miss = p - (*this)(x);
            if (norm(miss) < 1e-7) return x;
            x = x + 0.5 * miss;
        }
        return {};
    }
    double jacobian(Vec3d x) const {
        constexpr double kStep = 1e-5;
        Mat3d f{};
        for (int a = 0; a < 3; ++a) {
            Vec3d before = x, after = x;
            before[a] -= kStep;
            after[a] += kStep;
            f.columns[a] = (0.5 / kStep) * ((*this)(after) - (*this)(before));
        }
        return determinant(f);
    }
};

class OverlayTest : public TwinSceneTest {
  protected:
    Json random_command(Random& random, double longest) {
        const Vec3d at = random.vector(12);
        switch (random.whole(0, 7)) {
            case 0:
                return {{"do", "undo"}};
            case 1:
                return {{"do", "redo"}};
            case 2:
                if (random.whole(0, 3) == 0) return {{"do", "reset"}};
                [[fallthrough]];
            default:
                const Vec3d by = random.vector(longest);
                return push_of(at, by, random.real(1, 5));
        }
    }
    /// The client's numbers equal those of a complete resampling of the twin.
    void expect_same(TestClient& client, const std::string& kind) {
        ASSERT_TRUE(is_twin(client));
        const Deformed once = deform_volume(m_twin->tissue(), Mapping::Cells, true).value();
        const VectorField inverse = inverse_field(once).value();
        std::vector<float> expected;
        if (kind == "displacement") {
            for (const Vec3f u : inverse.vectors_mm)
                expected.push_back(std::sqrt(u.x * u.x + u.y * u.y + u.z * u.z));
        } else {
            // From a new live deformation.
            LiveDeformation live = LiveDeformation::create(m_twin->tissue()).value();
            (void)live.update();
            ASSERT_TRUE(live.keep_sources(true));
            expected.resize(inverse.vectors_mm.size());
            live.jacobian(voxel_box(inverse.grid), expected);
        }
        ASSERT_EQ(client.overlay.size(), expected.size());
        for (std::size_t v = 0; v < expected.size(); ++v)
            ASSERT_EQ(client.overlay[v], serve::half_from_float(expected[v]))
                << kind << ", voxel " << v;
    }
};

TEST_F(OverlayTest, IsThatOfTheForwardDisplacementAndGoesToClientsThatAsk) {
    Visitor a(*m_server), b(*m_server, true), c(*m_server);
    both(a, push_of({0, 0, 0}, {0, 1.5, 0.4}, 5));
    a.checked_checksum();
    EXPECT_EQ(a.overlay_boxes, 0);
    EXPECT_EQ(a.state["timing"]["overlay_ms"], 0);
    EXPECT_EQ(a.ask_overlay("displacement")["t"], "done");
    EXPECT_EQ(b.ask_overlay("jacobian")["t"], "done");  // a viewer may ask, too
    Random random(5);
    for (int n = 0; n < 6; ++n) {
        const Vec3d at = random.vector(10), by = random.vector(1.2);
        both(a, push_of(at, by, 4));
    }
    ASSERT_TRUE(is_twin(a));
    b.checked_checksum();
    c.checked_checksum();
    EXPECT_GT(a.overlay_boxes, 0);
    EXPECT_GT(b.overlay_boxes, 0);
    EXPECT_EQ(c.overlay_boxes, 0);

    VectorField forward{m_twin->info().grid, FieldKind::Modeling, {}};
    const std::size_t slice = std::size_t(forward.grid.size.x) * std::size_t(forward.grid.size.y);
    forward.vectors_mm.assign(voxel_count(forward.grid), Vec3f{0, 0, 0});
    for (int k = 0; k < forward.grid.size.z; ++k)
        displacement_slices(m_twin->tissue())
            .value()(k, std::span(forward.vectors_mm).subspan(std::size_t(k) * slice, slice));
    const ForwardMap phi{forward};
    int moved = 0, grown = 0, compared = 0;
    for (int k = 1; k < 32; ++k)
        for (int j = 1; j < 35; ++j)
            for (int i = 1; i < 41; ++i) {
                const Vec3d p{double(i), double(j), double(k)};
                const std::size_t v = voxel_index(forward.grid, {i, j, k});
                const auto x = phi.inverse(p);
                if (!x) continue;
                const Vec3d s = forward.grid.spacing_mm;
                const Vec3d way{(p - *x).x * s.x, (p - *x).y * s.y, (p - *x).z * s.z};
                const double mm = float_from_half(a.overlay[v]);
                ASSERT_NEAR(mm, norm(way), 2e-3 + 1e-3 * mm) << i << ' ' << j << ' ' << k;
                moved += mm > 0.1;
                ++compared;
                // Beside a cell's face the cell next to it may be meant, and at rest it is 1.
                bool is_inside = norm(way) > 1e-3;
                for (int axis = 0; axis < 3; ++axis) {
                    const double t = (*x)[axis] - std::floor((*x)[axis]);
                    is_inside &= t > 2e-3 && t < 1 - 2e-3;
                }
                const double det = float_from_half(b.overlay[v]);
                if (is_inside) {
                    ASSERT_NEAR(det, phi.jacobian(*x), 0.01) << i << ' ' << j << ' ' << k;
                    grown += std::abs(det - 1) > 0.03;
                }
            }
    EXPECT_GT(compared, 30000);
    EXPECT_GT(moved, 300);
    EXPECT_GT(grown, 100);
    EXPECT_GT(b.state["timing"]["overlay_ms"], 0);

    // After "none" nothing is sent.
    a.ask_overlay("none");
    a.overlay_boxes = 0;
    both(a, push_of({0, 0, 0}, {0, 1, 0}, 5));
    a.checked_checksum();
    EXPECT_EQ(a.overlay_boxes, 0);
}

TEST_F(OverlayTest, ARandomSequenceOfEverythingLeavesItAsMadeAnew) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Visitor a(*m_server), b(*m_server, true, {{"lz4", true}});
        std::string kind_a = "displacement", kind_b = "jacobian";
        a.ask_overlay(kind_a);
        b.ask_overlay(kind_b);
        for (int n = 0; n < 40; ++n) {
            both(a, random_command(random, 6));
            switch (random.whole(0, 14)) {
                case 0:
                    expect_same(a, kind_a);
                    break;
                case 1:
                    kind_a = kind_a == "jacobian" ? "displacement" : "jacobian";
                    a.ask_overlay(kind_a);
                    break;
                case 2:
                    b.ask_overlay(random.whole(0, 1) ? "none" : "displacement");
                    b.ask_overlay(kind_b);
                    break;
                default:
                    break;
            }
        }
        expect_same(a, kind_a);
        expect_same(b, kind_b);
        // A latecomer is sent the deformed part, and little else.
        Visitor late(*m_server, true);
        late.ask_overlay("displacement");
        expect_same(late, "displacement");
        late.ask_overlay("jacobian");
        expect_same(late, "jacobian");
        both(a, {{"do", "reset"}});
        expect_same(late, "jacobian");
        EXPECT_EQ(late.overlay, std::vector<std::uint16_t>(late.voxels.size(), 0x3c00));
    }
}

TEST_F(OverlayTest, EndsWithItsConnectionAndIsAskedForAgain) {
    auto a = std::make_unique<TestClient>(m_server->port(), m_server->link());
    a->enter();
    a->ask_overlay("displacement");
    both(*a, push_of({0, 0, 0}, {0, 2, 0}, 5));
    expect_same(*a, "displacement");
    const auto resumed_client = resumed(std::move(a));
    TestClient& again = *resumed_client;
    both(again, push_of({5, 0, 0}, {0, 2, 0}, 5));
    again.checked_checksum();
    EXPECT_EQ(again.overlay_boxes, 0);
    again.ask_overlay("displacement");
    expect_same(again, "displacement");
    EXPECT_GT(again.overlay_boxes, 0);
}

TEST_F(OverlayTest, AClientThatDoesNotAnswerIsSentThreeAndDelaysNoOther) {
    Visitor a(*m_server), b(*m_server);
    a.sends_overlay_seen = false;
    a.ask_overlay("displacement");
    b.ask_overlay("displacement");
    for (int n = 0; n < 12; ++n) {
        both(a, push_of({0, 0, 0}, {0, 0.4, 0}, 5));
        ASSERT_TRUE(a.until_up_to_date());
        expect_same(b, "displacement");
    }
    EXPECT_EQ(a.whole_overlays, 3);
    a.sends_overlay_seen = true;
    a.say({{"do", "seen"}, {"step", a.overlay_step}, {"format", 3}});  // no such overlay
    a.say({{"do", "seen"}, {"step", a.overlay_step}, {"format", 2}});
    expect_same(a, "displacement");
}

}  // namespace
}  // namespace pliant::test
