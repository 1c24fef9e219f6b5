// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/tool.h>

namespace pliant {

std::string_view name_of(PushStatus status) {
    switch (status) {
        case PushStatus::Applied:
            return "applied";
        case PushStatus::Limited:
            return "limited";
        case PushStatus::Rejected:
            return "rejected";
    }
    return {};
}

std::string_view name_of(LimitedBy limit) {
    switch (limit) {
        case LimitedBy::None:
            return "none";
        case LimitedBy::Bone:
            return "bone";
        case LimitedBy::Movement:
            return "movement";
        case LimitedBy::Wall:
            return "wall";
        case LimitedBy::Fold:
            return "fold";
    }
    return {};
}

}  // namespace pliant
