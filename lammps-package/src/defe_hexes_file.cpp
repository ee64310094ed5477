/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "fix.h"
#include "text_file_reader.h"
#include "tokenizer.h"

#include <algorithm>

using namespace LAMMPS_NS;

/* ----------------------------------------------------------------------
   atoms without radius that came with a mesh but belong to none of its elements: nothing would hold
   them, and they would count in masses and energies
------------------------------------------------------------------------- */

void DefeHexesFile::check_orphans()
{
  if (!mesh_from_file) return;
  mesh_from_file = false;
  struct {
    bigint count = 0;
    tagint first = MAXTAGINT;
  } mine, all;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & sys.host->groupbit) || atom->radius[i] > 0.0 ||
        sys.store.elements_at(i) > 0)
      continue;
    mine.count++;
    mine.first = MIN(mine.first, atom->tag[i]);
  }
  MPI_Allreduce(&mine.count, &all.count, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  MPI_Allreduce(&mine.first, &all.first, 1, MPI_LMP_TAGINT, MPI_MIN, world);
  if (all.count)
    error->all(
        FLERR,
        "{} atoms without a radius, the first with ID {}, belong to no element of the mesh: "
        "remove such orphan nodes (tools/mesh2data --drop-orphans), or give fix defe a group "
        "without them",
        all.count, all.first);
}

/* ----------------------------------------------------------------------
   data file: "N hexes" in the header, section Hexes with lines
   ID part node1 ... node8   (part: name or number)
------------------------------------------------------------------------- */

void DefeHexesFile::read_header(char *line)
{
  bigint n = 0;
  try {
    ValueTokenizer values(line);
    n = values.next_bigint();
    if (values.next_string() != "hexes" || values.has_next())
      throw TokenizerException("other words", "");
  } catch (std::exception &e) {
    error->all(FLERR,
               "Fix defe cannot read the header line '{}' of the data file: {}; needed: N hexes",
               utils::trim(line), e.what());
  }
  if (n < 0) error->all(FLERR, "Data file has a negative number of hexes: {}", n);
  require_section();
  in_header = awaited = n;

  sys.store.begin_reading();
  mesh_from_file = true;
}

bigint DefeHexesFile::skip_lines()
{
  awaited = 0;    // the section is there; LAMMPS counts its lines
  return in_header;
}

/* ----------------------------------------------------------------------
   LAMMPS takes a file that ends before a section for complete
------------------------------------------------------------------------- */

void DefeHexesFile::require_section() const
{
  if (awaited > 0)
    error->all(FLERR, "Data file announced {} hexes, but had no section Hexes: was the file cut?",
               awaited);
}

DefeHexesFile::Line DefeHexesFile::parse(const std::string &line, tagint id_offset) const
{
  Line hex;
  const auto &parts = sys.model.parts;
  try {
    ValueTokenizer values(line);
    hex.id = values.next_tagint();
    auto name = values.next_string();
    hex.part = sys.model.find_part(name);
    if (hex.part < 0 && utils::is_integer(name)) {
      const bigint number = ValueTokenizer(name).next_bigint();
      if (number >= 1 && number <= static_cast<bigint>(parts.size()))
        hex.part = static_cast<int>(number) - 1;
    }
    if (hex.part < 0) throw TokenizerException("unknown part", name);
    for (tagint &a : hex.node) {
      const bigint tag = static_cast<bigint>(values.next_tagint()) + id_offset;
      if (tag <= 0 || tag > MAXTAGINT)
        throw TokenizerException("no node can have the ID", std::to_string(tag));
      a = static_cast<tagint>(tag);
    }
    if (values.has_next()) throw TokenizerException("too many items", "");
  } catch (std::exception &e) {
    error->all(FLERR, "Line '{}' of section Hexes: {}; needed: ID part and 8 node IDs", line,
               e.what());
  }
  if (hex.id <= 0) error->all(FLERR, "Line '{}' of section Hexes: element ID must be > 0", line);
  return hex;
}

void DefeHexesFile::read_section(int n, char *buf, tagint id_offset)
{
  sys.mesh.changed();
  std::vector<std::string> lines;
  std::vector<int> mine, found(n, 0);    // how many ranks own each element's first node
  for (const auto &raw : utils::split_lines(buf)) {
    const auto line = utils::trim(utils::trim_comment(raw));
    if (line.empty()) continue;
    if (static_cast<int>(lines.size()) == n)
      error->all(FLERR, "Section Hexes of the data file has more than {} lines: '{}'", n, line);
    const Line hex = parse(line, id_offset);
    const int i = sys.ids.local_of(hex.node[0]);
    mine.push_back(i >= 0 && i < atom->nlocal ? 1 : 0);
    if (mine.back()) {
      sys.mesh.add_hex(i, hex.id, hex.part, hex.node);
      sys.store.came_with_file(i);
    }
    lines.push_back(line);
  }
  if (static_cast<int>(lines.size()) != n)
    error->all(FLERR,
               "Section Hexes of the data file: {0} lines hold {1} elements, not {0}: blank lines "
               "and comments count as lines, as in all sections of LAMMPS (remove them), or the "
               "header announces too many hexes",
               n, lines.size());
  MPI_Allreduce(mine.data(), found.data(), n, MPI_INT, MPI_SUM, world);
  for (int k = 0; k < n; k++)
    if (found[k] != 1)
      error->all(FLERR,
                 "Line '{}' of section Hexes: its first node {}; section Hexes must follow the "
                 "nodes",
                 lines[k], found[k] ? "exists more than once" : "does not exist");
}

/* ---------------------------------------------------------------------- */

void DefeHexesFile::write_header(FILE *fp) const
{
  utils::print(fp, "{} hexes\n", sys.census.elements());
  if (sys.census.des() > 0)
    error->warning(
        FLERR,
        "Data file holds the {} finite elements that are left; joints between the {} DEs "
        "are lost: use write_restart to go on",
        sys.census.elements(), sys.census.des());
}

void DefeHexesFile::section_size(int &nx, int &ny) const
{
  nx = 0;
  for (int i = 0; i < atom->nlocal; i++) nx += static_cast<int>(sys.store.hexes(i).size());
  ny = 10;
}

void DefeHexesFile::pack_section(double **buf) const
{
  int n = 0;
  for (int i = 0; i < atom->nlocal; i++)
    for (const auto &h : sys.store.hexes(i)) {
      buf[n][0] = ubuf(h.id).d;
      buf[n][1] = ubuf(h.part).d;
      for (int a = 0; a < 8; a++) buf[n][2 + a] = ubuf(h.node[a]).d;
      n++;
    }
}

void DefeHexesFile::write_section(FILE *fp, int n, double **buf) const
{
  for (int k = 0; k < n; k++) {
    utils::print(fp, "{} {}", static_cast<tagint>(ubuf(buf[k][0]).i),
                 sys.model.parts[static_cast<int>(ubuf(buf[k][1]).i)].name);
    for (int a = 0; a < 8; a++) utils::print(fp, " {}", static_cast<tagint>(ubuf(buf[k][2 + a]).i));
    fputc('\n', fp);
  }
}
