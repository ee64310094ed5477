/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_OPTIONS_H
#define LMP_DEFE_OPTIONS_H

#include "defe_component.h"

#include <string>

namespace LAMMPS_NS {

struct DefePart;

/** Reads the arguments of the fix command into the model, the clock and the event log. */
class DefeOptions : protected DefeComponent {
 public:
  DefeOptions(DefeSystem &, int narg, char **arg);
  void read();

 private:
  const int narg;
  char **const arg;
  int iarg = 3;

  void need(int n, const char *what);
  int material_index(const std::string &name) const;
  void check_name(const char *what, const std::string &name) const;
  void add_part(const std::string &name, int material);
  bool yes(const char *what);    // or no, behind the keyword
  /** Whether the word behind the keyword is the second one; it must be one of the two. */
  bool second_of(const char *what, const char *first, const char *second);

  void read_material();
  void read_part();
  void read_convert();
  void read_criterion(DefePart &);
  void read_des(DefePart &);
  void read_strength();
  void read_prestress();
  void read_adhesive();
  void read_tied();
  void read_contact();
  void read_every();
  void read_collect();
  void read_check();

  void finish();
  void check_numbers_as_names() const;
  void check_adhesives() const;
  void check_strengths() const;
  void check_prestress() const;
};

}    // namespace LAMMPS_NS

#endif
