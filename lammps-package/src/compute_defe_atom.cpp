/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "compute_defe_atom.h"

#include "defe_system.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "memory.h"
#include "modify.h"
#include "update.h"

#include "defe/fe/principal.h"

#include <algorithm>
#include <map>

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

ComputeDefeAtom::ComputeDefeAtom(LAMMPS *lmp, int narg, char **arg) : Compute(lmp, narg, arg)
{
  static const std::map<std::string, Quantity> names = {
      {"damage", DAMAGE},     {"connective", CONNECTIVE},
      {"cohesive", COHESIVE}, {"contact", CONTACT},
      {"ties", TIES},         {"element", ELEMENT},
      {"elements", ELEMENTS}, {"strength", STRENGTH},
      {"vonmises", VONMISES}, {"s1", S1}};
  if (narg < 4) utils::missing_cmd_args(FLERR, "compute defe/atom", error);
  for (int k = 3; k < narg; k++) {
    auto found = names.find(arg[k]);
    if (found == names.end())
      error->all(
          FLERR,
          "Unknown compute defe/atom quantity {}: use damage, connective, cohesive, contact, "
          "ties, element, elements, strength, vonmises or s1",
          arg[k]);
    what.push_back(found->second);
    stresses = stresses || found->second == VONMISES || found->second == S1;
  }
  peratom_flag = 1;
  size_peratom_cols = what.size() == 1 ? 0 : static_cast<int>(what.size());
  comm_reverse = 7;
}

ComputeDefeAtom::~ComputeDefeAtom()
{
  if (what.size() == 1)
    memory->destroy(vector_atom);
  else
    memory->destroy(array_atom);
  memory->destroy(sum);
}

void ComputeDefeAtom::init()
{
  sys = DefeSystem::find(lmp);
  if (!sys) error->all(FLERR, "Compute defe/atom needs a fix defe");
  if (!sys->strengths.on() && std::find(what.begin(), what.end(), STRENGTH) != what.end())
    error->all(FLERR, "Compute defe/atom strength needs the keyword strength of fix defe");
}

/* ---------------------------------------------------------------------- */

void ComputeDefeAtom::compute_peratom()
{
  invoked_peratom = update->ntimestep;
  const int ncol = static_cast<int>(what.size());
  if (atom->nmax > nmax) grow();
  if (stresses) add_stresses();
  for (int i = 0; i < atom->nlocal; i++) {
    const bool in = atom->mask[i] & groupbit;
    const auto count = in ? joints_of(i) : std::array<int, 4>{0, 0, 0, 0};
    for (int c = 0; c < ncol; c++) {
      const double value = in ? value_of(what[c], i, count) : 0.0;
      if (ncol == 1)
        vector_atom[i] = value;
      else
        array_atom[i][c] = value;
    }
  }
}

void ComputeDefeAtom::grow()
{
  const int ncol = static_cast<int>(what.size());
  nmax = atom->nmax;
  if (ncol == 1) {
    memory->destroy(vector_atom);
    memory->create(vector_atom, nmax, "defe/atom:vector");
  } else {
    memory->destroy(array_atom);
    memory->create(array_atom, nmax, ncol, "defe/atom:array");
  }
  memory->destroy(sum);
  memory->create(sum, nmax, 7, "defe/atom:sum");
}

/* ----------------------------------------------------------------------
   mean over the elements at a node of the stress at their centres
------------------------------------------------------------------------- */

void ComputeDefeAtom::add_stresses()
{
  for (int i = 0; i < atom->nlocal + atom->nghost; i++)
    for (int k = 0; k < 7; k++) sum[i][k] = 0.0;
  for (int i = 0; i < atom->nlocal; i++)
    for (const auto &h : sys->store.hexes(i)) {
      double centre[3], s[6], s1;
      int idx[8];
      if (sys->model.material_of(sys->model.parts[h.part]).rigid()) continue;
      if (!sys->elements.local_hex(h, i, idx)) continue;
      sys->elements.centre_stress(h, centre, s, s1);
      for (int a : idx) {
        for (int k = 0; k < 6; k++) sum[a][k] += s[k];
        sum[a][6] += 1.0;
      }
    }
  comm->reverse_comm(this);
}

/* ----------------------------------------------------------------------
   joints of a DE by their state, and ties that hold
------------------------------------------------------------------------- */

std::array<int, 4> ComputeDefeAtom::joints_of(int i) const
{
  std::array<int, 4> count = {0, 0, 0, 0};
  if (const auto *de = sys->store.de(i))
    for (const auto &slot : de->slot) {
      if (slot.kind == DefeJoint::NONE) continue;
      const bool holding = slot.kind == DefeJoint::TIE && slot.state == DefeJoint::CONNECTIVE;
      count[holding ? 3 : static_cast<int>(slot.state)]++;
    }
  return count;
}

double ComputeDefeAtom::value_of(Quantity q, int i, const std::array<int, 4> &count) const
{
  switch (q) {
    case DAMAGE: {
      const int joints = count[0] + count[1] + count[2] + count[3];
      return joints ? static_cast<double>(count[1] + count[2]) / joints : 0.0;
    }
    case CONNECTIVE:
      return count[0];
    case COHESIVE:
      return count[1];
    case CONTACT:
      return count[2];
    case TIES:
      return count[3];
    case ELEMENT: {
      const auto *de = sys->store.de(i);
      return de ? static_cast<double>(de->element) : 0.0;
    }
    case ELEMENTS:
      return static_cast<double>(sys->store.elements_at(i));
    case STRENGTH:
      return sys->strengths.of_de(i);
    default:
      return stress_of(q, i);
  }
}

double ComputeDefeAtom::stress_of(Quantity q, int i) const
{
  if (sum[i][6] == 0.0) return 0.0;
  double s[6];
  for (int k = 0; k < 6; k++) s[k] = sum[i][k] / sum[i][6];
  if (q == VONMISES) return defe::fe::von_mises(s);
  defe::Mat3 m;
  m << s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2];
  return defe::fe::max_principal(m);
}

int ComputeDefeAtom::pack_reverse_comm(int n, int first, double *buf)
{
  int m = 0;
  for (int i = first; i < first + n; i++)
    for (int k = 0; k < 7; k++) buf[m++] = sum[i][k];
  return m;
}

void ComputeDefeAtom::unpack_reverse_comm(int n, int *list, double *buf)
{
  int m = 0;
  for (int ii = 0; ii < n; ii++)
    for (int k = 0; k < 7; k++) sum[list[ii]][k] += buf[m++];
}

double ComputeDefeAtom::memory_usage()
{
  return static_cast<double>(nmax) * (what.size() + 7) * sizeof(double);
}
