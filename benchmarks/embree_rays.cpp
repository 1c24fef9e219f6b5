// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "embree_rays.h"

#include <embree3/rtcore.h>

#include <cstring>
#include <limits>
#include <vector>

#include "interleaved.h"

namespace pliant::bench {
namespace {

constexpr std::size_t kWidth = 16;

}  // namespace

struct EmbreeRays::Impl {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    double build_s = 0;
    std::vector<RTCRayHit16> rays;
};

EmbreeRays::EmbreeRays(const IsoMesh& mesh, Vec3d eye_mm, std::span<const Vec3d> directions)
    : m_impl(std::make_unique<Impl>()) {
    Impl& e = *m_impl;
    e.device = rtcNewDevice("threads=1");
    e.build_s = seconds_of([&] {
        e.scene = rtcNewScene(e.device);
        RTCGeometry geometry = rtcNewGeometry(e.device, RTC_GEOMETRY_TYPE_TRIANGLE);
        void* points =
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                    sizeof(Vec3f), mesh.points_mm.size());
        std::memcpy(points, mesh.points_mm.data(), mesh.points_mm.size() * sizeof(Vec3f));
        void* triangles =
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                    3 * sizeof(unsigned), mesh.triangles.size());
        std::memcpy(triangles, mesh.triangles.data(), mesh.triangles.size() * 3 * sizeof(unsigned));
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(e.scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(e.scene);
    });
    e.rays.resize((directions.size() + kWidth - 1) / kWidth);
    for (std::size_t n = 0; n < e.rays.size() * kWidth; ++n) {
        const Vec3d d = directions[std::min(n, directions.size() - 1)];
        RTCRay16& ray = e.rays[n / kWidth].ray;
        const std::size_t lane = n % kWidth;
        ray.org_x[lane] = float(eye_mm.x);
        ray.org_y[lane] = float(eye_mm.y);
        ray.org_z[lane] = float(eye_mm.z);
        ray.dir_x[lane] = float(d.x);
        ray.dir_y[lane] = float(d.y);
        ray.dir_z[lane] = float(d.z);
        ray.tnear[lane] = 0;
        ray.time[lane] = 0;
        ray.mask[lane] = ~0u;
        ray.flags[lane] = 0;
    }
}

EmbreeRays::~EmbreeRays() {
    rtcReleaseScene(m_impl->scene);
    rtcReleaseDevice(m_impl->device);
}

double EmbreeRays::build_seconds() const {
    return m_impl->build_s;
}

void EmbreeRays::cast(std::span<float> distances) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(64) int valid[kWidth];
    std::fill(valid, valid + kWidth, -1);
    for (std::size_t p = 0; p < m_impl->rays.size(); ++p) {
        RTCRayHit16& packet = m_impl->rays[p];
        std::fill(packet.ray.tfar, packet.ray.tfar + kWidth,
                  std::numeric_limits<float>::infinity());
        std::fill(packet.hit.geomID, packet.hit.geomID + kWidth, RTC_INVALID_GEOMETRY_ID);
        rtcIntersect16(valid, m_impl->scene, &context, &packet);
        const std::size_t begin = p * kWidth;
        for (std::size_t i = 0; i < kWidth && begin + i < distances.size(); ++i)
            distances[begin + i] = packet.ray.tfar[i];
    }
}

}  // namespace pliant::bench
