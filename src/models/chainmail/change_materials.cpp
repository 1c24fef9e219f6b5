// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Changes of materials while the lattice is deformed: nothing moves, and history is kept.
//
// Displacements count from the same rest position as before, so a movement limit can't be evaded by
// changing materials to and fro. Links and elements outside of their new limits may come back, and
// can't get worse: the solvers take their present values as limits.

#include <string>
#include <utility>

#include "base/errors.h"
#include "chainmail/chainmail_impl.h"
#include "chainmail/operation.h"
#include "material/certificate.h"
#include "material/settings.h"

namespace pliant {
namespace {

Status check_unchanged(const ChainMailSettings& present, const ChainMailSettings& changed) {
    if (changed.brick_size != present.brick_size)
        return Error{ErrorCode::InvalidArgument,
                     "[lattice] brick_size: expected " + std::to_string(present.brick_size) +
                         " as at the start, found " + std::to_string(changed.brick_size)};
    if (changed.bounded != present.bounded)
        return Error{ErrorCode::InvalidArgument, std::string("[lattice] bounded: expected ") +
                                                     (present.bounded ? "true" : "false") +
                                                     " as at the start, found " +
                                                     (changed.bounded ? "true" : "false")};
    return Ok{};
}

}  // namespace

Result<MaterialMap> make_materials(const Volume& volume, const ChainMailSettings& settings) {
    if (const Status s = check_volume(volume); !s.ok()) return s.error();
    if (const Status s = check_settings(settings); !s.ok()) return s.error();
    if (const Status s = check_labels(settings, volume.grid); !s.ok()) return s.error();
    MaterialMap materials(volume, settings);
    if (const auto& fault = materials.table().fault())
        return Error{ErrorCode::InvalidArgument, law_name(settings, fault->law) + " at value " +
                                                     std::to_string(fault->value_hu) + ": " +
                                                     fault->text};
    if (!materials.table().fits())
        return Error{ErrorCode::InvalidArgument,
                     "materials: expected up to 65535 different limits over all values and "
                     "[[label]], found more"};
    return materials;
}

/// Holds the other settings: the former ones after the change is done, the changed ones after its
/// undo.
class ChainMail::Impl::MaterialChange final : public Exchange {
  public:
    MaterialChange(Impl& impl, ChainMailSettings other) : m_impl(impl), m_other(std::move(other)) {}
    /// Supplies prepared materials; prepare() may then be omitted.
    void set_materials(MaterialMap materials) { m_materials = std::move(materials); }
    void prepare() override {
        // The same settings were valid before.
        if (auto materials = make_materials(m_impl.volume, m_other); materials.ok())
            m_materials = std::move(*materials);
    }
    void exchange() noexcept override {
        if (m_materials) m_impl.lattice.exchange_materials(*m_materials);
        std::swap(m_impl.settings, m_other);
        m_impl.yields = any_yields(m_impl.lattice.materials());
    }
    void finish() noexcept override { m_materials.reset(); }
    std::size_t bytes() const override { return sizeof *this; }

  private:
    Impl& m_impl;
    ChainMailSettings m_other;
    std::optional<MaterialMap> m_materials;  ///< of the other settings, from prepare to finish
};

Status ChainMail::Impl::set_materials(const ChainMailSettings& changed) {
    if (const Status s = check_unchanged(settings, changed); !s.ok()) return s;
    Result<MaterialMap> materials = make_materials(volume, changed);
    if (!materials.ok()) return materials.error();
    Operation step(*this, {.step = "materials", .ends_drag = true});
    auto change = std::make_unique<MaterialChange>(*this, changed);
    change->set_materials(std::move(*materials));
    history.make_room_for_exchange();
    lattice.tick();
    change->exchange();
    try {
        allowance.excuse_present(lattice, arena);
    } catch (...) {
        change->exchange();
        throw;
    }
    materials_changed = true;
    change->finish();
    history.add(std::move(change));
    step.commit();
    return Ok{};
}

void ChainMail::Impl::restore_allowance() {
    if (materials_changed) allowance.excuse_present(lattice, arena);
}

Status ChainMail::set_materials(const ChainMailSettings& settings) {
    return attempt([&] { return m_impl->set_materials(settings); });
}

FoldCertificate ChainMail::fold_certificate() const {
    return pliant::fold_certificate(m_impl->lattice.materials(), m_impl->volume.grid.spacing_mm,
                                    m_impl->lattice.may_exceed_limits());
}

}  // namespace pliant
