// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Constraints of segment i form a block of six:
//
//   stretch and shear   Γ = Rᵢᵀ (x_{i+1} − x_i)/l − e₃,   energy ½ l Γᵀ diag(GA, GA, EA) Γ
//   bend and twist      r − r₀, r = log(q_{i−1}⁻¹ q_i)
//                       energy ½ (r − r₀)ᵀ diag(EI, EI, GJ) (r − r₀)/l
//
// with l/2 for the joint of the base, because bending is sampled at nodes: the error is of second
// order. A held tip adds a block: a joint of l/2 to the frame that holds it. [Kugelstadt2016] uses
// the imaginary part of q⁻¹q for r; the logarithm is valid for any angle. Only adjacent blocks i
// and i + 1 share variables, x_{i+1} and q_i. So the Newton step of [Macklin2016] is a chain of
// blocks, solved directly as in [Deul2018]. Segments rotate like balls: their inertia is m l²/12
// about all axes, the rod's own axis included.

#pragma once

#include <pliant/research/rod.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "pbd/rotations.h"
#include "rods/block_chain.h"

namespace pliant::pbd {

/// Variables of a block's constraints.
enum Variable { kNodeBefore, kNodeAfter, kTurnBefore, kTurn, kVariables };

struct SegmentDerivatives {
    Mat3d stretch[kVariables];  ///< of Γ; none with respect to kTurnBefore
    Mat3d bend[kVariables];     ///< of r; with respect to rotations only
};

/// Whether a quaternion is finite and nearly of unit length.
inline bool is_of_length_1(Rotation q) {
    return std::abs(std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z) - 1) < 1e-3;
}

struct RodSolver {
    explicit RodSolver(const RodSettings& s)
        : settings(s), count(std::size_t(s.segments)), matrix(count), right(count) {
        l = s.length / s.segments;
        h = s.time_step / s.sub_steps;
        const double mass = s.mass / s.segments;
        w_turn = 12 / (mass * l * l);
        w_node.assign(count + 1, 1 / mass);
        w_node[0] = 0;
        w_node[count] = 2 / mass;
        base_frame = s.frame;
        for (std::size_t n = 0; n <= count; ++n)
            x.push_back(s.base + rotated(s.frame, {0, 0, l * double(n)}));
        q.assign(count, s.frame);
        v.assign(count + 1, {0, 0, 0});
        spin.assign(count, {0, 0, 0});
        force = v;
        moment = spin;
        rest.assign(count, {0, 0, 0});
        push = rest;
        derivatives.resize(count);
        lambda.assign(count, BlockVector{});
        old_x = good_x = x;
        old_q = good_q = q;
        good_v = v;
        good_spin = spin;
    }

    double joint_length(std::size_t i) const { return i == 0 || i == count ? 0.5 * l : l; }
    Rotation frame_before(std::size_t i) const { return i == 0 ? base_frame : q[i - 1]; }
    Rotation frame_of(std::size_t i) const { return i == count ? tip_frame : q[i]; }
    Vec3d turn_of(std::size_t i) const {
        return rotation_vector(inverse_of(frame_before(i)) * frame_of(i));
    }
    /// Rest rotation of a joint.
    Vec3d rest_of(std::size_t i) const { return i == count ? Vec3d{0, 0, 0} : rest[i]; }
    Vec3d strain_of(std::size_t i) const {
        if (i == count) return {0, 0, 0};
        return rotated(inverse_of(q[i]), (1 / l) * (x[i + 1] - x[i])) - Vec3d{0, 0, 1};
    }
    /// 1/stiffness of each of the six.
    BlockVector compliance(std::size_t i) const {
        const double j = joint_length(i);
        const RodSettings& s = settings;
        return {1 / (s.shear_stiffness * l),   1 / (s.shear_stiffness * l),
                1 / (s.stretch_stiffness * l), j / s.bend_stiffness,
                j / s.bend_stiffness,          j / s.twist_stiffness};
    }
    double weight(std::size_t i, Variable variable) const {
        if (i == count) return variable == kTurnBefore ? w_turn : 0;
        switch (variable) {
            case kNodeBefore:
                return w_node[i];
            case kNodeAfter:
                return w_node[i + 1];
            case kTurnBefore:
                return i == 0 ? 0 : w_turn;
            default:
                return w_turn;
        }
    }

