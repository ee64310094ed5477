/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_RECORDS_H
#define LMP_DEFE_RECORDS_H

#include "lmptype.h"

#include "defe/coupling/joint_table.h"
#include "defe/coupling/pool.h"
#include "defe/coupling/prefetch.h"
#include "defe/coupling/shielding.h"
#include "defe/coupling/surface_forces.h"

#include <memory>
#include <vector>

namespace LAMMPS_NS {

/** Of restart files; to be raised whenever what DEFE writes into them changes. */
constexpr char RESTART_FORMAT[8] = "DEFE 18";

/** What travels with an element: it is kept by the atom that is its first node. */
struct HexPod {
  tagint id;
  tagint node[8];    // atom IDs, order of Abaqus C3D8
  tagint
      nb[6];    // behind each face: > 0 this element, 0 free surface, < 0 DEs with IDs of lot -nb
  signed char nbface[6];    // the face seen from that element
  signed char nbrot[6];     // position, on that face, of the first node of ours
  signed char nbpart[6];    // part of that element
  signed char marked;       // it converts at the step that DefeMarks has scheduled
  int part;                 // index into DefeModel::parts
  double volume;            // reference volume
};

/** What only some elements have. */
struct HexExtra {
  std::vector<defe::Shield> shields;    // recent conversions beside it
  std::vector<double> history;          // of its material, see defe::fe::HexKernel
};

struct HexRecord : HexPod {
  int kernel = -1;         // index into DefeElements::batches(), -1 = look it up again
  bool noticed = false;    // in DefeElements::noticed(), unless it has no exposed face any more
  std::unique_ptr<HexExtra> extra;
  HexExtra &with_extra()
  {
    if (!extra) extra = std::make_unique<HexExtra>();
    return *extra;
  }
};

namespace DefeJoint = defe::joint;    // kinds and states
using defe::JointCrack;
using defe::JointRecord;

/** What travels with every discrete element, besides its joints. Plain data: packed as bytes. */
struct DEPod {
  tagint element;     // the element it came from
  tagint lot;         // of its ID, see DefeIds::de_tag()
  tagint other[6];    // of its slots; DE: the atom ID of the other one;  TIE: the ID of the element
  double volume;      // reference volume
  // where a DE ends for balls and for facets of other parts: distance and area of the nearest of its
  // faces that were free from the start, so that spheres of flat cells do not stand out of their
  // surface; else its radius and the face of a cube
  double outer_distance, outer_area;
  short corner;    // its place in the element, see defe::ElementSplit
  short part;
  char newborn;    // 1 until the first force evaluation (energy of conversion)
  char fresh;      // of this step's conversion: it takes over the contact of its element
  char pad[2];     // always 0
};

/** Of a discrete element that is tied to others: of each tie the nodes of the face, from the DE's own corner node
    onwards. Plain data. */
struct TieNodes {
  tagint of[6][4];
  static void *operator new(size_t) { return defe::Pool<TieNodes>::take(); }
  static void operator delete(void *r) { defe::Pool<TieNodes>::give(r); }
};

struct DERecord : DEPod, defe::DEJoints {
  std::unique_ptr<TieNodes> tie;    // null: none of its joints is a tie

  static void *operator new(size_t) { return defe::Pool<DERecord>::take(); }
  static void operator delete(void *r) { defe::Pool<DERecord>::give(r); }
};

/** Surface contact of a node or DE with one part, from step to step. Plain data. */
struct FaceContact : defe::ContactHistory {
  int part, pad;
};

/** Contact of two spheres, as one of them sees it; of a DE and a ball only the DE. Plain data. */
struct SphereContact {
  bigint other;    // ID of the other one; no padding behind it, which would go into files unset
  defe::TangentialSpring tangential;    // of this one against the other
  // with a ball
  double offset;    // overlap that pushes nothing
  double
      inherit;    // energy that a DE takes over from its element, at its first evaluation; else -1
  double push;    // force that goes with it
};

/** All contacts and cracks of an atom; only some have any. */
struct AtomContacts {
  std::vector<FaceContact> faces;
  std::vector<SphereContact> spheres;
  std::vector<JointCrack> cracks;    // of the DE's joints
};

using defe::prefetch;    // records of elements and DEs are scattered in memory

}    // namespace LAMMPS_NS

#endif
