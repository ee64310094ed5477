/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_RESTART_H
#define LMP_DEFE_RESTART_H

#include "defe_component.h"

#include <cstdint>
#include <vector>

namespace LAMMPS_NS {

/** Restart files: DEFE's part of them, and the records of atoms, with checksums. */
class DefeRestart : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;

  void write(FILE *);
  void read(const char *buf);
  /** After LAMMPS has written and closed it. */
  void written(const char *name);
  /** Did all atoms find their records? Collective. */
  void check();

  // the same record as in an exchange with each atom

  int pack(int i, double *buf) const;
  /** False: what was read is not a record of this atom; check() stops the run. */
  bool unpack(int i, int nth);
  int size(int i) const;
  int largest() const { return largest_; }

 private:
  bigint step = -1;    // of the file that was read
  int largest_ = 0;    // of the record of any atom on any rank
  struct Read {
    bool unchecked = false;    // a file was read, and check() has not run yet
    bigint records_of_file = 0;
    uint64_t sum_of_file = 0;
    bigint records = 0, damaged = 0, other_steps = 0, other_step = -1;    // this rank
    uint64_t sum = 0;
    tagint first = 0;    // of the damaged ones
  } read_;
  uint64_t checksum_of(int i, const double *record, int n) const;
  void add_records(uint64_t &sum, bigint &records);
};

}    // namespace LAMMPS_NS

#endif
