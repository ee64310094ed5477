/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_TALLY_H
#define LMP_DEFE_TALLY_H

namespace LAMMPS_NS {

/** Where forces are added to the virial, if it is asked for. */
struct DefeTally {
  double *all = nullptr;      // [6]
  double **each = nullptr;    // [atoms][6]
  bool on() const { return all || each; }

  /** A force on atom i, del = x_i - (point of the reaction). */
  void operator()(const double *del, const double *force, int i) const
  {
    const double v[6] = {del[0] * force[0], del[1] * force[1], del[2] * force[2],
                         del[0] * force[1], del[0] * force[2], del[1] * force[2]};
    if (all)
      for (int k = 0; k < 6; k++) all[k] += v[k];
    if (each)
      for (int k = 0; k < 6; k++) each[i][k] += v[k];
  }
};

}    // namespace LAMMPS_NS

#endif
