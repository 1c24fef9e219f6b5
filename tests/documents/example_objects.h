// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Objects that the examples in the public headers use without declaring them: tools/check_documents
// compiles each example after this file.

#pragma once

#include <pliant/pliant.h>
#include <pliant/research/graph.h>
#include <pliant/research/objects.h>
#include <pliant/research/orderings.h>
#include <pliant/research/rod.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <vector>

using namespace pliant;

extern const TaskArena arena;
extern const Volume scan, volume, label_map, exhale, inhale;
extern ChainMail tissue;
extern LiveDeformation live;
extern const Endoscope endoscope;
extern const Vec3d point;
extern const std::vector<Vec3d> known, found;
extern Vec3d eye;
extern const bool running, closed;
extern const RelaxTool tip;
extern const std::vector<Vec3i> touched;

extern const TetMesh mesh;
extern const TriangleMesh surface;
extern const std::vector<std::int32_t> back;
extern const FitMeshLoad load;
extern const std::vector<Vec3d> displacements, positions, rod_positions;
extern const std::vector<VesselEnd> ends;
extern const VesselWall wall;
extern const Centreline centreline;
extern CatheterScene scene;
extern VesselScript script;
extern CatheterCommand command;
extern PbdBody body;
extern Rod rod;

extern Result<SpringNetwork> network;
extern const std::vector<Support> supports;
extern const std::int32_t node;
extern const HapticModel model;

extern const ChainLattice lattice;
extern const ElementLimits limits;
extern const std::int32_t element;

struct MySettings {
    double stiffness_pa = 1e3;
};

Status render(const std::filesystem::path& file);
Vec3d wanted_eye();
std::vector<double> wanted_actions();
template <class... Shown>
void show(const Shown&...);
template <class... Drawn>
void draw(const Drawn&...);