    void derive(std::size_t i) {
        SegmentDerivatives& d = derivatives[i];
        d.stretch[kTurnBefore] = Mat3d{};
        if (i == count) {
            d.stretch[kNodeBefore] = d.stretch[kNodeAfter] = d.stretch[kTurn] = Mat3d{};
        } else {
            const Mat3d to_local = transposed(matrix_of(q[i]));
            d.stretch[kNodeAfter] = scaled(1 / l, to_local);
            d.stretch[kNodeBefore] = scaled(-1 / l, to_local);
            d.stretch[kTurn] = to_local * crossing((1 / l) * (x[i + 1] - x[i]));
        }
        d.bend[kNodeBefore] = d.bend[kNodeAfter] = Mat3d{};
        d.bend[kTurn] = log_derivative(turn_of(i)) * transposed(matrix_of(frame_before(i)));
        d.bend[kTurnBefore] = scaled(-1, d.bend[kTurn]);
    }

    /// block += w · J_a J_bᵀ, where the rows of J are those of Γ and of r.
    static void add_product(Block& block, double w, const SegmentDerivatives& a, Variable of_a,
                            const SegmentDerivatives& b, Variable of_b) {
        if (w == 0) return;
        const Mat3d* rows_a[2] = {&a.stretch[of_a], &a.bend[of_a]};
        const Mat3d* rows_b[2] = {&b.stretch[of_b], &b.bend[of_b]};
        for (std::size_t r = 0; r < kBlock; ++r)
            for (std::size_t c = 0; c < kBlock; ++c) {
                double value = 0;
                for (int k = 0; k < 3; ++k)
                    value += rows_a[r / 3]->columns[k][int(r % 3)] *
                             rows_b[c / 3]->columns[k][int(c % 3)];
                block[r * kBlock + c] += w * value;
            }
    }

    /// One Newton step of all constraints. Moments are applied in the first iteration, not in the
    /// prediction, where a single segment would rotate by many turns.
    void solve(bool first) {
        for (std::size_t i = 0; i < count; ++i)
            push[i] = first ? h * h * w_turn * moment[i] : Vec3d{0, 0, 0};
        const std::size_t blocks = right.size();
        for (std::size_t i = 0; i < blocks; ++i) derive(i);
        for (std::size_t i = 0; i < blocks; ++i) {
            Block& a = matrix.diagonal[i];
            a.fill(0);
            for (const Variable at : {kNodeBefore, kNodeAfter, kTurnBefore, kTurn})
                add_product(a, weight(i, at), derivatives[i], at, derivatives[i], at);
            const BlockVector soft = compliance(i);
            const SegmentDerivatives& d = derivatives[i];
            Vec3d strain = strain_of(i), bend = turn_of(i) - rest_of(i);
            if (i < count) {
                strain = strain + d.stretch[kTurn] * push[i];
                bend = bend + d.bend[kTurn] * push[i];
            }
            if (i > 0) bend = bend + d.bend[kTurnBefore] * push[i - 1];
            for (std::size_t r = 0; r < kBlock; ++r) {
                const double alpha = soft[r] / (h * h);
                a[r * kBlock + r] += alpha;
                const double value = r < 3 ? strain[int(r)] : bend[int(r) - 3];
                right[i][r] = -value - alpha * lambda[i][r];
            }
            Block& u = matrix.upper[i];
            u.fill(0);
            if (i + 1 == blocks) break;
            add_product(u, w_node[i + 1], derivatives[i], kNodeAfter, derivatives[i + 1],
                        kNodeBefore);
            add_product(u, w_turn, derivatives[i], kTurn, derivatives[i + 1], kTurnBefore);
        }
        matrix.solve(right);
        for (std::size_t i = 0; i < blocks; ++i)
            for (std::size_t r = 0; r < kBlock; ++r) lambda[i][r] += right[i][r];
        for (std::size_t i = 0; i < count; ++i) {
            x[i] = x[i] + pulled(right, i, kNodeBefore);
            x[i + 1] = x[i + 1] + pulled(right, i, kNodeAfter);
        }
        // Rotations invalidate the derivatives, so they are applied last.
        for (std::size_t i = 0; i < count; ++i) {
            Vec3d by = push[i] + pulled(right, i, kTurn);
            if (i + 1 < blocks) by = by + pulled(right, i + 1, kTurnBefore);
            q[i] = rotation_by(by) * q[i];
        }
    }
    /// w Jᵀ λ
    Vec3d pulled(const std::vector<BlockVector>& by, std::size_t i, Variable at) const {
        return weight(i, at) * pull(by, i, at);
    }
    Vec3d pull(const std::vector<BlockVector>& by, std::size_t i, Variable at) const {
        const BlockVector& b = by[i];
        return transposed(derivatives[i].stretch[at]) * Vec3d{b[0], b[1], b[2]} +
               transposed(derivatives[i].bend[at]) * Vec3d{b[3], b[4], b[5]};
    }

