/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_HEXES_FILE_H
#define LMP_DEFE_HEXES_FILE_H

#include "defe_component.h"

#include <string>

namespace LAMMPS_NS {

/** The elements in data files: "N hexes" in the header, section Hexes. */
class DefeHexesFile : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;
  void read_header(char *line);
  bigint skip_lines();
  void read_section(int n, char *buf, tagint id_offset);
  /** LAMMPS takes a file that ends before a section for complete. */
  void require_section() const;
  void check_orphans();

  void write_header(FILE *) const;
  void section_size(int &nx, int &ny) const;
  void pack_section(double **buf) const;
  void write_section(FILE *, int n, double **buf) const;

 private:
  bigint in_header = 0;    // of the data file that is read
  bigint awaited = 0;      // announced by a header, section not met yet
  bool mesh_from_file = false;

  struct Line {
    tagint id, node[8];
    int part;
  };
  Line parse(const std::string &line, tagint id_offset) const;
};

}    // namespace LAMMPS_NS

#endif
