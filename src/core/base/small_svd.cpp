// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/small_svd.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pliant {
namespace {

constexpr int kMaxSteps = 1000;

// The BLAS functions that SSVDC calls, on `count` numbers.

/// Norm, scaled against overflow; the root and its product are computed in double precision.
float length_of(const float* x, int count) {
    if (count == 1) return std::abs(x[0]);
    float scale = 0, sum = 1;
    for (int n = 0; n < count; ++n) {
        if (x[n] == 0) continue;
        const float size = std::abs(x[n]);
        if (scale < size) {
            const float ratio = scale / size;
            sum = sum * (ratio * ratio) + 1;
            scale = size;
        } else {
            const float ratio = size / scale;
            sum += ratio * ratio;
        }
    }
    return float(double(scale) * std::sqrt(double(sum)));
}

float dot_of(const float* x, const float* y, int count) {
    float sum = 0;
    for (int n = 0; n < count; ++n) sum += x[n] * y[n];
    return sum;
}

void add_multiple(float factor, const float* x, float* y, int count) {
    for (int n = 0; n < count; ++n) y[n] += factor * x[n];
}

void multiply(float factor, float* x, int count) {
    for (int n = 0; n < count; ++n) x[n] *= factor;
}

struct Turn {
    float cosine, sine;

    /// Rotation that maps (a, b) to (r, 0). @param[in,out] a  becomes r
    static Turn onto_first(float& a, float b) {
        const float larger = std::abs(a) > std::abs(b) ? a : b;
        const float scale = std::abs(a) + std::abs(b);
        if (scale == 0) {
            a = 0;
            return {1, 0};
        }
        const float x = a / scale, y = b / scale;
        float r = float(double(scale) * std::sqrt(double(x * x + y * y)));
        r = std::copysign(1.F, larger) * r;
        const Turn turn{a / r, b / r};
        a = r;
        return turn;
    }
    template <std::size_t N>
    void apply(std::array<float, N>& x, std::array<float, N>& y) const {
        for (std::size_t n = 0; n < N; ++n) {
            const float t = cosine * x[n] + sine * y[n];
            y[n] = cosine * y[n] - sine * x[n];
            x[n] = t;
        }
    }
};

/// Computes a Householder vector of x in place. @returns the remaining component of x after the
/// reflection
float reflect(float* x, int count) {
    float length = length_of(x, count);
    if (length == 0) return -length;
    if (x[0] != 0) length = std::copysign(length, x[0]);
    multiply(1 / length, x, count);
    x[0] += 1;
    return -length;
}

/// Applies the reflection of Householder vector h to x.
void apply_reflection(const float* h, float* x, int count) {
    const float t = -dot_of(h, x, count) / h[0];
    add_multiple(t, h, x, count);
}

/// State of the diagonalisation.
template <int N>
class Diagonalizer {
  public:
    Diagonalizer(SmallMatrix<N>& x, SmallSvd<N>& out)
        : m_x(x), m_s(out.values), m_u(out.u), m_v(out.v) {}

    void run() {
        reduce();
        generate_u();
        generate_v();
        int step = 0;
        for (int m = N; m > 0 && step < kMaxSteps;) {
            const Split split = find_split(m);
            if (split.kind == Kind::Converged) {
                order(split.first);
                step = 0;
                --m;
            } else if (split.kind == Kind::LastIsZero) {
                deflate_last(split.first, m);
            } else if (split.kind == Kind::OneIsZero) {
                deflate_at(split.first, m);
            } else {
                qr_step(split.first, m);
                ++step;
            }
        }
    }

  private:
    enum class Kind { LastIsZero, OneIsZero, QrStep, Converged };
    struct Split {
        Kind kind;
        int first;  ///< first row of the active block
    };

    static std::size_t at(int n) { return std::size_t(n); }

