// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The binary messages as a client reads them.

#include <cstring>

#include "fuzz/fuzz.h"
#include "hub/read_frames.h"

using namespace pliant;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view frame = fuzz::text_of(data, size);
    const auto header = serve::read_frame_header(frame);
    const auto box = serve::read_box(frame);
    const auto tools = serve::read_tools(frame);
    fuzz::expect(header || (!box && !tools), "no payload without a header");
    fuzz::expect(!box || box->size() * 2 == header->payload_bytes, "as many voxels as announced");
    if (!tools) return 0;
    fuzz::expect(tools->size() == header->count, "as many tools as announced");
    const std::string again = serve::tools_frame(*tools, *header);
    const auto same = serve::read_tools(again);
    fuzz::expect(same && same->size() == tools->size(), "the same tools again");
    return 0;
}
