// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Files of networks: every number returns, and each fault is told in a line.
// Covers: scene_files/network_json.cpp.

#include <gtest/gtest.h>
#include <pliant/models/network_file.h>
#include <pliant/models/scene_files.h>

#include <array>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "springs/random_networks.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

NetworkFile random_network(std::uint64_t seed) {
    Random random(seed);
    NetworkFile network{.mesh = "organ \"1\".vtu",
                        .parts = random_block(random, {4, 3, 3}, 5, true)};
    network.groups = {{"links 1", "Pa", 1234.5678901234567, 1000.1, 1500.2, "at its lower bound"},
                      {"damping", "1/s", 7, 0, 0, ""}};
    for (std::size_t n = 0; n < network.parts.nodes.size(); ++n) {
        network.parts.nodes[n].fixed = n % 5 == 0;
        network.node_groups.push_back(n % 2 == 0 ? 1 : -1);
    }
    for (std::size_t l = 0; l < network.parts.links.size(); ++l) {
        network.link_groups.push_back(random.whole(-1, 1));
        if (seed % 2 == 0 || l % 3 == 0) continue;
        network.parts.links[l].branch_stiffness = random.ratio(0.1, 10);
        network.parts.links[l].branch_time = random.ratio(0.01, 100);
    }
    return network;
}

class NetworkFiles : public ::testing::Test {
  protected:
    std::string text_of(const NetworkFile& network) {
        EXPECT_TRUE(write_network(m_folder / "n.json", network).ok());
        std::ifstream file(m_folder / "n.json");
        std::ostringstream text;
        text << file.rdbuf();
        return text.str();
    }
    Result<NetworkFile> read(const std::string& text) {
        std::ofstream(m_folder / "t.json") << text;
        return read_network(m_folder / "t.json");
    }
    /// The fault without the file's name.
    std::string fault(const std::string& text) {
        const auto network = read(text);
        if (network.ok()) return "accepted";
        const std::string file = (m_folder / "t.json").string() + ": ";
        EXPECT_EQ(network.error().message.rfind(file, 0), 0u) << network.error().message;
        EXPECT_EQ(network.error().message.find('\n'), std::string::npos);
        return network.error().message.substr(
            std::min(file.size(), network.error().message.size()));
    }

    TemporaryFolder m_folder;
};

TEST_F(NetworkFiles, EveryNumberReturns) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        SCOPED_TRACE(seed);
        const NetworkFile network = random_network(seed);
        ASSERT_TRUE(write_network(m_folder / "n.json", network).ok());
        const auto back = read_network(m_folder / "n.json");
        ASSERT_TRUE(back.ok()) << back.error().message;
        EXPECT_EQ(back->mesh, network.mesh);
        ASSERT_EQ(back->groups.size(), 2u);
        EXPECT_EQ(back->groups[0].value, network.groups[0].value);
        EXPECT_EQ(back->groups[0].high, network.groups[0].high);
        EXPECT_EQ(back->groups[0].note, network.groups[0].note);
        EXPECT_EQ(back->groups[1].low, 0);
        EXPECT_EQ(back->link_groups, network.link_groups);
        EXPECT_EQ(back->node_groups, network.node_groups);
        EXPECT_EQ(back->cell_groups, std::vector<std::int32_t>(network.parts.cells.size(), -1));
        const auto made = SpringNetwork::create(network.parts);
        ASSERT_TRUE(made.ok());
        ASSERT_EQ(back->parts.nodes.size(), network.parts.nodes.size());
        ASSERT_EQ(back->parts.links.size(), network.parts.links.size());
        ASSERT_EQ(back->parts.cells.size(), network.parts.cells.size());
        ASSERT_GT(network.parts.cells.size(), 0u);
        for (std::size_t n = 0; n < network.parts.nodes.size(); ++n) {
            EXPECT_EQ(back->parts.nodes[n].rest, network.parts.nodes[n].rest);
            EXPECT_EQ(back->parts.nodes[n].mass, network.parts.nodes[n].mass);
            EXPECT_EQ(back->parts.nodes[n].damping, network.parts.nodes[n].damping);
            EXPECT_EQ(back->parts.nodes[n].fixed, network.parts.nodes[n].fixed);
        }
        for (std::size_t l = 0; l < network.parts.links.size(); ++l) {
            EXPECT_EQ(back->parts.links[l].a, network.parts.links[l].a);
            EXPECT_EQ(back->parts.links[l].b, network.parts.links[l].b);
            EXPECT_EQ(back->parts.links[l].stiffness, network.parts.links[l].stiffness);
            EXPECT_EQ(back->parts.links[l].damping, network.parts.links[l].damping);
            EXPECT_EQ(back->parts.links[l].rest_length, made->links()[l].rest_length);
            EXPECT_EQ(back->parts.links[l].branch_stiffness,
                      network.parts.links[l].branch_stiffness);
            EXPECT_EQ(back->parts.links[l].branch_time, network.parts.links[l].branch_time);
        }
        for (std::size_t c = 0; c < network.parts.cells.size(); ++c) {
            EXPECT_EQ(back->parts.cells[c].nodes, network.parts.cells[c].nodes);
            EXPECT_EQ(back->parts.cells[c].bulk, network.parts.cells[c].bulk);
        }
    }
}

