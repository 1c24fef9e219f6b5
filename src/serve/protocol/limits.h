// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Limits on clients, beyond which they are dropped (docs/developers/protocol.md, "Limits").

#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace pliant::serve {

// Close codes of the WebSocket.
inline constexpr int kCloseGoingAway = 1001;
inline constexpr int kCloseProtocol = 4000;
inline constexpr int kCloseTooLarge = 4001;
inline constexpr int kCloseFlood = 4002;
inline constexpr int kCloseStalled = 4003;
inline constexpr int kCloseFull = 4004;
inline constexpr int kCloseReplaced = 4005;

// Clients.
inline constexpr int kMaxClients = 32;                ///< connected
inline constexpr std::size_t kMaxSeats = 64;          ///< including clients that may come back
inline constexpr std::size_t kMaxWaiting = 64;        ///< waiting commands of a client
inline constexpr std::size_t kMaxWaitingCameras = 8;  ///< texts before which none is added
inline constexpr std::size_t kMaxTexts = 1000;        ///< unread answers of a client
inline constexpr std::chrono::seconds kHelloTime{5};
inline constexpr std::chrono::seconds kStallTime{15};
inline constexpr std::chrono::seconds kAwayTime{120};

// Messages of a client.
inline constexpr std::size_t kMaxMessageBytes = 64 * 1024;
inline constexpr int kMaxDepthLayers = 64;
inline constexpr double kMaxThreshold = 65504;  ///< the largest half: clients see no larger values
inline constexpr double kMinReplaySpeed = 0.01, kMaxReplaySpeed = 100;
inline constexpr double kMessagesPerSecond = 240, kMessageBurst = 600;
inline constexpr double kBytesPerSecond = 1 << 20, kByteBurst = 4 << 20;
inline constexpr int kMaxUntaken = 64;  ///< messages that the scene's owner has not processed

// Connections.
inline constexpr int kMaxConnections = 128;
inline constexpr std::size_t kMaxHeaderBytes = 8 * 1024;
inline constexpr std::chrono::seconds kHttpTime{10};    ///< for a request, and between two
inline constexpr std::chrono::seconds kCloseTime{2};    ///< for the closing handshake
inline constexpr std::chrono::seconds kSilentTime{30};  ///< without any message

// Files.
inline constexpr int kMaxUploadFiles = 4096;  ///< of one scan
inline constexpr std::size_t kMaxFileName = 200;
inline constexpr std::uint64_t kSpareDiskBytes = std::uint64_t(256) << 20;  ///< must stay free
inline constexpr std::uint64_t kMaxKeptBytes = std::uint64_t(64) << 30;     ///< kept beside a
                                                                            ///< session
inline constexpr std::chrono::seconds kUploadPause{60};    ///< between two files of one scan
inline constexpr std::chrono::seconds kTransferGrace{30};  ///< beyond that, the minimum rate is:
inline constexpr double kTransferBytesPerSecond = 64 * 1024;

// Work in one step of the scene.
inline constexpr std::chrono::milliseconds kCommandTime{25};
inline constexpr std::chrono::milliseconds kRelaxTime{10};
inline constexpr std::chrono::milliseconds kSweepTime{100};  ///< of a sweep that takes long, while
                                                             ///< no command waits
inline constexpr std::chrono::milliseconds kNearTime{25};  ///< for a volume near the tissue's state
inline constexpr std::int64_t kNearElements = std::int64_t(1) << 20;  ///< in that time, at first
inline constexpr std::chrono::milliseconds kMotionTime{40};  ///< for a tissue with simulated time
inline constexpr double kMaxOwedMs = 100;                    ///< maximum lag of that tissue's time
inline constexpr std::chrono::milliseconds kChecksumPause{100};
inline constexpr std::int64_t kCoarseFromVoxels = std::int64_t(4) << 20;
inline constexpr std::int64_t kMaxBatchVoxels = std::int64_t(4) << 20;
inline constexpr std::int64_t kMaxOverlayVoxels = std::int64_t(1) << 19;  ///< total of all clients
inline constexpr std::int64_t kMaxRestNodes = std::int64_t(1) << 17;  ///< total of all clients, 8
                                                                      ///< bytes each
/// Sources of deformed voxels are kept this long after their last use, because finding them again
/// rewrites all deformed voxels.
inline constexpr std::chrono::seconds kSourcesTime{5};

// Vessels.
inline constexpr std::size_t kMaxSurfaceNodes = std::size_t(1) << 18;
inline constexpr double kMaxInsert_mm_s = 100, kMaxRotate_deg_s = 720, kMaxBend_deg = 180;

// Labels and marks.
inline constexpr std::int64_t kMaxLabelVoxels = std::int64_t(1) << 19;  ///< sent per step
inline constexpr std::size_t kMaxLabels = 2047;  ///< half floats are exact for their numbers
inline constexpr std::size_t kMaxMarks = 256;
inline constexpr std::size_t kMaxMarkPoints = 500;

// Paths through the lumen, searched in the background.
inline constexpr std::size_t kMaxPathSearches = 2;  ///< simultaneous searches, one per client
inline constexpr std::int64_t kMaxPathVoxels = 24'000'000;
inline constexpr std::chrono::seconds kPathTime{20};

}  // namespace pliant::serve