    /// Reduces to bidiagonal form: m_s is the diagonal, m_e the superdiagonal.
    void reduce() {
        for (int l = 0; l + 1 < N; ++l) {
            m_s[at(l)] = reflect(&m_x[at(l)][at(l)], N - l);
            for (int j = l + 1; j < N; ++j) {
                if (m_s[at(l)] != 0)
                    apply_reflection(&m_x[at(l)][at(l)], &m_x[at(j)][at(l)], N - l);
                m_e[at(j)] = m_x[at(j)][at(l)];
            }
            for (int i = l; i < N; ++i) m_u[at(l)][at(i)] = m_x[at(l)][at(i)];
            if (l + 2 < N) reduce_row(l);
        }
        m_s[N - 1] = m_x[N - 1][N - 1];
        m_e[N - 2] = m_x[N - 1][N - 2];
        m_e[N - 1] = 0;
    }
    void reduce_row(int l) {
        const int rest = N - l - 1;
        float* const e = &m_e[at(l) + 1];
        m_e[at(l)] = reflect(e, rest);
        if (m_e[at(l)] != 0) {
            std::array<float, N> work{};
            for (int j = 0; j < rest; ++j)
                add_multiple(e[j], &m_x[at(l + 1 + j)][at(l) + 1], &work[at(l) + 1], rest);
            for (int j = 0; j < rest; ++j)
                add_multiple(-e[j] / e[0], &work[at(l) + 1], &m_x[at(l + 1 + j)][at(l) + 1], rest);
        }
        for (int i = l + 1; i < N; ++i) m_v[at(l)][at(i)] = m_e[at(i)];
    }
    void generate_u() {
        m_u[N - 1] = {};
        m_u[N - 1][N - 1] = 1;
        for (int l = N - 2; l >= 0; --l) {
            if (m_s[at(l)] == 0) {
                m_u[at(l)] = {};
                m_u[at(l)][at(l)] = 1;
                continue;
            }
            float* const h = &m_u[at(l)][at(l)];
            for (int j = l + 1; j < N; ++j) apply_reflection(h, &m_u[at(j)][at(l)], N - l);
            multiply(-1, h, N - l);
            h[0] = 1 + h[0];
            std::fill_n(m_u[at(l)].begin(), l, 0.F);
        }
    }
    void generate_v() {
        for (int l = N - 1; l >= 0; --l) {
            if (l + 2 < N && m_e[at(l)] != 0) {
                const float* const h = &m_v[at(l)][at(l) + 1];
                for (int j = l + 1; j < N; ++j)
                    apply_reflection(h, &m_v[at(j)][at(l) + 1], N - l - 1);
            }
            m_v[at(l)] = {};
            m_v[at(l)][at(l)] = 1;
        }
    }