TEST_F(NetworkFiles, OnlyANetworkWithBranchesHasTheirColumns) {
    EXPECT_NE(text_of(random_network(1)).find("branch_"), std::string::npos);
    EXPECT_EQ(text_of(random_network(2)).find("branch_"), std::string::npos);
}

TEST_F(NetworkFiles, FaultsAreToldInALine) {
    const std::string good =
        R"({"format": "pliant spring network", "version": 1, )"
        R"("groups": [{"name": "g", "value": 1}],)"
        R"("nodes": {"position_mm": [[0,0,0],[1,0,0],[0,1,0],[0,0,1]], "mass_g": [1,1,1,1],)"
        R"("damping_g_s": [0,0,0,0], "fixed": [0], "group": [-1,-1,-1,-1]},)"
        R"("links": {"nodes": [[0,1],[0,2],[0,3]], "stiffness_mn_m": [1,1,1],)"
        R"("damping_g_s": [0,0,0], "rest_length_mm": [1,1,1], "group": [0,0,-1]},)"
        R"("cells": {"nodes": [[0,1,2,3]], "bulk_pa": [5], "group": [-1]}})";
    EXPECT_EQ(fault(good), "accepted");
    const auto with = [&](const std::string& from, const std::string& to) {
        std::string text = good;
        const auto at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        return fault(text.replace(at, from.size(), to));
    };
    EXPECT_EQ(with("pliant spring network", "other"),
              "format: expected \"pliant spring network\", found \"other\"");
    EXPECT_EQ(with("\"version\": 1", "\"version\": 2"), "version: expected 1, found 2");
    EXPECT_EQ(with("\"mass_g\": [1,1,1,1]", "\"mass_g\": [1,1,1]"),
              "nodes.mass_g: expected 4 rows, found 3");
    EXPECT_EQ(with("\"mass_g\": [1,", "\"mass_g\": [-1,"),
              "nodes.mass_g: expected numbers of 0 or more, found -1");
    EXPECT_EQ(with("\"mass_g\": [1,", "\"mass_g\": [0,"),
              "network: node 0: expected a mass above 0, found 0.000000");
    EXPECT_EQ(with("[1,0,0]", "[1,0]"),
              "nodes.position_mm: expected three numbers within 100000 for node 1, found an array");
    EXPECT_EQ(with("[1,0,0]", "[1e9,0,0]"),
              "nodes.position_mm: expected three numbers within 100000 for node 1, found an array");
    EXPECT_EQ(with("\"fixed\": [0]", "\"fixed\": [4]"),
              "nodes.fixed: expected whole numbers from 0 below 4, found 4");
    EXPECT_EQ(with("\"fixed\": [0]", "\"fixed\": [0.5]"),
              "nodes.fixed: expected whole numbers from 0 below 4, found 0.5");
    EXPECT_EQ(with("[0,3]", "[0,4]"),
              "links.nodes: expected whole numbers from 0 below 4, found 4");
    EXPECT_EQ(with("[0,3]", "[0,3,1]"),
              "links.nodes: expected lists of node numbers, found an array");
    EXPECT_EQ(with("[0,3]", "[3,3]"),
              "network: link 2: expected two different nodes below 4, found 3 and 3");
    EXPECT_EQ(with("\"rest_length_mm\": [1,1,1]", "\"rest_length_mm\": [1,\"a\",1]"),
              "links.rest_length_mm: expected numbers of 0 or more, found \"a\"");
    const std::string branch = "\"branch_stiffness_mn_m\": [0,2,0], ";
    EXPECT_EQ(
        with("\"rest_length_mm\"", branch + "\"branch_time_s\": [0,0.5,0], \"rest_length_mm\""),
        "accepted");
    EXPECT_EQ(with("\"rest_length_mm\"", branch + "\"rest_length_mm\""),
              "links.branch_time_s: expected an array, found none");
    EXPECT_EQ(with("\"rest_length_mm\"", branch + "\"branch_time_s\": [0,0,0], \"rest_length_mm\""),
              "network: link 1: expected a branch time above 0, found 0.000000");
    EXPECT_EQ(with("\"group\": [0,0,-1]", "\"group\": [0,1,-1]"),
              "links.group: expected whole numbers from -1 below 1, found 1");
    EXPECT_EQ(with("[0,1,2,3]", "[0,2,1,3]"),
              "network: cell 0: expected a volume above 0, found -0.166667");
    EXPECT_EQ(with("\"cells\":", "\"cell\":"), "cells.nodes: expected an array, found none");
    EXPECT_EQ(with("\"value\": 1", "\"value\": \"x\""),
              "groups[0].value: expected a name of up to 200 bytes, or a finite number");
    EXPECT_EQ(fault("[1, 2]"), "expected a JSON object, found something else");
    EXPECT_EQ(fault("{\"format\": "), "expected a JSON object, found something else");
    EXPECT_EQ(fault(std::string(100, '[')).find("accepted"), std::string::npos);
    EXPECT_EQ(read_network(m_folder / "none.json").error().code, ErrorCode::NotFound);
}

