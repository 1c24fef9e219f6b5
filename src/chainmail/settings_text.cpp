// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Settings as text that settings_file.cpp reads back, key by key.

#include <charconv>
#include <concepts>

#include "chainmail/settings.h"

namespace pliant {
namespace {

template <class Number>
std::string text_of(Number number) {
    if constexpr (std::same_as<Number, bool>) {
        return number ? "true" : "false";
    } else {
        char buffer[32];
        const auto end = std::to_chars(buffer, buffer + sizeof buffer, number).ptr;
        return std::string(buffer, end);
    }
}

}  // namespace

std::string settings_text(const ChainMailSettings& s) {
    std::string text;
    const auto table = [&](const char* name) { text += std::string("[") + name + "]\n"; };
    const auto line = [&](const char* key, const auto& value) {
        text += std::string(key) + " = " + text_of(value) + "\n";
    };
    table("material");
    text += "law = \"" + s.law + "\"\n";
    line("offset", s.offset);
    line("bone_threshold_hu", s.bone_threshold_hu);
    line("max_movement_mm", s.max_movement_mm);
    line("yield", s.yield);
    text += s.limits == LinkLimits::Box ? "limits = \"box\"\n" : "limits = \"rounded\"\n";
    table("push");
    line("scale", s.scale);
    table("lattice");
    line("brick_size", s.brick_size);
    line("bounded", s.bounded);
    line("max_elements", s.max_elements);
    table("history");
    line("max_steps", s.history_max_steps);
    line("max_mb", s.history_max_mb);
    table("air");
    line("enabled", s.air_enabled);
    line("threshold_hu", s.air_threshold_hu);
    line("compress", s.air_compress);
    line("stretch", s.air_stretch);
    line("shear", s.air_shear);
    return text;
}

}  // namespace pliant
