#include "defe/coupling/conversion_plan.h"

#include <algorithm>

namespace defe {

fe::HexCoords ConvertingHex::coords() const
{
  fe::HexCoords nodes;
  for (int a = 0; a < 8; a++) nodes.col(a) = Vec3(x[a]);
  return nodes;
}

Vec3 direction_to(const ConvertingHex &c, const Vec3 &from)
{
  Vec3 direction;
  for (int k = 0; k < 3; k++) {
    direction[k] = -from[k];
    for (const auto &xa : c.x) direction[k] += 0.125 * xa[k];
  }
  return direction;
}

ConversionPlan::ConversionPlan(std::int64_t de_base, std::vector<ConvertingHex> all, int size) :
    base(de_base), lot_size(size), list(std::move(all))
{
  for (const auto &c : list) {
    by_id[c.id] = &c;
    for (std::int64_t node : c.node) at_node[node].push_back(&c);
  }
}

void ConversionPlan::add_at(std::int64_t node, std::vector<const ConvertingHex *> &found) const
{
  const auto here = at_node.find(node);
  if (here == at_node.end()) return;
  for (const ConvertingHex *c : here->second)
    if (std::find(found.begin(), found.end(), c) == found.end()) found.push_back(c);
}

PlannedSlot ConversionPlan::outer_slot(const ConvertingHex &h, const HexNeighbors &n,
                                       ElementSplit split, int place, int face) const
{
  PlannedSlot slot;
  const std::int64_t behind = n.behind[face];
  if (behind == 0) return slot;
  int first = split.first_on_face(place, face);
  if (split.spot(place, face) == TieSpot::MIDDLE)    // for both elements the same one
    for (int c = 0; c < 4; c++)
      if (h.node[fe::hex_face[face][c]] < h.node[fe::hex_face[face][first]]) first = c;
  slot.corner =
      static_cast<signed char>(split.behind_code(place, face, n.face[face], n.rotation[face]));
  slot.partner = n.face[face];
  for (int c = 0; c < 4; c++) slot.face_node[c] = h.node[fe::hex_face[face][(first + c) % 4]];
  const ConvertingHex *now = behind > 0 ? converting(behind) : nullptr;
  if (behind < 0 || now) {
    slot.kind = PlannedSlot::JOINT;
    slot.other = de_id(now ? now->lot : -behind, split.place_of_code(slot.corner));
    slot.to_older = !now;
  } else {
    slot.kind = PlannedSlot::TIE;
    slot.other = behind;
    slot.part = n.part[face];
  }
  return slot;
}

std::vector<PlannedDE> ConversionPlan::births(const ConvertingHex &h, const HexNeighbors &n,
                                              const std::vector<NewDE> &all,
                                              ElementSplit split) const
{
  std::vector<PlannedDE> planned(split.des());
  for (int k = 0; k < split.des(); k++) {
    PlannedDE &de = planned[k];
    de.id = de_id(h.lot, k);
    de.outer_distance = de.outer_area = 0.0;
    for (int s = 0; s < 6; s++) {
      PlannedSlot &slot = de.slot[s];
      if (split.outer(k, s)) {
        slot = outer_slot(h, n, split, k, s);
      } else {
        const int other = split.beside(k, s);
        slot.kind = PlannedSlot::JOINT;
        slot.other = de_id(h.lot, other);
        slot.partner = static_cast<signed char>(s ^ 1);
        slot.corner = static_cast<signed char>(other);
      }
      if (slot.kind != PlannedSlot::FREE || n.tied >> s & 1u) continue;
      const double distance = all[k].reach[s];
      if (de.outer_distance > 0.0 && distance >= de.outer_distance) continue;
      de.outer_distance = distance;
      de.outer_area = all[k].area[s];
    }
    if (de.outer_distance == 0.0) {
      de.outer_distance = all[k].radius;
      de.outer_area = 4.0 * all[k].radius * all[k].radius;
    }
  }
  return planned;
}

}    // namespace defe
