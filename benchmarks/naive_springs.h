// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A naive port of [Choi2004] as a reference: nodes as objects with their links, new positions are
// used immediately, a root and a division for each link.

#pragma once

#include <pliant/models/springs.h>

#include <cmath>
#include <utility>
#include <vector>

namespace pliant::bench {

class NaivePort {
  public:
    NaivePort(const SpringNetwork& network, double time_step) : m_h(time_step) {
        for (const SpringNode& node : network.nodes())
            m_nodes.push_back(
                {node.rest, node.rest, {0, 0, 0}, node.mass, node.damping, false, {}});
        for (const SpringLink& link : network.links()) {
            m_nodes[std::size_t(link.a)].links.push_back(
                {link.b, link.stiffness, link.rest_length});
            m_nodes[std::size_t(link.b)].links.push_back(
                {link.a, link.stiffness, link.rest_length});
        }
    }
    void load(int node, Vec3d force) { m_nodes[std::size_t(node)].force = force; }
    void search(int from, int depth) {
        for (Node& node : m_nodes) node.visited = false;
        m_layers.assign(1, {from});
        m_nodes[std::size_t(from)].visited = true;
        for (int d = 0; d < depth; ++d) {
            std::vector<int> next;
            for (const int n : m_layers.back())
                for (const Link& link : m_nodes[std::size_t(n)].links)
                    if (Node& other = m_nodes[std::size_t(link.other)]; !other.visited) {
                        other.visited = true;
                        next.push_back(link.other);
                    }
            m_layers.push_back(std::move(next));
        }
    }
    void step() {
        for (const auto& layer : m_layers)
            for (const int n : layer) update(m_nodes[std::size_t(n)]);
    }
    Vec3d place(int node) const { return m_nodes[std::size_t(node)].x; }

  private:
    struct Link {
        int other;
        double stiffness, length;
    };
    struct Node {
        Vec3d x, before, force;
        double mass, damping;
        bool visited;
        std::vector<Link> links;
    };
    void update(Node& node) {
        Vec3d sum = node.force;
        for (const Link& link : node.links) {
            const Vec3d r = node.x - m_nodes[std::size_t(link.other)].x;
            const double length = norm(r);
            sum = sum - (link.stiffness * (length - link.length) / length) * r;
        }
        const double a = node.mass / (m_h * m_h), b = node.damping / (2 * m_h);
        const Vec3d next =
            (1 / (a + b)) * (sum + a * (2.0 * node.x - node.before) + b * node.before);
        node.before = node.x;
        node.x = next;
    }

    double m_h;
    std::vector<Node> m_nodes;
    std::vector<std::vector<int>> m_layers;
};

}  // namespace pliant::bench
