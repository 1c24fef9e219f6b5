// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A table of a scene file: keys are taken out, and what is left over is unknown. What is wrong
// first is said.

#pragma once

#include <pliant/result.h>
#include <pliant/text_input.h>
#include <pliant/vec.h>
#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace pliant::catheter {

inline std::string number_text(double value) {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof(text), value, std::chars_format::general, 9);
    return {text, end.ptr};
}

class VesselTable {
  public:
    VesselTable(const std::string& file, const std::string& name, const toml::table* table,
                Status& status)
        : m_file(file), m_name(name), m_table(table), m_status(status) {}
    VesselTable(const VesselTable&) = delete;
    VesselTable& operator=(const VesselTable&) = delete;

    /// Once all keys have been taken out. (A destructor may not run out of memory.)
    void finish() {
        if (!m_table || !m_status.ok()) return;
        for (const auto& [key, node] : *m_table)
            if (std::find(m_known.begin(), m_known.end(), key.str()) == m_known.end())
                fail(shown(key.str()), "unknown, expected one of " + names());
    }

    bool has(const char* key) const { return m_table && m_table->contains(key); }
    void number(const char* key, double& out, double least, double most) {
        const toml::node* node = find(key);
        if (!node) return;
        const auto value = node->value<double>();
        if (!node->is_number() || !value || !(*value >= least && *value <= most))
            return fail(key, "expected a number from " + number_text(least) + " to " +
                                 number_text(most) + ", found " + found(*node));
        out = *value;
    }
    void whole(const char* key, int& out, int least, int most) {
        const toml::node* node = find(key);
        if (!node) return;
        const auto value = node->value_exact<std::int64_t>();
        if (!value || *value < least || *value > most)
            return fail(key, "expected a whole number from " + std::to_string(least) + " to " +
                                 std::to_string(most) + ", found " + found(*node));
        out = int(*value);
    }
    void flag(const char* key, bool& out) {
        const toml::node* node = find(key);
        if (!node) return;
        if (!node->is_boolean()) return fail(key, "expected true or false, found " + found(*node));
        out = node->value_or(false);
    }
    void text(const char* key, std::string& out) {
        const toml::node* node = find(key);
        if (!node) return;
        if (!node->is_string())
            return fail(key, "expected a text in quotes, found " + found(*node));
        out = node->value_or(std::string());
    }
    /// @param[out] out  as many numbers as `count`
    void numbers(const char* key, std::vector<double>& out, std::size_t count) {
        const toml::node* node = find(key);
        if (!node) return;
        const toml::array* array = node->as_array();
        std::vector<double> values;
        if (array)
            for (const toml::node& item : *array)
                if (item.is_number()) values.push_back(item.value_or(0.0));
        if (!array || values.size() != array->size() || values.size() != count)
            return fail(key, "expected " + std::to_string(count) + " numbers in brackets, found " +
                                 found(*node));
        out = values;
    }
    void place(const char* key, Vec3d& out) {
        std::vector<double> values;
        numbers(key, values, 3);
        if (values.size() == 3) out = {values[0], values[1], values[2]};
    }
    void places(const char* key, std::vector<Vec3d>& out) {
        const toml::node* node = find(key);
        if (!node) return;
        const toml::array* array = node->as_array();
        if (!array) return fail(key, "expected places in brackets, found " + found(*node));
        for (const toml::node& item : *array) {
            const toml::array* three = item.as_array();
            if (!three || three->size() != 3 ||
                !std::all_of(three->begin(), three->end(),
                             [](const toml::node& n) { return n.is_number(); }))
                return fail(key, "expected places of three numbers, found " + found(item));
            const auto at = [&](std::size_t n) { return (*three)[n].value_or(0.0); };
            out.push_back({at(0), at(1), at(2)});
        }
    }
    void wholes(const char* key, std::vector<int>& out) {
        const toml::node* node = find(key);
        if (!node) return;
        std::vector<int> values;
        if (const toml::array* array = node->as_array())
            for (const toml::node& item : *array)
                if (const auto value = item.value_exact<std::int64_t>();
                    value && std::in_range<int>(*value))
                    values.push_back(int(*value));
        if (values.empty() || values.size() != node->as_array()->size())
            return fail(key, "expected whole numbers in brackets, found " + found(*node));
        out = values;
    }
    void bound(const char* key, std::optional<double>& out) {
        double value = 0;
        if (!has(key)) return (void)find(key);
        number(key, value, 0, 1e6);
        out = value;
    }
    void fail(const std::string& key, const std::string& what) {
        if (m_status.ok())
            m_status = Error{ErrorCode::InvalidArgument,
                             m_file + ": " + m_name + (key.empty() ? "" : " ") + key + ": " + what};
    }

  private:
    const toml::node* find(const char* key) {
        m_known.push_back(key);
        return m_table ? m_table->get(key) : nullptr;
    }
    std::string names() const {
        std::string all;
        for (const std::string& key : m_known) all += (all.empty() ? "" : ", ") + key;
        return all;
    }
    static std::string found(const toml::node& node) {
        std::ostringstream text;
        if (node.is_number())
            text << number_text(node.value_or(0.0));
        else if (node.is_string())
            text << '"' << shown(node.value_or(std::string())) << '"';
        else
            text << node.type();
        return text.str();
    }

    std::string m_file, m_name;
    const toml::table* m_table;
    Status& m_status;
    std::vector<std::string> m_known;
};

}  // namespace pliant::catheter