    /// Finds a negligible entry in the first m rows.
    Split find_split(int m) {
        int l = m - 1;
        for (; l > 0; --l) {
            const float sum = std::abs(m_s[at(l - 1)]) + std::abs(m_s[at(l)]);
            const float with = sum + std::abs(m_e[at(l - 1)]);
            if (with == sum) {
                m_e[at(l - 1)] = 0;
                break;
            }
        }
        if (l == m - 1) return {Kind::Converged, l};
        int zero = m;
        for (; zero > l; --zero) {
            float sum = 0;
            if (zero != m) sum += std::abs(m_e[at(zero - 1)]);
            if (zero != l + 1) sum += std::abs(m_e[at(zero - 2)]);
            const float with = sum + std::abs(m_s[at(zero - 1)]);
            if (with == sum) {
                m_s[at(zero - 1)] = 0;
                break;
            }
        }
        if (zero == l) return {Kind::QrStep, l};
        if (zero == m) return {Kind::LastIsZero, l};
        return {Kind::OneIsZero, zero};
    }
    void deflate_last(int l, int m) {
        float f = std::exchange(m_e[at(m - 2)], 0.F);
        for (int k = m - 2; k >= l; --k) {
            const Turn turn = Turn::onto_first(m_s[at(k)], f);
            if (k != l) {
                f = -turn.sine * m_e[at(k - 1)];
                m_e[at(k - 1)] = turn.cosine * m_e[at(k - 1)];
            }
            turn.apply(m_v[at(k)], m_v[at(m - 1)]);
        }
    }
    void deflate_at(int l, int m) {
        float f = std::exchange(m_e[at(l - 1)], 0.F);
        for (int k = l; k < m; ++k) {
            const Turn turn = Turn::onto_first(m_s[at(k)], f);
            f = -turn.sine * m_e[at(k)];
            m_e[at(k)] = turn.cosine * m_e[at(k)];
            turn.apply(m_u[at(k)], m_u[at(l - 1)]);
        }
    }
    void qr_step(int l, int m) {
        const auto size = [](float x) { return std::abs(x); };
        const float scale = std::max({size(m_s[at(m - 1)]), size(m_s[at(m - 2)]),
                                      size(m_e[at(m - 2)]), size(m_s[at(l)]), size(m_e[at(l)])});
        const float sm = m_s[at(m - 1)] / scale, smm1 = m_s[at(m - 2)] / scale;
        const float emm1 = m_e[at(m - 2)] / scale;
        const float sl = m_s[at(l)] / scale, el = m_e[at(l)] / scale;
        const float b = ((smm1 + sm) * (smm1 - sm) + emm1 * emm1) / 2;
        const float product = sm * emm1, c = product * product;
        float shift = 0;
        if (b != 0 || c != 0) {
            shift = float(std::sqrt(double(b * b + c)));
            if (b < 0) shift = -shift;
            shift = c / (b + shift);
        }
        float f = (sl + sm) * (sl - sm) + shift;
        float g = sl * el;
        for (int k = l; k + 1 < m; ++k) {
            float &s = m_s[at(k)], &next = m_s[at(k + 1)], &e = m_e[at(k)];
            const Turn right = Turn::onto_first(f, g);
            if (k != l) m_e[at(k - 1)] = f;
            f = right.cosine * s + right.sine * e;
            e = right.cosine * e - right.sine * s;
            g = right.sine * next;
            next = right.cosine * next;
            right.apply(m_v[at(k)], m_v[at(k + 1)]);
            const Turn left = Turn::onto_first(f, g);
            s = f;
            f = left.cosine * e + left.sine * next;
            next = -left.sine * e + left.cosine * next;
            g = left.sine * m_e[at(k + 1)];
            m_e[at(k + 1)] = left.cosine * m_e[at(k + 1)];
            left.apply(m_u[at(k)], m_u[at(k + 1)]);
        }
        m_e[at(m - 2)] = f;
    }
    /// Makes value l positive and sorts it in.
    void order(int l) {
        if (!(m_s[at(l)] >= 0)) {
            m_s[at(l)] = -m_s[at(l)];
            multiply(-1, m_v[at(l)].data(), N);
        }
        for (; l + 1 < N && !(m_s[at(l)] >= m_s[at(l + 1)]); ++l) {
            std::swap(m_s[at(l)], m_s[at(l + 1)]);
            std::swap(m_u[at(l)], m_u[at(l + 1)]);
            std::swap(m_v[at(l)], m_v[at(l + 1)]);
        }
    }

    SmallMatrix<N>& m_x;
    std::array<float, N>& m_s;
    std::array<float, N> m_e{};
    SmallMatrix<N>&m_u, &m_v;
};

}  // namespace

template <int N>
SmallSvd<N>::SmallSvd(SmallMatrix<N> matrix) {
    Diagonalizer<N>(matrix, *this).run();
}

template <int N>
SmallMatrix<N> SmallSvd<N>::inverse() const {
    SmallMatrix<N> result{};
    for (std::size_t i = 0; i < N; ++i)
        for (std::size_t j = 0; j < N; ++j)
            for (std::size_t k = 0; k < N; ++k) {
                const float value = std::abs(values[k]);
                const float scaled = value > 0 ? v[k][i] * (1 / value) : 0.F;
                result[j][i] += scaled * u[k][j];
            }
    return result;
}

template struct SmallSvd<3>;
template struct SmallSvd<4>;

}  // namespace pliant