TEST_F(NetworkFiles, ATruncatedOrDamagedFileIsRefusedOrSound) {
    const std::string text = text_of(random_network(7));
    Random random(11);
    for (int n = 0; n < 200; ++n) {
        std::string damaged = text;
        if (n % 2 == 0)
            damaged.resize(std::size_t(random.whole(0, int(text.size()) - 3)));
        else
            damaged[std::size_t(random.whole(0, int(text.size()) - 1))] =
                "0123456789-,[]{}\"e."[random.whole(0, 18)];
        const auto network = read(damaged);
        EXPECT_TRUE(network.ok() ? SpringNetwork::create(network->parts).ok()
                                 : network.error().message.find('\n') == std::string::npos);
        EXPECT_FALSE(n % 2 == 0 && network.ok()) << n;
    }
}

TEST_F(NetworkFiles, WritingRefusesWhatReadingWould) {
    NetworkFile network = random_network(2);
    network.link_groups[3] = 2;
    EXPECT_EQ(write_network(m_folder / "a.json", network).error().message,
              "link_groups: expected groups below 2, found 2");
    network = random_network(2);
    network.node_groups.pop_back();
    EXPECT_FALSE(write_network(m_folder / "a.json", network).ok());
    network = random_network(2);
    network.parts.nodes[1].mass = 0;
    EXPECT_FALSE(write_network(m_folder / "a.json", network).ok());
    network = random_network(2);
    network.groups[0].high = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(write_network(m_folder / "a.json", network).ok());
    network = random_network(2);
    network.parts.links[5].branch_stiffness = 1;
    EXPECT_EQ(write_network(m_folder / "a.json", network).error().message,
              "network: link 5: expected a branch time above 0, found 0.000000");
    EXPECT_FALSE(std::filesystem::exists(m_folder / "a.json"));
    EXPECT_EQ(write_network(m_folder / "none/a.json", random_network(2)).error().code,
              ErrorCode::Unwritable);
}

}  // namespace
}  // namespace pliant::test
