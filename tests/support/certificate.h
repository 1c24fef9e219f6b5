// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A certificate that signs itself, and its key, made for one test.

#pragma once

#include <gtest/gtest.h>
#include <openssl/ec.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

namespace pliant::test {

template <class T, void (*kFree)(T*)>
struct FreeWith {
    void operator()(T* object) const { kFree(object); }
};

struct Certificate {
    std::filesystem::path file, key;
};

/// @param names  as OpenSSL writes them: "DNS:class.example,IP:127.0.0.1"
inline Certificate make_certificate(const std::filesystem::path& folder, const std::string& name,
                                    const std::string& names) {
    const Certificate made{folder / (name + ".pem"), folder / (name + ".key")};
    const std::unique_ptr<EVP_PKEY, FreeWith<EVP_PKEY, EVP_PKEY_free>> key(EVP_EC_gen("P-256"));
    const std::unique_ptr<X509, FreeWith<X509, X509_free>> x(X509_new());
    X509_set_version(x.get(), X509_VERSION_3);
    ASN1_INTEGER_set(X509_get_serialNumber(x.get()), 1);
    X509_gmtime_adj(X509_getm_notBefore(x.get()), -3600);
    X509_gmtime_adj(X509_getm_notAfter(x.get()), 3600);
    X509_set_pubkey(x.get(), key.get());
    X509_NAME* const own = X509_get_subject_name(x.get());
    X509_NAME_add_entry_by_txt(own, "CN", MBSTRING_UTF8,
                               reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1, 0);
    X509_set_issuer_name(x.get(), own);
    if (!names.empty()) {
        const std::unique_ptr<X509_EXTENSION, FreeWith<X509_EXTENSION, X509_EXTENSION_free>> names_(
            X509V3_EXT_conf_nid(nullptr, nullptr, NID_subject_alt_name, names.c_str()));
        EXPECT_TRUE(names_ && X509_add_ext(x.get(), names_.get(), -1));
    }
    EXPECT_GT(X509_sign(x.get(), key.get(), EVP_sha256()), 0);
    std::FILE* file = std::fopen(made.file.c_str(), "w");
    EXPECT_TRUE(file && PEM_write_X509(file, x.get()));
    std::fclose(file);
    file = std::fopen(made.key.c_str(), "w");
    EXPECT_TRUE(file &&
                PEM_write_PrivateKey(file, key.get(), nullptr, nullptr, 0, nullptr, nullptr));
    std::fclose(file);
    return made;
}

}  // namespace pliant::test
