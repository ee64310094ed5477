#include "defe/coupling/element_split.h"

#include <algorithm>
#include <cstdlib>

namespace defe {

using fe::hex_face;
using fe::hex_sign;

namespace {

  constexpr int lattice(const int q[3])    // q: -2, 0 or 2
  {
    return q[0] / 2 + 1 + 3 * (q[1] / 2 + 1) + 9 * (q[2] / 2 + 1);
  }

  /// Positions of the 27 places, and the other way round.
  struct Places {
    int q[27][3], number[27];

    Places()
    {
      std::fill_n(number, 27, -1);
      int next = 0;
      for (; next < 8; ++next) {
        for (int a = 0; a < 3; ++a) q[next][a] = 2 * hex_sign[next][a];
        number[lattice(q[next])] = next;
      }
      for (int k = 0; k < 27; ++k) {
        if (number[k] >= 0) continue;
        const int at[3] = {2 * (k % 3 - 1), 2 * (k / 3 % 3 - 1), 2 * (k / 9 - 1)};
        std::copy_n(at, 3, q[next]);
        number[k] = next++;
      }
    }
  };

  const Places places;

  /// Of a position, in the direction from one node of an edge to the other.
  int component(const int q[3], int from, int to)
  {
    int sum = 0;
    for (int a = 0; a < 3; ++a) sum += q[a] * (hex_sign[to][a] - hex_sign[from][a]) / 2;
    return sum;
  }

}    // namespace

void ElementSplit::position(int place, int q[3]) const
{
  for (int a = 0; a < 3; ++a) q[a] = n == 3 ? places.q[place][a] : n == 2 ? hex_sign[place][a] : 0;
}

int ElementSplit::number(const int q[3]) const
{
  if (n == 3) return places.number[lattice(q)];
  for (int k = 0; k < des() && n == 2; ++k)
    if (std::equal(q, q + 3, hex_sign[k])) return k;
  return 0;
}

Vec3 ElementSplit::centre(int place) const
{
  int q[3];
  position(place, q);
  return Vec3(q[0], q[1], q[2]) / n;
}

Vec3 ElementSplit::sign(int place) const
{
  return n > 1 ? Vec3(centre(place) * n / (n - 1)) : Vec3(Vec3::Zero());
}

bool ElementSplit::outer(int place, int slot) const
{
  int q[3];
  position(place, q);
  return q[slot / 2] == (slot % 2 ? n - 1 : 1 - n);
}

unsigned ElementSplit::outer_slots(int place) const
{
  unsigned bits = 0;
  for (int s = 0; s < 6; ++s)
    if (outer(place, s)) bits |= 1u << s;
  return bits;
}

std::vector<int> ElementSplit::on_face(int face) const
{
  std::vector<int> found;
  for (int k = 0; k < des(); ++k)
    if (outer(k, face)) found.push_back(k);
  return found;
}

int ElementSplit::beside(int place, int slot) const
{
  int q[3];
  position(place, q);
  q[slot / 2] += slot % 2 ? 2 : -2;
  return number(q);
}

int ElementSplit::first_on_face(int place, int face) const
{
  int q[3];
  position(place, q);
  const int *node = hex_face[face];
  for (int p = 0; p < 4; ++p)
    if (component(q, node[p], node[(p + 1) % 4]) <= 0 &&
        component(q, node[p], node[(p + 3) % 4]) < 0)
      return p;
  return 0;    // the middle
}

TieSpot ElementSplit::spot(int place, int face) const
{
  if (n == 2) return TieSpot::QUARTER;
  int q[3], middle = 0;
  position(place, q);
  for (int a = 0; a < 3; ++a) middle += a != face / 2 && q[a] == 0;
  return middle == 0 ? TieSpot::CORNER : middle == 1 ? TieSpot::EDGE : TieSpot::MIDDLE;
}

int ElementSplit::behind(int place, int face, int other, int rotation) const
{
  int q[3], there[3];
  position(place, q);
  const int *mine = hex_face[face];
  const auto its = [&](int p) {    // the other way round
    return hex_face[other][(rotation - p + 4) % 4];
  };
  const int u = component(q, mine[0], mine[1]), v = component(q, mine[0], mine[3]);
  for (int a = 0; a < 3; ++a) {
    const int to = hex_sign[its(1)][a] - hex_sign[its(0)][a];
    const int up = hex_sign[its(3)][a] - hex_sign[its(0)][a];
    there[a] = a == other / 2 ? (other % 2 ? n - 1 : 1 - n) : (u * to + v * up) / 2;
  }
  return number(there);
}

int ElementSplit::behind_code(int place, int face, int other, int rotation) const
{
  return n == 1 ? hex_face[other][rotation] : behind(place, face, other, rotation);
}

}    // namespace defe
