/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   Joints that cracks cut by their own planes: when in a step what is asked of DefeCracks, and what
   comes of it: forces on atoms, states, events, the account of energy.
------------------------------------------------------------------------- */

#include "pair_defe_joint.h"

#include "defe_cracks.h"
#include "defe_sphere_contacts.h"
#include "defe_system.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "update.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using defe::Vec3;

// beside the state, in the table and in the message to other ranks: the joint becomes cohesive in the next
// step; in the message also: and the plane of the crack follows
static constexpr int PENDING = 4, PENDING_WITH_PLANE = 5;

/* ----------------------------------------------------------------------
   cracks are followed if any pair of types has a strength without "lattice"
------------------------------------------------------------------------- */

void PairDefeJoint::prepare_cracks()
{
  const int n = laws.types + 1;
  std::vector<double> strength(static_cast<size_t>(n) * n, HUGE_VAL);
  std::vector<defe::CrackNuclei> nuclei(strength.size());
  lattice_beside_cracks = false;
  for (size_t k = 0; k < strength.size() && laws.with_connective && laws.with_cohesive; k++) {
    if (!laws.coeffs[k].has_cohesive) continue;
    if (laws.coeffs[k].lattice)
      lattice_beside_cracks = true;
    else
      strength[k] = laws.coeffs[k].cohesive.sigma_t;
    nuclei[k] = laws.coeffs[k].nuclei;
  }
  cracks = std::make_unique<DefeCracks>(lmp, sys);
  cracks->set_strengths(n, strength, nuclei, laws.moduli);
  with_cracks = cracks->on();
  sys->marks.let_cracks_ask(with_cracks);
  if (!with_cracks) cracks.reset();
}

void PairDefeJoint::update_crack_tables()
{
  cracks->prepare();
  comm_mode = CRACK_TABLE;
  comm->forward_comm(this, DefeCracks::TABLE_SIZE);
  cracks->resolve();
}

/* ----------------------------------------------------------------------
   whether the joint is cut by a plane of its own; else its normal is that of the mesh
------------------------------------------------------------------------- */

bool PairDefeJoint::by_crack(int d, int s) const
{
  if (!with_cracks) return false;
  const int other = sys->joints.nb[d][s];
  if (other < 0) return false;
  return !laws.of(atom->type[sys->joints.self[d]], atom->type[other]).lattice;
}

/* ----------------------------------------------------------------------
   before a run: what has begun to soften, or is a closed plane, goes on by the law that it began with
------------------------------------------------------------------------- */

