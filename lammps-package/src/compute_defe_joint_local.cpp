/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "compute_defe_joint_local.h"

#include "defe_system.h"
#include "pair_defe_joint.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "force.h"
#include "group.h"
#include "memory.h"
#include "modify.h"
#include "update.h"

#include <map>
#include <string>

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

ComputeDefeJointLocal::ComputeDefeJointLocal(LAMMPS *lmp, int narg, char **arg) :
    Compute(lmp, narg, arg)
{
  static const std::map<std::string, Quantity> names = {
      {"id1", ID1},     {"id2", ID2},   {"atom2", ATOM2},   {"kind", KIND},
      {"state", STATE}, {"part", PART}, {"damage", DAMAGE}, {"opening", OPENING},
      {"slip", SLIP},   {"tn", TN},     {"ts", TS},         {"x", X},
      {"y", Y},         {"z", Z},       {"nx", NX},         {"ny", NY},
      {"nz", NZ},       {"area", AREA}, {"length", LENGTH}, {"length0", LENGTH0}};
  if (narg < 4) utils::missing_cmd_args(FLERR, "compute defe/joint/local", error);
  for (int k = 3; k < narg; k++) {
    auto found = names.find(arg[k]);
    if (found == names.end())
      error->all(
          FLERR,
          "Unknown compute defe/joint/local quantity {}: use id1, id2, atom2, kind, state, part, "
          "damage, opening, slip, tn, ts, x, y, z, nx, ny, nz, area, length or length0",
          arg[k]);
    what.push_back(found->second);
    switch (found->second) {
      case ID1:
      case ID2:
      case ATOM2:
      case KIND:
      case STATE:
      case PART:
      case AREA:
      case LENGTH0:
        break;
      default:
        views = true;
    }
  }
  local_flag = 1;
  size_local_cols = what.size() == 1 ? 0 : static_cast<int>(what.size());
  comm_forward = 1;
}

ComputeDefeJointLocal::~ComputeDefeJointLocal()
{
  if (what.size() == 1)
    memory->destroy(vector_local);
  else
    memory->destroy(array_local);
}

void ComputeDefeJointLocal::init()
{
  sys = DefeSystem::find(lmp);
  if (!sys) error->all(FLERR, "Compute defe/joint/local needs a fix defe");
  pair = dynamic_cast<PairDefeJoint *>(force->pair_match("^defe/", 0));
  if (!pair) error->all(FLERR, "Compute defe/joint/local needs a pair style defe/*");
}

/* ----------------------------------------------------------------------
   joints by the rank of the lower ID, ties and joints to tied surfaces by that of the DE
------------------------------------------------------------------------- */

bool ComputeDefeJointLocal::counts(int d, int s) const
{
  if (sys->joints.is_tied(d, s)) return true;
  const JointRecord &slot = sys->joints.rec(d)->slot[s];
  if (slot.kind == DefeJoint::NONE || slot.state == DefeJoint::CONTACT) return false;
  if (slot.kind == DefeJoint::TIE) return true;
  return atom->tag[sys->joints.self[d]] < sys->joints.rec(d)->other[s] &&
      (atom->mask[sys->joints.nb[d][s]] & groupbit);
}

void ComputeDefeJointLocal::compute_local()
{
  invoked_local = update->ntimestep;
  if (group->dynamic[igroup]) comm->forward_comm(this);    // it changes between reneighbourings
  const auto &jt = sys->joints;
  const int ncol = static_cast<int>(what.size());
  int n = 0;
  for (int d = 0; d < jt.nde; d++)
    if (atom->mask[jt.self[d]] & groupbit)
      for (int s = 0; s < 6; s++) n += counts(d, s);
  size_local_rows = n;
  if (n > nmax) grow(n);
  n = 0;
  for (int d = 0; d < jt.nde; d++) {
    if (!(atom->mask[jt.self[d]] & groupbit)) continue;
    for (int s = 0; s < 6; s++) {
      if (!counts(d, s)) continue;
      defe::JointView view;
      if (views) view = pair->view(d, s);
      const bool tied = sys->joints.is_tied(d, s);
      for (int c = 0; c < ncol; c++) {
        const double value = tied ? value_of_tied(what[c], d, s, view)
                                  : value_of(what[c], d, s, view);
        if (ncol == 1)
          vector_local[n] = value;
        else
          array_local[n][c] = value;
      }
      n++;
    }
  }
}

void ComputeDefeJointLocal::grow(int n)
{
  const int ncol = static_cast<int>(what.size());
  nmax = n;
  if (ncol == 1) {
    memory->destroy(vector_local);
    memory->create(vector_local, nmax, "defe/joint/local:vector");
  } else {
    memory->destroy(array_local);
    memory->create(array_local, nmax, ncol, "defe/joint/local:array");
  }
}

double ComputeDefeJointLocal::value_of(Quantity q, int d, int s, const defe::JointView &view) const
{
  const auto &jt = sys->joints;
  const DERecord &r = *jt.rec(d);
  const JointRecord &slot = r.slot[s];
  switch (q) {
    case ID1:
      return static_cast<double>(atom->tag[jt.self[d]]);
    case ID2:
      return static_cast<double>(r.other[s]);
    case ATOM2:
      return static_cast<double>(slot.kind == DefeJoint::TIE ? r.tie->of[s][0] : r.other[s]);
    case KIND:
      return slot.kind;
    case STATE:
      return slot.state;
    case PART:
      return r.part + 1;
    case DAMAGE:
      return view.damage;
    case OPENING:
      return view.opening;
    case SLIP:
      return view.slip;
    case TN:
      return view.t_n;
    case TS:
      return view.t_s;
    case X:
    case Y:
    case Z:
      return view.point[q - X];
    case NX:
    case NY:
    case NZ:
      return view.normal[q - NX];
    case AREA:
      return slot.area;
    case LENGTH:
      return view.length;
    case LENGTH0:
      return jt.len[d][s];
  }
  return 0.0;
}

/* ----------------------------------------------------------------------
   of a joint to a tied surface: what differs, since no record is of it
------------------------------------------------------------------------- */

double ComputeDefeJointLocal::value_of_tied(Quantity q, int d, int s,
                                            const defe::JointView &view) const
{
  const auto &jt = sys->joints;
  switch (q) {
    case ID2:
      return static_cast<double>(sys->tied_des.main_piece(jt.self[d], s).other);
    case ATOM2:
      return static_cast<double>(sys->tied_des.main_piece(jt.self[d], s).main_end());
    case KIND:
      return DefeJoint::PLACE;
    case STATE:
      return DefeJoint::CONNECTIVE;
    case AREA:
      return jt.share_of_place(d, s) * jt.rec(d)->slot[s].area;
    case LENGTH0:
      return jt.cell[d - jt.orthogonal].dX[s].norm();
    default:
      return value_of(q, d, s, view);
  }
}

int ComputeDefeJointLocal::pack_forward_comm(int n, int *list, double *buf, int, int *)
{
  for (int k = 0; k < n; k++) buf[k] = ubuf(atom->mask[list[k]]).d;
  return n;
}

void ComputeDefeJointLocal::unpack_forward_comm(int n, int first, double *buf)
{
  for (int k = 0; k < n; k++) atom->mask[first + k] = static_cast<int>(ubuf(buf[k]).i);
}

double ComputeDefeJointLocal::memory_usage()
{
  return static_cast<double>(nmax) * what.size() * sizeof(double);
}
