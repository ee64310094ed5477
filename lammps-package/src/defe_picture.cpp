/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"

#include "atom.h"

#include "defe/fe/hex8.h"

#if __has_include("graphics.h")
#include "graphics.h"
static constexpr int IMAGE_TRI = LAMMPS_NS::Graphics::TRI;
#else
static constexpr int IMAGE_TRI = 2;    // dump_image.cpp of 4Feb2025
#endif

using namespace LAMMPS_NS;

/* ----------------------------------------------------------------------
   outer faces of the finite elements, two triangles each
   dump image shades a triangle by (p1-p2) x (p3-p2): clockwise seen from outside
------------------------------------------------------------------------- */

int DefePicture::draw(int *&objs, double **&parms)
{
  kinds.clear();
  data.clear();
  for (const auto &b : sys.elements.batches())
    for (int e = 0; e < b.size(); e++)
      for (int f = 0; f < 6; f++) {
        if (b.hex[e]->nb[f] > 0) continue;
        const int *face = defe::fe::hex_face[f];
        static constexpr int corner[2][3] = {{0, 2, 1}, {0, 3, 2}};
        for (const auto &tri : corner) {
          kinds.push_back(IMAGE_TRI);
          data.push_back(atom->type[b.nodes(e)[0]]);
          for (int k : tri)
            for (int d = 0; d < 3; d++) data.push_back(atom->x[b.nodes(e)[face[k]]][d]);
        }
      }
  rows.clear();
  for (size_t k = 0; k < kinds.size(); k++) rows.push_back(&data[10 * k]);
  objs = kinds.data();
  parms = rows.data();
  return static_cast<int>(kinds.size());
}