void PairDefeJoint::check_laws()
{
  const auto &jt = sys->joints;
  bigint mine = 0, all = 0;
  int example = MAXSMALLINT, first = MAXSMALLINT;    // types, and the law
  for (int ds = 0; ds < 6 * jt.nde; ds++) {
    const int d = ds / 6, s = ds % 6, i = jt.self[d];
    const JointSlot &slot = jt.rec[d]->slot[s];
    if (slot.kind != DefeJoint::DE || jt.nb[d][s] < 0 || atom->tag[i] > slot.other) continue;
    if (slot.state != DefeJoint::COHESIVE && !slot.plane && slot.pending != 1) continue;
    bool has_plane = false;
    if (const AtomTouch *t = sys->store.touches(i))
      for (const auto &c : t->cracks) has_plane = has_plane || c.slot == s;
    if (has_plane == by_crack(d, s)) continue;
    const auto types = std::minmax(atom->type[i], atom->type[jt.nb[d][s]]);
    example = MIN(example, 2 * (types.first * (laws.types + 1) + types.second) + has_plane);
    mine++;
  }
  MPI_Allreduce(&mine, &all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (all == 0) return;
  MPI_Allreduce(&example, &first, 1, MPI_INT, MPI_MIN, world);
  const int types = first / 2;
  error->all(FLERR,
             "Pair_coeff {} {} cohesive: {} joints have cracked {} lattice, and their law cannot "
             "change: give it {} lattice as before",
             types / (laws.types + 1), types % (laws.types + 1), all,
             first % 2 ? "without" : "with", first % 2 ? "without" : "with");
}

/* ----------------------------------------------------------------------
   joints that become cohesive in the next step
------------------------------------------------------------------------- */

void PairDefeJoint::note_joint(int ds)
{
  sys->joints.rec[ds / 6]->slot[ds % 6].pending = 1;
  sys->joints.pending.push_back(ds);
}

/* ----------------------------------------------------------------------
   before they are noted anew. Before a run cracks do not decide again: their step is over.
------------------------------------------------------------------------- */

void PairDefeJoint::drop_notes()
{
  auto &jt = sys->joints;
  if (with_cracks) cracks->forget_noted();
  std::vector<int> kept;
  for (int ds : jt.pending) {
    if (update->setupflag && jt.partner[ds / 6][ds % 6] >= 0 && by_crack(ds / 6, ds % 6)) {
      kept.push_back(ds);
      if (cracks->find(ds)) cracks->keep_noted(ds);
    } else
      jt.rec[ds / 6]->slot[ds % 6].pending = 0;
  }
  jt.pending = std::move(kept);
}

void PairDefeJoint::decide_cracks()
{
  auto &jt = sys->joints;
  if (update->setupflag) return;
  cracks->mark();
  comm_mode = CRACK_STRESS;
  comm->forward_comm(this, DefeCracks::STRESS_SIZE);
  cracks->decide();
  for (int joint : cracks->starts()) {
    note_joint(joint);
    const int other = jt.partner[joint / 6][joint % 6];
    if (other < 6 * jt.nde) note_joint(other);
  }
  if (!sys->clock.subcycle().due()) return;
  for (int ds : jt.asking) jt.rec[ds / 6]->slot[ds % 6].asks = 0;
  jt.asking = cracks->entered();
  for (int ds : jt.asking) jt.rec[ds / 6]->slot[ds % 6].asks = 1;
}

/* ----------------------------------------------------------------------
   what this DE's corners let go, for the joints that leave them in the next step
------------------------------------------------------------------------- */

void PairDefeJoint::share_out_release(int d, unsigned leaving)
{
  bool any = false;
  for (int s = 0; s < 6; s++) any = any || ((leaving & 1u << s) && by_crack(d, s));
  if (!any) return;
  double share[6];
  cracks->release(d, leaving, share);
  for (int s = 0; s < 6; s++)
    if ((leaving & 1u << s) && by_crack(d, s)) sys->joints.rec[d]->slot[s].stored = share[s];
}

/* ----------------------------------------------------------------------
   what was noted begins: first that all ranks know of the joints, then what both ends let go
------------------------------------------------------------------------- */

void PairDefeJoint::begin_cracks()
{
  auto &jt = sys->joints;
  cracks->cut_noted();
  std::array<double, 6> share{};
  for (size_t k = 0; k < jt.pending.size(); k++) {    // they are sorted
    const int d = jt.pending[k] / 6, s = jt.pending[k] % 6;
    if (by_crack(d, s)) share[s] = jt.rec[d]->slot[s].stored;
    if (k + 1 < jt.pending.size() && jt.pending[k + 1] / 6 == d) continue;
    cracks->set_shares(d, share);
    share.fill(0.0);
  }
}

void PairDefeJoint::take_over_cracks()
{
  auto &jt = sys->joints;
  for (int ds : jt.cohesive) {
    const int d = ds / 6, s = ds % 6;
    JointSlot &slot = jt.rec[d]->slot[s];
    if (slot.pending != 2 || slot.kind == DefeJoint::TIE || !by_crack(d, s)) continue;
    const auto &law = laws.of(atom->type[jt.self[d]], atom->type[jt.nb[d][s]]).cohesive;
    event(d, s, defe::EventKind::COHESIVE, cracks->take_over(ds, law));
  }
  cracks->end_take_over();
  cracks->forget_ends();
}

/* ----------------------------------------------------------------------
   a softening joint, or the closed plane of a broken one
------------------------------------------------------------------------- */

void PairDefeJoint::crack_forces(int d, int s)
{
  auto &jt = sys->joints;
  const double dt = update->setupflag ? 0.0 : update->dt;
  JointSlot &slot = jt.rec[d]->slot[s];
  if (DefeCracks::rests(slot.plane, dt)) return;
  defe::CrackJoint &law = cracks->find(6 * d + s)->law;
  const JointCoeff &coeff = laws.of(atom->type[jt.self[d]], atom->type[jt.nb[d][s]]);
  const auto r =
      cracks->advance(6 * d + s, law, coeff.cohesive, laws.with_contact ? coeff.friction : 0.0, dt);
  const double stored = law.stored;

  auto &ledger = sys->ledger;
  ledger.fracture += r.fracture;
  ledger.friction += r.rubbed;
  ledger.release += r.dissipated - r.fracture;
  ledger.release += slot.pending ? r.work_new - r.dissipated - stored : r.excess;
  slot.pending = 0;
  slot.lost += r.dissipated;
  slot.stored = stored;
  sys->stored.cohesive += stored;

  if (slot.state == DefeJoint::COHESIVE && law.broken) {
    close_plane(d, s);
    event(d, s, defe::EventKind::BROKEN, 1.0);
  }
  if (r.apart) {
    part_crack(d, s);
    return;
  }
  if (slot.plane) slot.plane = cracks->resting(6 * d + s, law, dt);
  apply_crack(d, s, r);
}

/* ----------------------------------------------------------------------
   forces on both DEs and on the neighbours that their rotation is taken from: in balance, without a moment
------------------------------------------------------------------------- */

void PairDefeJoint::apply_crack(int d, int s, const defe::CrackForces &r)
{
  if (r.force.squaredNorm() == 0.0) return;
  const auto &jt = sys->joints;
  const int there = cracks->other_end(6 * d + s);
  const int end[2] = {d, there / 6};
  const int i = jt.self[d];
  const bool vflag = tally.on();
  const auto pull = [&](int e, const Vec3 &by) {
    const int k = jt.self[e];
    for (int c = 0; c < 3; c++)
      atom->f[k][c] += sys->sums.on_grid(sys->sums.force_grid(), by[c], k);
    if (!vflag || e == d) return;
    // relative to the first DE: its own force has no share then
    const double *xk = atom->x[k], *xi = atom->x[i];
    const double del[3] = {xk[0] - xi[0], xk[1] - xi[1], xk[2] - xi[2]};
    tally(del, by.data(), i);
  };
  pull(end[0], r.force + r.at[0]);
  pull(end[1], r.at[1] - r.force);
  for (int k = 0; k < 2; k++)
    for (int q = 0; q < 6; q++) {
      const int arm = cracks->partners(end[k])[q];
      if (arm >= 0 && r.arm[k][q].squaredNorm() > 0.0) pull(arm / 6, r.arm[k][q]);
    }
  if (r.torque.squaredNorm() == 0.0) return;
  for (int e : end) {
    const int k = jt.self[e];
    const Vec3 moment = sys->sums.rounded_torque(r.torque, k);
    for (int c = 0; c < 3; c++) atom->torque[k][c] += moment[c];
  }
}

/* ----------------------------------------------------------------------
   a joint is broken, but the plane of its crack takes pressure as long as it is closed or nearly so
------------------------------------------------------------------------- */

void PairDefeJoint::close_plane(int d, int s)
{
  auto &jt = sys->joints;
  for (int ds : {6 * d + s, jt.partner[d][s]}) {
    if (ds < 0 || ds >= 6 * jt.nde) continue;
    jt.rec[ds / 6]->slot[ds % 6].state = DefeJoint::CONTACT;
    jt.rec[ds / 6]->slot[ds % 6].plane = 1;
    jt.state[ds] = DefeJoint::PLANE;
  }
}

/* ----------------------------------------------------------------------
   from now on the two are spheres for each other. Each rank finds the distance at which they begin to touch from the
   positions of this step.
------------------------------------------------------------------------- */

void PairDefeJoint::part_crack(int d, int s)
{
  auto &jt = sys->joints;
  cracks->forget(6 * d + s);
  cracks->part(6 * d + s);
  const int other = jt.partner[d][s];
  adopt_state(6 * d + s, DefeJoint::CONTACT);
  if (other >= 0 && other < 6 * jt.nde) {
    jt.rec[other / 6]->slot[other % 6].plane = 0;
    set_apart(other, jt.rec[d]->slot[s].apart);
    jt.state[other] = DefeJoint::CONTACT;
  }
}

/* ----------------------------------------------------------------------
   state of a joint of mine, as its lower end's rank has it
------------------------------------------------------------------------- */

void PairDefeJoint::adopt_state(int ds, int state)
{
  auto &jt = sys->joints;
  const int d = ds / 6, s = ds % 6;
  JointSlot &slot = jt.rec[d]->slot[s];
  if ((state & PENDING) && slot.pending != 1) note_joint(ds);
  state &= ~PENDING;
  if (state == jt.state[ds]) return;
  const bool was_plane = jt.state[ds] == DefeJoint::PLANE;
  jt.state[ds] = static_cast<unsigned char>(state);
  slot.plane = state == DefeJoint::PLANE;
  slot.state = static_cast<signed char>(slot.plane ? DefeJoint::CONTACT : state);
  if (state != DefeJoint::CONTACT) return;
  const int i = jt.self[d], j = jt.nb[d][s];
  // see DefeConversion::distance_if_swung()
  if (was_plane) set_apart(ds, (1.0 - 1.0e-9) * (Vec3(atom->x[j]) - Vec3(atom->x[i])).norm());
  contacts->add(i, j, slot.apart);
}

void PairDefeJoint::set_apart(int ds, double distance)
{
  auto &list = sys->joints.apart;
  JointSlot &slot = sys->joints.rec[ds / 6]->slot[ds % 6];
  slot.apart = distance;
  const auto behind = std::find_if(list.begin(), list.end(), [ds](const JointTable::Apart &a) {
    return a.de > ds / 6;
  });
  list.insert(behind, {ds / 6, slot.other, distance});
}

/* ---------------------------------------------------------------------- */

int PairDefeJoint::pack_state(int d, double *buf) const
{
  const auto &jt = sys->joints;
  int bits = 0, m = 1;
  for (int s = 0; s < 6; s++) {
    int state = jt.state[6 * d + s];
    if (d < jt.nde && jt.rec[d]->slot[s].pending == 1) state |= PENDING;
    if (with_cracks && (state & PENDING) && cracks->pack_memory(6 * d + s, &buf[m])) {
      state = PENDING_WITH_PLANE;
      m += DefeCracks::MEMORY_SIZE;
    }
    bits |= state << (3 * s);
  }
  buf[0] = bits;
  return m;
}

int PairDefeJoint::unpack_state(int d, const double *buf)
{
  auto &jt = sys->joints;
  const int bits = static_cast<int>(buf[0]);
  int m = 1;
  for (int s = 0; s < 6; s++) {
    int state = (bits >> (3 * s)) & 7;
    if (state == PENDING_WITH_PLANE) {
      cracks->unpack_memory(6 * d + s, &buf[m]);
      m += DefeCracks::MEMORY_SIZE;
      state = PENDING;
    }
    const bool changed = jt.state[6 * d + s] != state;
    jt.state[6 * d + s] = static_cast<unsigned char>(state);
    if (!with_cracks || !changed || cracks->other_end(6 * d + s) < 0) continue;
    if (state == DefeJoint::CONTACT) cracks->part(6 * d + s);
    if (state == DefeJoint::COHESIVE && lattice_beside_cracks) cracks->cut(6 * d + s);
  }
  return m;
}