    bool tip_is_held() const { return right.size() > count; }

    void sub_step() {
        const double keep = 1 - settings.damping * h;
        old_x = x;
        old_q = q;
        const std::size_t free = count + (tip_is_held() ? 0 : 1);  // index after the last free node
        for (std::size_t n = 1; n < free; ++n) {
            v[n] = keep * v[n] + h * (settings.gravity + w_node[n] * force[n]);
            x[n] = x[n] + h * v[n];
        }
        for (std::size_t i = 0; i < count; ++i) {
            spin[i] = keep * spin[i];
            q[i] = rotation_by(h * spin[i]) * q[i];
        }
        std::fill(lambda.begin(), lambda.end(), BlockVector{});
        for (int n = 0; n < settings.iterations; ++n) solve(n == 0);
        for (std::size_t n = 1; n < free; ++n) v[n] = (1 / h) * (x[n] - old_x[n]);
        for (std::size_t i = 0; i < count; ++i) {
            const Rotation turned = is_of_length_1(q[i]) ? q[i] : old_q[i];
            spin[i] = (1 / h) * rotation_vector(turned * inverse_of(old_q[i]));
            const double length =
                std::sqrt(q[i].w * q[i].w + q[i].x * q[i].x + q[i].y * q[i].y + q[i].z * q[i].z);
            q[i] = {q[i].w / length, q[i].x / length, q[i].y / length, q[i].z / length};
        }
    }
    void resize_blocks(std::size_t blocks) {
        matrix.diagonal.resize(blocks);
        matrix.upper.resize(blocks);
        right.resize(blocks);
        lambda.resize(blocks);
        derivatives.resize(blocks);
    }
    bool is_good() const {
        return std::all_of(x.begin(), x.end(), is_finite) &&
               std::all_of(v.begin(), v.end(), is_finite) &&
               std::all_of(spin.begin(), spin.end(), is_finite);
    }

    RodSettings settings;
    std::size_t count;
    double l = 0, h = 0, w_turn = 0;
    Rotation base_frame, tip_frame;
    std::vector<Vec3d> x, v, old_x, good_x, good_v, force;  ///< [node]
    std::vector<double> w_node;
    std::vector<Rotation> q, old_q, good_q;  ///< [segment]
    std::vector<Vec3d> spin, good_spin, moment, rest, push;
    std::vector<SegmentDerivatives> derivatives;
    std::vector<BlockVector> lambda;
    BlockChain matrix;
    std::vector<BlockVector> right;
};

}  // namespace pliant::pbd
