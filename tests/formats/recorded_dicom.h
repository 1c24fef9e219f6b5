// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Hashes of volumes that were recorded with ITK 5.2 and GDCM 3.0.21, before Pliant read pixels by
// itself.

#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace pliant::test {

using Recorded = std::map<std::string, std::string>;

/// The folder dicom_thorax_10 of the shared data.
inline const std::string kSharedFolder = "22f604c952cae613";

/// Byte order, type of the pixels, rescaling.
inline const Recorded kUncompressed = {
    {"big int16 fraction", "be1885c45a82630d"},     {"big int16 half", "37d8afed969cfe93"},
    {"big int16 negative", "ba29b4926ba7feae"},     {"big int16 plain", "c3984b6666a3f817"},
    {"big int16 scaled", "00472b6bc2e3062f"},       {"big int16 shifted", "9904228973c71416"},
    {"big int32 fraction", "7aa7ea64712bf760"},     {"big int32 half", "f92939e08bdab4ed"},
    {"big int32 negative", "b90f8f576cce04d5"},     {"big int32 plain", "5be062f662687b24"},
    {"big int32 scaled", "c0d61e391e6389aa"},       {"big int32 shifted", "efee51e954e207d5"},
    {"big int8 fraction", "53e0cb8c7e7d6f5e"},      {"big int8 half", "822232488ba72fae"},
    {"big int8 negative", "b54e0a4433671b46"},      {"big int8 plain", "21b9474daa89beae"},
    {"big int8 scaled", "2f961c9db99cb6ca"},        {"big int8 shifted", "b6411252febec857"},
    {"big uint16 fraction", "dbdea0df57c1cc0c"},    {"big uint16 half", "eb4c50a3c5dd88cf"},
    {"big uint16 negative", "9f384e0ef4a681d0"},    {"big uint16 plain", "92ca112488b3051d"},
    {"big uint16 scaled", "c53436c185946e6a"},      {"big uint16 shifted", "d7d2ccd60b854475"},
    {"big uint32 fraction", "3974d57c0e19298d"},    {"big uint32 half", "1e1e91ed87678e88"},
    {"big uint32 negative", "2abc38202af182de"},    {"big uint32 plain", "474184a5e88b65a0"},
    {"big uint32 scaled", "f3dea8944374a15b"},      {"big uint32 shifted", "ac4510c03fe9470b"},
    {"big uint8 fraction", "5bb7968beded2c5b"},     {"big uint8 half", "762f495d86e5d786"},
    {"big uint8 negative", "45b478e3449bc8be"},     {"big uint8 plain", "2c4e21ff243e5ab0"},
    {"big uint8 scaled", "dab1ad866276c3b5"},       {"big uint8 shifted", "79b373734ca7bbdd"},
    {"little int16 fraction", "827867ad88c69da3"},  {"little int16 half", "3a41500e06517fc1"},
    {"little int16 negative", "a64647e785d42434"},  {"little int16 plain", "9e05d55e93e6dc6e"},
    {"little int16 scaled", "38c98fa6173ca2d9"},    {"little int16 shifted", "4d7b21bdba131a8a"},
    {"little int32 fraction", "32c161fba7afd2ed"},  {"little int32 half", "f191dff1ec0440a2"},
    {"little int32 negative", "e0560e357198e227"},  {"little int32 plain", "16cfcf8cfcb46d8b"},
    {"little int32 scaled", "0914af4f9aca4e44"},    {"little int32 shifted", "8323b1e1771def4d"},
    {"little int8 fraction", "53e0cb8c7e7d6f5e"},   {"little int8 half", "822232488ba72fae"},
    {"little int8 negative", "b54e0a4433671b46"},   {"little int8 plain", "21b9474daa89beae"},
    {"little int8 scaled", "2f961c9db99cb6ca"},     {"little int8 shifted", "b6411252febec857"},
    {"little uint16 fraction", "f7f0786fa6e71956"}, {"little uint16 half", "d348e135af4a8b01"},
    {"little uint16 negative", "1f951a1ff28a0e83"}, {"little uint16 plain", "8a9aa4b8b97f8eb3"},
    {"little uint16 scaled", "ed7e839183c3a640"},   {"little uint16 shifted", "33de75a63329e033"},
    {"little uint32 fraction", "0f123dea55bea72e"}, {"little uint32 half", "d129b3a1af5748ef"},
    {"little uint32 negative", "2e664b34d7879b46"}, {"little uint32 plain", "e12a6b342915dda1"},
    {"little uint32 scaled", "7ea1416b38456a81"},   {"little uint32 shifted", "1843599935b81fbc"},
    {"little uint8 fraction", "5bb7968beded2c5b"},  {"little uint8 half", "762f495d86e5d786"},
    {"little uint8 negative", "45b478e3449bc8be"},  {"little uint8 plain", "2c4e21ff243e5ab0"},
    {"little uint8 scaled", "dab1ad866276c3b5"},    {"little uint8 shifted", "79b373734ca7bbdd"},
};

