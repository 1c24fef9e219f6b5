// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Light and normals of pixels, compiled for each instruction set and dispatched at run time. The
// scalar versions are RealLook::shade and VolumeRays::normal.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include "render/exposure.h"
#include "render/noise_tile.h"
#include "render/shade.h"

#include "base/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/shade_vector.cpp"  // this file, compiled again for each target
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pliant::render {
namespace HWY_NAMESPACE {
namespace {

#undef PLIANT_INLINE
#define PLIANT_INLINE HWY_INLINE

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, 8>;
using Floats = hn::Rebind<float, D>;
using Ints = hn::Rebind<std::int32_t, D>;
constexpr std::size_t kLanes = hn::MaxLanes(D());
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
constexpr bool kHasGather = true;
#else
constexpr bool kHasGather = false;
#endif

/// A number for each lane.
struct V {
    hn::Vec<D> v;

    HWY_INLINE V(hn::Vec<D> lanes) : v(lanes) {}
    HWY_INLINE V(double number) : v(hn::Set(D(), number)) {}
    HWY_INLINE V operator-() const { return hn::Neg(v); }
    friend HWY_INLINE V operator+(V a, V b) { return hn::Add(a.v, b.v); }
    friend HWY_INLINE V operator-(V a, V b) { return hn::Sub(a.v, b.v); }
    friend HWY_INLINE V operator*(V a, V b) { return hn::Mul(a.v, b.v); }
    friend HWY_INLINE V operator/(V a, V b) { return hn::Div(a.v, b.v); }
};
HWY_INLINE V larger(V a, V b) {
    return hn::Max(a.v, b.v);
}
HWY_INLINE V smaller(V a, V b) {
    return hn::Min(a.v, b.v);
}
HWY_INLINE V absolute(V a) {
    return hn::Abs(a.v);
}
HWY_INLINE V root(V a) {
    return hn::Sqrt(a.v);
}
HWY_INLINE V where_more(V a, V b, V yes, V no) {
    return hn::IfThenElse(hn::Gt(a.v, b.v), yes.v, no.v);
}
HWY_INLINE bool all_more(V a, V b) {
    return hn::AllTrue(D(), hn::Gt(a.v, b.v));
}

struct Triple {
    V x, y, z;

    HWY_INLINE Triple(V x_, V y_, V z_) : x(x_), y(y_), z(z_) {}
    HWY_INLINE Triple(Vec3d a) : x(a.x), y(a.y), z(a.z) {}
    HWY_INLINE Triple operator-() const { return {-x, -y, -z}; }
    friend HWY_INLINE Triple operator+(const Triple& a, const Triple& b) {
        return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    friend HWY_INLINE Triple operator-(const Triple& a, const Triple& b) {
        return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    friend HWY_INLINE Triple operator*(V s, const Triple& a) { return {s * a.x, s * a.y, s * a.z}; }
};
HWY_INLINE V dot(const Triple& a, const Triple& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
HWY_INLINE V norm(const Triple& a) {
    return root(dot(a, a));
}
HWY_INLINE Triple normalized(const Triple& a) {
    return (1 / norm(a)) * a;
}
HWY_INLINE Triple where_more(V a, V b, const Triple& yes, const Triple& no) {
    return {where_more(a, b, yes.x, no.x), where_more(a, b, yes.y, no.y),
            where_more(a, b, yes.z, no.z)};
}
HWY_INLINE Triple product(const Mat3d& m, const Triple& v) {
    return v.x * Triple(m.columns[0]) + v.y * Triple(m.columns[1]) + v.z * Triple(m.columns[2]);
}

#include "render/real_look.inc"

/// Eight corners of a cell in each lane, x fastest.
struct Corners {
    V v[8];
};

/// Voxels of one type as a continuous field. Same as VoxelField::sample and VoxelField::gradient.
template <class T>
class Voxels {
  public:
    HWY_INLINE Voxels(const ScanView& scan, const T* voxels)
        : m_voxels(voxels), m_from_world(scan.voxel_from_world), m_grid(scan.volume.grid) {
        const Vec3i size = m_grid.size;
        m_last = {size.x - 1.0, size.y - 1.0, size.z - 1.0};
        m_row = size.x;
        m_slice = std::ptrdiff_t(size.x) * size.y;
        const double bytes = double(m_slice) * size.z * sizeof(T);
        m_gathers = kHasGather && bytes <= double(std::numeric_limits<std::int32_t>::max());
    }

    HWY_INLINE Triple to_voxel(const Triple& point_mm) const {
        return product(m_from_world, point_mm - Triple(m_grid.origin_mm));
    }

    HWY_INLINE V sample(const Triple& ijk) const {
        Triple f = Vec3d{0, 0, 0};
        const V offset = cell_of(ijk.x, m_last.x, f.x) +
                         cell_of(ijk.y, m_last.y, f.y) * double(m_row) +
                         cell_of(ijk.z, m_last.z, f.z) * double(m_slice);
        const Corners c = m_gathers ? gathered(offset) : loaded(offset);
        const V* v = c.v;
        const V x00 = v[0] + f.x * (v[1] - v[0]), x10 = v[2] + f.x * (v[3] - v[2]);
        const V x01 = v[4] + f.x * (v[5] - v[4]), x11 = v[6] + f.x * (v[7] - v[6]);
        const V y0 = x00 + f.y * (x10 - x00), y1 = x01 + f.y * (x11 - x01);
        return y0 + f.z * (y1 - y0);
    }

    HWY_INLINE Triple gradient(const Triple& ijk) const {
        const auto slope = [&](V Triple::*axis, double last) HWY_ATTR {
            Triple before = ijk, after = ijk;
            before.*axis = clamped(ijk.*axis - 1, 0, last);
            after.*axis = clamped(ijk.*axis + 1, 0, last);
            const V width = after.*axis - before.*axis;
            return where_more(width, 0, (sample(after) - sample(before)) / width, 0);
        };
        return {slope(&Triple::x, m_last.x), slope(&Triple::y, m_last.y),
                slope(&Triple::z, m_last.z)};
    }

  private:
    /// Cell of a coordinate, and the position in it.
    static HWY_INLINE V cell_of(V at, double last, V& fraction) {
        const V p = clamped(at, 0, last);
        const V cell = smaller(hn::Trunc(p.v), std::max(last - 1, 0.0));
        fraction = p - cell;
        return cell;
    }
    std::ptrdiff_t next_row() const { return m_last.y > 0 ? m_row : 0; }
    std::ptrdiff_t next_slice() const { return m_last.z > 0 ? m_slice : 0; }

    /// @param offset  of the first corner [voxels]
    HWY_INLINE Corners gathered(V offset) const {
        const Ints d;
        const V bytes = offset * double(sizeof(T));
        const auto at = hn::DemoteTo(d, bytes.v);
        Corners c{{0, 0, 0, 0, 0, 0, 0, 0}};
        for (int n = 0; n < 4; ++n) {
            const std::ptrdiff_t voxels = (n & 1 ? next_row() : 0) + (n & 2 ? next_slice() : 0);
            const auto row =
                hn::Add(at, hn::Set(d, std::int32_t(voxels * std::ptrdiff_t(sizeof(T)))));
            if constexpr (sizeof(T) == 2) {  // both voxels of a row at once
                const auto pair =
                    hn::GatherOffset(d, reinterpret_cast<const std::int32_t*>(m_voxels), row);
                c.v[2 * n] = hn::PromoteTo(D(), hn::ShiftRight<16>(hn::ShiftLeft<16>(pair)));
                c.v[2 * n + 1] = hn::PromoteTo(D(), hn::ShiftRight<16>(pair));
            } else {
                c.v[2 * n] = hn::PromoteTo(D(), hn::GatherOffset(Floats(), m_voxels, row));
                c.v[2 * n + 1] = hn::PromoteTo(D(), hn::GatherOffset(Floats(), m_voxels + 1, row));
            }
        }
        return c;
    }
    /// Same for targets that don't gather, and for scans of more than 2 GiB.
    HWY_INLINE Corners loaded(V offset) const {
        HWY_ALIGN double at[kLanes], v[8][kLanes];
        hn::Store(offset.v, D(), at);
        for (std::size_t n = 0; n < kLanes; ++n) {
            const T* p = m_voxels + std::ptrdiff_t(at[n]);
            const T* q = p + next_slice();
            const std::ptrdiff_t up = next_row();
            v[0][n] = double(p[0]), v[1][n] = double(p[1]);
            v[2][n] = double(p[up]), v[3][n] = double(p[up + 1]);
            v[4][n] = double(q[0]), v[5][n] = double(q[1]);
            v[6][n] = double(q[up]), v[7][n] = double(q[up + 1]);
        }
        Corners c{{0, 0, 0, 0, 0, 0, 0, 0}};
        for (int n = 0; n < 8; ++n) c.v[n] = hn::Load(D(), v[n]);
        return c;
    }

    const T* m_voxels;
    const Mat3d& m_from_world;
    const Grid& m_grid;
    Vec3d m_last{};  ///< last voxel on each axis
    std::ptrdiff_t m_row, m_slice;
    bool m_gathers;  ///< offsets fit into 32 bits
};

/// The scan and the noise for Light.
template <class T>
struct VectorScan {
    Voxels<T> voxels;
    const NoiseTile::Value* tile;

    HWY_INLINE V sample(const Triple& point_mm) const {
        return voxels.sample(voxels.to_voxel(point_mm));
    }

#if HWY_TARGET == HWY_SCALAR
    HWY_INLINE Noise noise(const Triple& q) const {
        const NoiseTile::Value n =
            NoiseTile::instance().at({hn::GetLane(q.x.v), hn::GetLane(q.y.v), hn::GetLane(q.z.v)});
        return {to_double(n.slope), double(n.value)};
    }
#else
    /// Same as NoiseTile::at. A sample is four floats, so the lanes of a small vector are its
    /// components, and pixels follow one after the other.
    HWY_INLINE Noise noise(const Triple& q) const {
        using Four = hn::FixedTag<float, 4>;
        const Four four;
        HWY_ALIGN std::int32_t low[3][kLanes], high[3][kLanes];
        HWY_ALIGN float f[3][kLanes], mixed[kLanes][4];
        split(q.x, low[0], high[0], f[0], 1);
        split(q.y, low[1], high[1], f[1], NoiseTile::kSamples);
        split(q.z, low[2], high[2], f[2], NoiseTile::kSamples * NoiseTile::kSamples);
        const auto lerp = [](auto a, auto b, auto s)
                              HWY_ATTR { return hn::Add(a, hn::Mul(s, hn::Sub(b, a))); };
        for (std::size_t n = 0; n < kLanes; ++n) {
            const auto fx = hn::Set(four, f[0][n]);
            const auto row = [&](std::int32_t begin) HWY_ATTR {
                const auto at = [&](std::int32_t i)
                                    HWY_ATTR { return hn::LoadU(four, &tile[begin + i].slope.x); };
                return lerp(at(low[0][n]), at(high[0][n]), fx);
            };
            const auto fy = hn::Set(four, f[1][n]);
            const auto below = lerp(row(low[1][n] + low[2][n]), row(high[1][n] + low[2][n]), fy);
            const auto above = lerp(row(low[1][n] + high[2][n]), row(high[1][n] + high[2][n]), fy);
            hn::Store(lerp(below, above, hn::Set(four, f[2][n])), four, mixed[n]);
        }
        const Floats floats;
        hn::Vec<Floats> x, y, z, value;
        hn::LoadInterleaved4(floats, mixed[0], x, y, z, value);
        const D d;
        return {{hn::PromoteTo(d, x), hn::PromoteTo(d, y), hn::PromoteTo(d, z)},
                hn::PromoteTo(d, value)};
    }

    /// Neighbouring samples on one axis, times their stride, and the position between them.
    static HWY_INLINE void split(V q, std::int32_t* low, std::int32_t* high, float* f, int stride) {
        constexpr int kSamples = NoiseTile::kSamples;
        const V position = q * (kSamples / NoiseTile::kCells), whole = hn::Floor(position.v);
        hn::Store(hn::DemoteTo(Floats(), (position - whole).v), Floats(), f);
        const V periods = hn::Floor((whole * (1.0 / kSamples)).v);  // exact: a power of two
        const V first = whole - periods * kSamples;
        const V next = first + 1;
        hn::Store(hn::DemoteTo(Ints(), (first * stride).v), Ints(), low);
        const V wrapped = where_more(next, kSamples - 1, 0, next);
        hn::Store(hn::DemoteTo(Ints(), (wrapped * stride).v), Ints(), high);
    }
#endif
};

/// No lane has raw tissue.
struct NoWounds {
    HWY_INLINE V operator()(Triple&, Triple&, V) const { return 0; }
};

/// Hits in lanes; the last one is repeated.
struct Pack {
    V t;
    Triple point_mm, normal, direction;

    static HWY_INLINE Pack load(const LookHit* hits, std::size_t count) {
        HWY_ALIGN double a[10][kLanes];
        for (std::size_t n = 0; n < kLanes; ++n) {
            const LookHit& h = hits[std::min(n, count - 1)];
            a[0][n] = h.t;
            for (int c = 0; c < 3; ++c) {
                a[1 + c][n] = h.point_mm[c];
                a[4 + c][n] = h.normal[c];
                a[7 + c][n] = h.direction[c];
            }
        }
        const D d;
        return {hn::Load(d, a[0]),
                {hn::Load(d, a[1]), hn::Load(d, a[2]), hn::Load(d, a[3])},
                {hn::Load(d, a[4]), hn::Load(d, a[5]), hn::Load(d, a[6])},
                {hn::Load(d, a[7]), hn::Load(d, a[8]), hn::Load(d, a[9])}};
    }
};

HWY_INLINE void store(const Triple& v, double (&a)[3][kLanes]) {
    hn::Store(v.x.v, D(), a[0]);
    hn::Store(v.y.v, D(), a[1]);
    hn::Store(v.z.v, D(), a[2]);
}

HWY_INLINE Triple load_offsets(std::span<const Vec3f> rest, std::size_t begin) {
    if (rest.empty()) return Vec3d{0, 0, 0};
    HWY_ALIGN double a[3][kLanes];
    for (std::size_t n = 0; n < kLanes; ++n) {
        const Vec3f r = rest[std::min(begin + n, rest.size() - 1)];
        a[0][n] = double(r.x), a[1][n] = double(r.y), a[2][n] = double(r.z);
    }
    return {hn::Load(D(), a[0]), hn::Load(D(), a[1]), hn::Load(D(), a[2])};
}

template <class T>
HWY_INLINE void shade_all(const LookInput& input, std::span<const LookHit> hits,
                          std::span<const Vec3f> rest, const T* voxels, Vec3d* light) {
    const VectorScan<T> scan{{input.scan, voxels}, NoiseTile::instance().samples().data()};
    const Light<VectorScan<T>> look(input, scan);
    for (std::size_t begin = 0; begin < hits.size(); begin += kLanes) {
        const std::size_t count = std::min(kLanes, hits.size() - begin);
        const Pack hit = Pack::load(&hits[begin], count);
        const Coat own = look.coat(hit.t, hit.point_mm, hit.normal,
                                   hit.point_mm - load_offsets(rest, begin), NoWounds());
        HWY_ALIGN double rgb[3][kLanes];
        store(look.shade(hit.t, hit.point_mm, hit.direction, {hit.point_mm, hit.normal}, own), rgb);
        for (std::size_t n = 0; n < count; ++n)
            light[begin + n] = {rgb[0][n], rgb[1][n], rgb[2][n]};
    }
}

void shade(const LookInput& input, std::span<const LookHit> hits, std::span<const Vec3f> rest,
           Vec3d* light) {
    const auto& voxels = input.scan.volume.voxels;
    if (const auto* v = std::get_if<0>(&voxels))
        shade_all(input, hits, rest, v->data(), light);
    else
        shade_all(input, hits, rest, std::get_if<1>(&voxels)->data(), light);
}

/// Normal of a field with a slope [per mm].
HWY_INLINE Triple normal_of(const Triple& slope, const Triple& direction, bool is_rising) {
    constexpr double kMinSlope = 1e-9;
    const V length = norm(slope);
    const Triple n = ((is_rising ? -1.0 : 1.0) / length) * slope;
    const V along = dot(n, direction);
    const Triple flat = n - along * direction;
    const V left = norm(flat);
    const Triple turned = where_more(left, kMinSlope, (1 / left) * flat, -direction);
    return where_more(length, kMinSlope, where_more(along, 0, turned, n), -direction);
}

template <class T>
HWY_INLINE void find_all(const ScanView& scan, Polarity polarity, const T* data,
                         std::span<LookHit> hits) {
    const Voxels<T> voxels(scan, data);
    const Grid& grid = scan.volume.grid;
    const Vec3d s = grid.spacing_mm;
    for (std::size_t begin = 0; begin < hits.size(); begin += kLanes) {
        const std::size_t count = std::min(kLanes, hits.size() - begin);
        const Pack hit = Pack::load(&hits[begin], count);
        const Triple g = voxels.gradient(voxels.to_voxel(hit.point_mm));
        const Triple slope = product(grid.direction, {g.x / s.x, g.y / s.y, g.z / s.z});
        HWY_ALIGN double n[3][kLanes];
        store(normal_of(slope, hit.direction, polarity == Polarity::Rising), n);
        for (std::size_t k = 0; k < count; ++k)
            hits[begin + k].normal = {n[0][k], n[1][k], n[2][k]};
    }
}

void normals(const ScanView& scan, Polarity polarity, std::span<LookHit> hits) {
    if (const auto* v = std::get_if<0>(&scan.volume.voxels))
        find_all(scan, polarity, v->data(), hits);
    else
        find_all(scan, polarity, std::get_if<1>(&scan.volume.voxels)->data(), hits);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace pliant::render
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pliant::render {
namespace {
HWY_EXPORT(shade);
HWY_EXPORT(normals);
}  // namespace

void shade_hits(const LookInput& input, std::span<const LookHit> hits, std::span<const Vec3f> rest,
                Vec3d* light) {
    HWY_DYNAMIC_DISPATCH(shade)(input, hits, rest, light);
}
void find_normals(const ScanView& scan, Polarity polarity, std::span<LookHit> hits) {
    HWY_DYNAMIC_DISPATCH(normals)(scan, polarity, hits);
}

}  // namespace pliant::render
#endif
