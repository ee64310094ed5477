#include "defe/coupling/crack_rings.h"

#include "defe/fe/topology.h"

#include <cmath>

namespace defe {

namespace {

  /// The same where the DE is its element's only one: by the nodes of the face that the two elements have. Its first edge
  /// lies along an axis of either, and its last one along the other.
  int across_single(const CrackLattice &lattice, int de, int out, int t)
  {
    const int *mine = fe::hex_face[out], *its = fe::hex_face[lattice.partner[de][out] % 6];
    const int first = lattice.turned[de] >> 2 * out & 3;
    for (int q : {1, 3}) {
      const int a = mine[0], b = mine[q], c = its[first], d = its[(first - q + 4) % 4];
      if (fe::hex_sign[a][t / 2] == fe::hex_sign[b][t / 2]) continue;
      const bool ahead = fe::hex_sign[b][t / 2] > 0;    // along the edge towards the slot's side
      for (int axis = 0; axis < 3; ++axis)
        if (fe::hex_sign[c][axis] != fe::hex_sign[d][axis])
          return 2 * axis + ((fe::hex_sign[d][axis] > 0) == (ahead == (t % 2 == 1)));
    }
    return -1;
  }

  /// Slot of the DE behind slot `out` that looks the same way as slot `t` of this DE; < 0 if unknown.
  /// Siblings share their element's axes. Across an element's face the sibling of this DE along the
  /// axis of t is joined to that DE which is, over there, the sibling along the slot that is sought.
  int same_way(const CrackLattice &lattice, int de, int out, int t)
  {
    const auto is_outer = [&lattice](int d, int slot) {
      return (lattice.outer[d] >> slot & 1u) != 0;
    };
    if (!is_outer(de, out)) return t;
    if (lattice.outer[de] == 0x3f) return across_single(lattice, de, out, t);
    const int inner = is_outer(de, t) ? t ^ 1 : t;
    const int sibling = lattice.partner[de][inner];
    if (sibling < 0) return -1;
    const int across = lattice.partner[sibling / 6][out];
    if (across < 0) return -1;
    const int other = lattice.partner[de][out] / 6;
    for (int q = 0; q < 6; ++q)
      if (!is_outer(other, q) && lattice.partner[other][q] >= 0 &&
          lattice.partner[other][q] / 6 == across / 6)
        return t == inner ? q : q ^ 1;
    return -1;
  }

}    // namespace

std::uint64_t crack_place_key(const Vec3 &place, double size)
{
  const double grid = 0.0123456789 * size;
  std::uint64_t h = 0x9e3779b97f4a7c15ull;
  for (int k = 0; k < 3; ++k) {
    h ^= static_cast<std::uint64_t>(
        static_cast<std::int64_t>(std::floor(place[k] / grid + 0.376543)));
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ull;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebull;
    h ^= h >> 31;
  }
  return h;
}

bool crack_ring(const CrackLattice &lattice, int de, int out, int back, CrackRing &ring)
{
  ring.size = 0;
  ring.open = -1;
  int at = de, leave = out, came = back;
  while (ring.size < CrackRing::most) {
    const int there = lattice.partner[at][leave];
    if (there < 0) {
      ring.de[ring.size] = at;
      ring.open = 6 * at + leave;
      return false;
    }
    ring.de[ring.size] = at;
    ring.joint[ring.size++] = 6 * at + leave;
    if (there / 6 == de) return there % 6 == back && ring.size > 2;
    const int next = same_way(lattice, at, leave, came);
    if (next < 0) return false;
    at = there / 6;
    came = there % 6;
    leave = next;
  }
  return false;
}

}    // namespace defe
