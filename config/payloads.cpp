// [[payload]] to Payload: names, links, and whether a body can have such an inertia.
#include "config/payloads.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "config/checks.hpp"
#include "control/mechanism/inertia_check.hpp"

namespace geodesic::config {
namespace {

constexpr std::size_t kMostPayloads = 64;

Eigen::Matrix3d inertia_matrix(const PayloadEntry& entry) {
  const std::array<double, 3>& d = entry.inertia.value;
  const std::array<double, 3>& p = entry.products.value;
  Eigen::Matrix3d matrix;
  matrix << d[0], p[0], p[1],  //
      p[0], d[1], p[2],        //
      p[1], p[2], d[2];
  return matrix;
}

/// Inertia about a point that is `offset` from the centre of mass (Steiner).
Eigen::Matrix3d moved(const control::LinkInertia& of, const Eigen::Vector3d& offset) {
  return of.inertia_kg_m2 + of.mass_kg * (offset.squaredNorm() * Eigen::Matrix3d::Identity() -
                                          offset * offset.transpose());
}

void check_name(Draft& draft, std::size_t index) {
  const PayloadEntry& entry = draft.file.payloads[index];
  if (entry.name.value == kNoPayload) {
    draft.findings.error(
        entry.name.place,
        fmt::format("name: {} says that nothing is carried; choose another", quote(kNoPayload)));
  }
  for (std::size_t k = 0; k < index; ++k) {
    if (draft.file.payloads[k].name.value != entry.name.value) continue;
    draft.findings.error(entry.name.place,
                         fmt::format("a second [[payload]] {}; the first is in line {}",
                                     quote(entry.name.value), draft.file.payloads[k].place.line));
  }
}

void check_link(Draft& draft, const PayloadEntry& entry, const std::string& link) {
  if (link.empty()) {
    draft.findings.error(entry.place,
                         fmt::format("payload {}: link is missing, and there is no tool_link in "
                                     "[robot] to hold it",
                                     quote(entry.name.value)));
  } else if (draft.urdf.ok && draft.urdf.links.count(link) == 0) {
    std::vector<std::string> known;
    for (const auto& [name, place] : draft.urdf.links) known.push_back(name);
    draft.findings.error(
        entry.link.given ? entry.link.place : entry.place,
        fmt::format("payload {}: the URDF has no link {}{}", quote(entry.name.value), quote(link),
                    did_you_mean(link, known)));
  }
}

void check_body(Draft& draft, const PayloadEntry& entry, const control::LinkInertia& inertia) {
  const control::InertiaVerdict verdict = control::check_inertia(inertia);
  if (!entry.mass.given || verdict.physical) return;
  const Eigen::Vector3d& p = verdict.principal;
  const Eigen::Matrix3d& n = verdict.nearest.inertia_kg_m2;
  draft.findings.error(
      entry.inertia.given ? entry.inertia.place : entry.place,
      fmt::format("payload {}: no body can have this inertia: {} (principal moments {:.4g}, "
                  "{:.4g}, {:.4g} kg·m²). The nearest that one can: inertia = [{:.6g}, {:.6g}, "
                  "{:.6g}], products = [{:.6g}, {:.6g}, {:.6g}]",
                  quote(entry.name.value), verdict.reason, p[0], p[1], p[2], n(0, 0), n(1, 1),
                  n(2, 2), n(0, 1), n(0, 2), n(1, 2)));
}

/// Index of the payload that an option names; none, with a finding, if there is no such.
std::optional<std::size_t> chosen(Draft& draft, const Given<std::string>& option) {
  if (option.value == kNoPayload) return std::nullopt;
  std::vector<std::string> known{std::string(kNoPayload)};
  for (std::size_t i = 0; i < draft.robot.payloads.size(); ++i) {
    known.push_back(draft.robot.payloads[i].name);
    if (known.back() == option.value) return i;
  }
  draft.findings.error(
      option.place,
      fmt::format(
          "payload: there is no [[payload]] {}{} Payloads: {}", quote(option.value),
          nearest_name(option.value, known).empty() ? "." : did_you_mean(option.value, known),
          list_names(known)));
  return std::nullopt;
}

}  // namespace

void fill_payloads(Draft& draft) {
  const std::vector<PayloadEntry>& entries = draft.file.payloads;
  if (entries.size() > kMostPayloads) {
    draft.findings.error(
        entries[kMostPayloads].place,
        fmt::format("{} payloads, expected at most {}", entries.size(), kMostPayloads));
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const PayloadEntry& entry = entries[i];
    Payload payload;
    payload.name = entry.name.value;
    payload.link = entry.link.given ? entry.link.value : draft.robot.tool_link;
    payload.inertia.mass_kg = entry.mass.value;
    payload.inertia.com_m = Eigen::Vector3d(entry.com.value.data());
    payload.inertia.inertia_kg_m2 = inertia_matrix(entry);
    check_name(draft, i);
    check_link(draft, entry, payload.link);
    check_body(draft, entry, payload.inertia);
    draft.robot.payloads.push_back(std::move(payload));
  }
  draft.robot.payload = chosen(draft, draft.file.robot.payload);
  draft.robot.simulation.payload = chosen(draft, draft.file.simulation.payload);
}

control::TreeDescription with_payload(control::TreeDescription tree, const Payload& payload) {
  const auto link = std::find_if(tree.links.begin(), tree.links.end(),
                                 [&](const auto& l) { return l.name == payload.link; });
  if (link == tree.links.end()) return tree;
  const control::LinkInertia own = link->inertia;
  const control::LinkInertia& more = payload.inertia;
  control::LinkInertia& sum = link->inertia;
  sum.mass_kg = own.mass_kg + more.mass_kg;
  if (!(sum.mass_kg > 0.0)) return tree;
  sum.com_m = (own.mass_kg * own.com_m + more.mass_kg * more.com_m) / sum.mass_kg;
  sum.inertia_kg_m2 = moved(own, own.com_m - sum.com_m) + moved(more, more.com_m - sum.com_m);
  return tree;
}

}  // namespace geodesic::config
