/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_SYSTEM_H
#define LMP_DEFE_SYSTEM_H

#include "defe_account.h"
#include "defe_audit.h"
#include "defe_census.h"
#include "defe_checks.h"
#include "defe_clock.h"
#include "defe_conversion.h"
#include "defe_elements.h"
#include "defe_energy_watch.h"
#include "defe_events.h"
#include "defe_exact_sums.h"
#include "defe_ghosts.h"
#include "defe_hexes_file.h"
#include "defe_ids.h"
#include "defe_in_place.h"
#include "defe_joint_table.h"
#include "defe_kept.h"
#include "defe_marks.h"
#include "defe_mesh.h"
#include "defe_model.h"
#include "defe_notes.h"
#include "defe_picture.h"
#include "defe_prestress.h"
#include "defe_restart.h"
#include "defe_script.h"
#include "defe_store.h"
#include "defe_strengths.h"
#include "defe_surface.h"
#include "defe_tables.h"
#include "defe_tied_des.h"
#include "defe_tied_surfaces.h"
#include "defe_watch.h"
#include "defe_work.h"

#include "defe/coupling/ledger.h"

namespace LAMMPS_NS {

class Fix;

/** What fix, pair style, computes and create_hexes share, side by side. The fix makes it, and the others
    find it by of(). */
struct DefeSystem {
  DefeSystem(LAMMPS *, Fix *);
  DefeSystem(const DefeSystem &) = delete;
  DefeSystem &operator=(const DefeSystem &) = delete;

  /** That of a fix; null if it has none. */
  static DefeSystem *of(Fix *);
  /** The only one, null if there is none. */
  static DefeSystem *find(LAMMPS *);

  LAMMPS *const lmp;
  Fix *const host;    // the fix as LAMMPS knows it: ID, group, communication

  DefeModel model;    // of the script
  DefeClock clock;

  DefeStore store;    // of atoms
  DefeKept kept;
  DefeStrengths strengths;
  DefePrestress prestress;
  DefeTiedSurfaces tied;
  DefeTiedDEs tied_des;
  DefeIds ids;
  DefeCensus census;

  DefeMesh mesh;
  DefeHexesFile hexes_file;
  DefeElements elements;

  DefeGhosts ghosts;
  DefeTables tables;
  JointTable joints;    // made by the tables; flat arrays, for the pair style
  DefeExactSums sums;

  DefeSurface surface;
  DefeMarks marks;
  DefeConversion conversion;
  DefeInPlace in_place;

  defe::EnergyLedger ledger;
  defe::StoredEnergy stored;    // set by the pair style
  DefeWork work;
  DefeAccount account;
  DefeEvents events;

  DefeChecks checks;
  DefeAudit audit;
  DefeWatch watch;
  DefeEnergyWatch energy_watch;
  DefeNotes notes;
  DefeScript script;
  DefeRestart restart;
  DefePicture picture;
};

}    // namespace LAMMPS_NS

#endif