/// Bits of 16 that are stored; the others are not zero.
inline const Recorded kBitsStored = {
    {"1 signed", "d6d305d0c62d90f8"},  {"1 unsigned", "9f9ede5f7bd1f44c"},
    {"10 signed", "c34492cc1059bbf9"}, {"10 unsigned", "3c96d439b3f679bb"},
    {"12 signed", "724cbd7604d68995"}, {"12 unsigned", "3d705dd8a5964592"},
    {"15 signed", "87c1ab3ee172016c"}, {"15 unsigned", "64c5ff99ca8d5e43"},
    {"8 signed", "f6ac08b356b58f78"},  {"8 unsigned", "c7e5b4191d11302d"},
};

/// Rescale Slope of the first and of the second slice. 0 counts as 1.
inline const Recorded kSlopes = {
    {"0 and 0.3", "785452fbfbd5d2cd"},   {"0.7 and 0.3", "824556c38530ab03"},
    {"1 and 0.3", "785452fbfbd5d2cd"},   {"1e10 and 0.3", "e444d0218d8545ba"},
    {"1e5 and 0.3", "f086d9ff8fc1c2d1"},
};

/// Transfer syntax, value representation and bits of the pixels.
inline const Recorded kWords = {
    {".1.2.1 OB16", "2803eebe60e7a63a"}, {".1.2.1 OB32", "53cd4c4b5fad4b7a"},
    {".1.2.1 OB8", "1f3c7f6f2a7c5778"},  {".1.2.1 OW16", "2803eebe60e7a63a"},
    {".1.2.1 OW32", "53cd4c4b5fad4b7a"}, {".1.2.1 OW8", "1f3c7f6f2a7c5778"},
    {".1.2.2 OB16", "2803eebe60e7a63a"}, {".1.2.2 OB32", "53cd4c4b5fad4b7a"},
    {".1.2.2 OB8", "1f3c7f6f2a7c5778"},  {".1.2.2 OW16", "89d781e5dd4dcb29"},
    {".1.2.2 OW32", "7514faeef06de514"}, {".1.2.2 OW8", "5ccfe0e52a8406cf"},
};

/// Kind of pixels; transfer syntax too where the codec is lossy.
inline const Recorded kCompressed = {
    {"4.50 u8", "0406c48fa5b206f4"},    {"4.51 u12", "2e4a99a9696f2771"},
    {"4.51 u8", "0406c48fa5b206f4"},    {"s12", "410cc4e61aa89840"},
    {"s12 scaled", "af775138826937cd"}, {"s16", "f7982760cc6aa6ec"},
    {"s16 scaled", "8fc89ba3f484317d"}, {"s8", "c9637d81257b7b5a"},
    {"s8 scaled", "5040cf64fe1c2f02"},  {"u12", "68e208eada87f9d4"},
    {"u12 scaled", "fa7365cb17f13d9d"}, {"u16", "e900132522e67b97"},
    {"u16 scaled", "c463860ea28b7499"}, {"u8", "a4ef323f605d5dfa"},
    {"u8 scaled", "05bae1ec77e397a9"},
};

/// Codestream, and the header's values. JPEG-LS of 8 bits in 16 crashed GDCM: these rows are those
/// of the codestream in 8 bits.
inline const Recorded kDisagreeing = {
    {"jpeg_2000 s12 as s16/16", "410cc4e61aa89840"},
    {"jpeg_2000 s12 as u12/16", "00647b4378e5ca00"},
    {"jpeg_2000 s16 as u16/16", "0891323c1748f61e"},
    {"jpeg_2000 u12 as s12/16", "d7394a4e03fc3523"},
    {"jpeg_2000 u12 as u16/16", "68e208eada87f9d4"},
    {"jpeg_2000 u16 as u12/16", "e900132522e67b97"},
    {"jpeg_2000 u8 as u16/16", "a4ef323f605d5dfa"},
    {"jpeg_2000 u8 as u8/16", "a4ef323f605d5dfa"},
    {"jpeg_lossless s12 as s16/16", "410cc4e61aa89840"},
    {"jpeg_lossless s12 as u12/16", "00647b4378e5ca00"},
    {"jpeg_lossless s16 as u16/16", "0891323c1748f61e"},
    {"jpeg_lossless u12 as s12/16", "d7394a4e03fc3523"},
    {"jpeg_lossless u12 as u16/16", "68e208eada87f9d4"},
    {"jpeg_lossless u16 as u12/16", "b8f4ec66ca92ccd1"},
    {"jpeg_lossless u8 as u16/16", "a4ef323f605d5dfa"},
    {"jpeg_lossless u8 as u8/16", "a4ef323f605d5dfa"},
    {"jpeg_ls s12 as s16/16", "410cc4e61aa89840"},
    {"jpeg_ls s12 as u12/16", "00647b4378e5ca00"},
    {"jpeg_ls s16 as u16/16", "0891323c1748f61e"},
    {"jpeg_ls u12 as s12/16", "d7394a4e03fc3523"},
    {"jpeg_ls u12 as u16/16", "68e208eada87f9d4"},
    {"jpeg_ls u16 as u12/16", "b8f4ec66ca92ccd1"},
    {"jpeg_ls u8 as u16/16", "a4ef323f605d5dfa"},
    {"jpeg_ls u8 as u8/16", "a4ef323f605d5dfa"},
};

}  // namespace pliant::test
