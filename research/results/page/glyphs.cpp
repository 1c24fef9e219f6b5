// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "glyphs.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

namespace pliant::results {
namespace {

struct Entry {
    std::string_view character;
    /// Vertices as pairs of digits, x and y. ' ' separates strokes; '~' marks a stroke with rounded
    /// inner corners.
    std::string_view strokes;
};

constexpr Entry kFont[] = {
    {"0", "~20304145361605011020"},
    {"1", "112026"},
    {"2", "~0110304142331506 0646"},
    {"3", "~01103041423323 ~23334445361605"},
    {"4", "36300444"},
    {"5", "400003 ~0312324345361605"},
    {"6", "~402002040516364544331304"},
    {"7", "004016"},
    {"8", "~20304142331302011020 ~23334445361605041323"},
    {"9", "~062644424130100102133342"},
    {"a", "4246 ~4332120305163645"},
    {"b", "0006 ~0312324345361605"},
    {"c", "~4332120305163645"},
    {"d", "4046 ~4332120305163645"},
    {"e", "0444 ~444332120305163645"},
    {"f", "~301016 0232"},
    {"g", "~4332120305163645 ~42472817"},
    {"h", "0006 ~03123243 ~324346"},
    {"i", "0206 00"},
    {"j", "~121808 10"},
    {"k", "0006 4204 2346"},
    {"l", "~000516"},
    {"m", "0206 ~0312223336 ~3342526366"},
    {"n", "0206 ~0312324346"},
    {"o", "~22324345361605031222"},
    {"p", "0208 ~0312324345361605"},
    {"q", "4248 ~4332120305163645"},
    {"r", "0206 ~031232"},
    {"s", "~43321203143445361605"},
    {"t", "~10152636 0232"},
    {"u", "~0205163645 4246"},
    {"v", "022642"},
    {"w", "0216325662"},
    {"x", "0246 4206"},
    {"y", "0226 4218"},
    {"z", "02420646"},
    {"A", "062046 1434"},
    {"B", "0006 ~003041423303 ~033344453606"},
    {"C", "~4130100105163645"},
    {"D", "0006 ~003041453606"},
    {"E", "40000646 0333"},
    {"F", "400006 0333"},
    {"G", "~413010010516364543 4323"},
    {"H", "0006 4046 0343"},
    {"I", "0020 1016 0626"},
    {"J", "~3035261605"},
    {"K", "0006 4004 1346"},
    {"L", "000646"},
    {"M", "0600346066"},
    {"N", "06004640"},
    {"O", "~20304145361605011020"},
    {"P", "0006 ~003041423303"},
    {"Q", "~20304145361605011020 2446"},
    {"R", "0006 ~003041423303 2346"},
    {"S", "~413010010213334445361605"},
    {"T", "0040 2026"},
    {"U", "~000516364540"},
    {"V", "002640"},
    {"W", "0016315660"},
    {"X", "0046 4006"},
    {"Y", "002340 2326"},
    {"Z", "00400646"},
    {".", "06"},
    {",", "1607"},
    {":", "03 06"},
    {";", "13 1607"},
    {"?", "~01103041422325 26"},
    {"!", "0004 06"},
    {"'", "0001"},
    {"+", "0343 2125"},
    {"-", "0333"},
    {"=", "0242 0444"},
    {"/", "0640"},
    {"%", "0640 ~1011010010 ~3545463635"},
    {"(", "~20010526"},
    {")", "~00212506"},
    {"[", "20000626"},
    {"]", "00202606"},
    {"<", "311335"},
    {">", "113315"},
    {"\u2212", "0343"},         // minus
    {"\u2013", "0343"},         // en dash
    {"\u2026", "06 26 46"},     // ellipsis
    {"\u00b0", "~1021120110"},  // degree
    {"\u00d7", "0235 3205"},    // times
    {"\u00b1", "0242 2024 0646"},
    {"\u00b7", "03"},                   // middle dot
    {"\u00b5", "0208 ~05163645 4246"},  // micro
    {"\u2192", "0353 315335"},          // arrow to the right
    {"\u2264", "311335 0636"},          // less or equal
    {"\u2265", "113315 1646"},          // greater or equal
};

constexpr double kSpaceWidth = 1.5;

/// Chaikin's corner cutting; the ends don't move.
void round_corners(std::vector<GlyphStroke::Vertex>& line) {
    if (line.size() < 3) return;
    std::vector<GlyphStroke::Vertex> cut{line.front()};
    for (std::size_t n = 1; n + 1 < line.size(); ++n) {
        const auto towards = [&](GlyphStroke::Vertex from, GlyphStroke::Vertex to) {
            constexpr double kShare = 0.3;
            return GlyphStroke::Vertex{from.x + kShare * (to.x - from.x),
                                       from.y + kShare * (to.y - from.y)};
        };
        cut.push_back(towards(line[n], line[n - 1]));
        cut.push_back(towards(line[n], line[n + 1]));
    }
    cut.push_back(line.back());
    line = std::move(cut);
}

Glyph glyph_of(std::string_view strokes) {
    Glyph glyph;
    for (std::size_t at = 0; at < strokes.size(); ++at) {
        GlyphStroke stroke;
        const bool rounded = strokes[at] == '~';
        for (at += rounded; at + 1 < strokes.size() && strokes[at] != ' '; at += 2) {
            stroke.vertices.push_back({double(strokes[at] - '0'), double(strokes[at + 1] - '0')});
            glyph.width = std::max(glyph.width, stroke.vertices.back().x);
        }
        if (rounded)
            for (int pass = 0; pass < 2; ++pass) round_corners(stroke.vertices);
        glyph.strokes.push_back(std::move(stroke));
    }
    return glyph;
}

}  // namespace

Glyph take_glyph(std::string_view& text) {
    std::size_t bytes = 1;
    while (bytes < text.size() && (static_cast<unsigned char>(text[bytes]) & 0xC0) == 0x80) ++bytes;
    std::string_view character = text.substr(0, bytes);
    text.remove_prefix(bytes);
    if (character == " ") return {{}, kSpaceWidth};
    const auto is_it = [&](const Entry& entry) { return entry.character == character; };
    auto found = std::find_if(std::begin(kFont), std::end(kFont), is_it);
    if (found == std::end(kFont)) {
        character = "?";
        found = std::find_if(std::begin(kFont), std::end(kFont), is_it);
    }
    return glyph_of(found->strokes);
}

}  // namespace pliant::results
