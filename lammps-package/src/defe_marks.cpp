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
#include "update.h"

#include "defe/fe/hex8.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using defe::Vec3;
using defe::fe::HexCoords;

// conversion stresses that an element has when it is first seen above its own, from which on that is told
static constexpr double JUMP_LIMIT = 2.0;

DefeMarks::DefeMarks(DefeSystem &system) : DefeComponent(system) {}

DefeMarks::~DefeMarks()
{
  take();
}

/* ----------------------------------------------------------------------
   elements into which a crack is about to grow (slot.asks of the DEs in front of them, which the rank of the
   element has as ghosts)
------------------------------------------------------------------------- */

// with "check yes": the list of elements that are to convert is what a look at all of them finds

static void check_list(const DefeSystem &sys, const std::unordered_set<tagint> &asked)
{
  size_t marked = 0, missed = 0;
  for (const auto &b : sys.elements.batches())
    for (const auto *h : b.hex) {
      marked += h->marked != 0;
      missed += b.convertible && !h->marked && asked.count(h->id);
    }
  if (missed || marked != sys.elements.marked().size())
    sys.lmp->error->one(FLERR,
                        "Fix defe at step {}: {} elements are marked, {} are listed, {} that "
                        "cracks ask for are not",
                        sys.lmp->update->ntimestep, marked, sys.elements.marked().size(), missed);
}

void DefeMarks::mark_asked()
{
  if (!cracks_ask_) return;
  asked.known.clear();
  for (int ds : sys.joints.asking) {
    const tagint element = sys.joints.rec(ds / 6)->other[ds % 6];
    asked.at[sys.joints.self[ds / 6]].push_back(element);
    asked.known.insert(element);
  }
  if (comm->nprocs > 1 || atom->nghost > 0) sys.ghosts.forward(asked, MESSAGE_SIZE);
  asked.at.clear();
  // a face of each has DEs before it
  if (!asked.known.empty())
    for (const auto &one : sys.elements.fronts()) {
      const DefeBatch &b = sys.elements.batches()[one.first];
      if (b.convertible && asked.known.count(b.hex[one.second]->id))
        sys.elements.mark(one.first, one.second);
    }
  if (sys.model.checking) check_list(sys, asked.known);
}

int DefeMarks::Asked::pack_forward(int n, const int *list, const double *, double *buf)
{
  int m = 1;
  for (int ii = 0; ii < n && !at.empty(); ii++) {
    const auto found = at.find(list[ii]);
    if (found == at.end()) continue;
    buf[m++] = ubuf(ii).d;
    buf[m++] = ubuf(static_cast<int>(found->second.size())).d;
    for (tagint element : found->second) buf[m++] = ubuf(element).d;
  }
  buf[0] = ubuf(m).d;
  return m;
}

void DefeMarks::Asked::unpack_forward(int, int first, const double *buf)
{
  int m = 0;
  const int end = static_cast<int>(ubuf(buf[m++]).i);
  while (m < end) {
    auto &here = at[first + static_cast<int>(ubuf(buf[m++]).i)];    // on its way to a third rank
    for (int k = static_cast<int>(ubuf(buf[m++]).i); k > 0; k--) {
      here.push_back(static_cast<tagint>(ubuf(buf[m++]).i));
      known.insert(here.back());
    }
  }
}

/* ----------------------------------------------------------------------
   the criterion's value of an element, at its centre or the largest of its Gauss points
------------------------------------------------------------------------- */

double DefeMarks::value_of(const DefeBatch &b, int e, Vec3 &direction) const
{
  const auto &criterion = *sys.model.parts[b.part()].criterion;
  const auto &kernel = b.kernel();
  HexCoords x, X;
  sys.elements.kernel_coords(*b.hex[e], b.nodes(e).data(), x, X);
  if (!sys.model.gauss_stress) return criterion.value(kernel.stress(x, X, Vec3::Zero()), direction);
  double largest = -1.0e300;
  for (const auto &xi : defe::fe::gauss_points()) {
    Vec3 here;
    const double value = criterion.value(kernel.stress(x, X, xi), here);
    if (value <= largest) continue;
    largest = value;
    direction = here;
  }
  return largest;
}

/* ----------------------------------------------------------------------
   must it wait for the crack beside it? Shields that have expired are dropped.
------------------------------------------------------------------------- */

bool DefeMarks::is_shielded(HexRecord &h, const DefePart &p, double value, double limit,
                            const Vec3 &direction) const
{
  if (!sys.model.shield || !h.extra || h.extra->shields.empty()) return false;
  const double time = sys.clock.now(), tau = p.shield_time;
  auto &list = h.extra->shields;
  for (size_t k = 0; k < list.size();)
    if (time - list[k].time >= tau) {
      list[k] = list.back();
      list.pop_back();
    } else
      k++;
  return defe::shielded(direction, value, limit, time, tau, list.data(),
                        static_cast<int>(list.size()));
}

/* ----------------------------------------------------------------------
   which elements convert at the next step. With "collect" they wait, marked, for the end of a window of so many
   steps, which begins at a multiple of them: it depends on the step alone, not on ranks or restarts.
------------------------------------------------------------------------- */

bool DefeMarks::closes(bigint evaluation) const
{
  const bigint steps = window();
  return evaluation / steps != (evaluation + sys.clock.subcycle().every()) / steps;
}

int DefeMarks::window() const
{
  return sys.model.collect > 0 ? sys.model.collect : longest_window();
}

int DefeMarks::longest_window() const
{
  double longest = HUGE_VAL;
  for (const auto &p : sys.model.parts)
    if (waits(p)) longest = std::min(longest, de_spacing(p) / crack_speed(p));
  if (!(update->dt > 0.0) || !std::isfinite(longest)) return 1;
  // the last digits of a step that others have set are not to decide
  return static_cast<int>(std::clamp(longest / update->dt * (1.0 + 1.0e-9), 1.0, 1.0e6));
}

/* ----------------------------------------------------------------------
   a crack waits for elements that are collected. It runs at up to half the speed of shear waves, and asks for them
   a DE ahead: the spacing of DEs is that of the fastest wave between them in their stable step.
------------------------------------------------------------------------- */

bool DefeMarks::waits(const DefePart &p) const
{
  return p.convertible && p.start != "all" && sys.mesh.dt_joints() > 0.0 &&
      !(p.stress > sys.model.material_of(p).elastic().E);
}

double DefeMarks::crack_speed(const DefePart &p) const
{
  const auto &elastic = sys.model.material_of(p).elastic();
  return 0.5 * std::sqrt(elastic.mu() / elastic.rho);
}

double DefeMarks::de_spacing(const DefePart &p) const
{
  const auto &elastic = sys.model.material_of(p).elastic();
  return sys.mesh.dt_joints() * std::sqrt((elastic.lambda() + 4.0 * elastic.mu()) / elastic.rho);
}

void DefeMarks::mark()
{
  for (size_t k = 0; k < sys.elements.batches().size(); k++) mark_batch(static_cast<int>(k));
  if (!closes(update->ntimestep)) return;
  // only what cracks ask for now: those that have asked before do so again, unless they have turned away
  if (!sys.joints.asking.empty()) marked_here = MAX(marked_here, 1);
  ask();
}

void DefeMarks::mark_batch(int k)
{
  const DefeBatch &b = sys.elements.batches()[k];
  if (!b.convertible) return;
  const DefePart &p = sys.model.parts[b.part()];
  const double *own = sys.strengths.limits(k);    // of each element, by its flaws
  const double least = own ? sys.strengths.least_limit(k) : p.criterion->limit();
  const double *bound = b.bounds();
  const int n = b.size();
  int above = 0;
  for (int e = 0; e < n; e++) above += bound[e] > least;
  if (!above) return;
  for (int e = 0; e < n; e++) {
    const double limit = own ? own[e] : least;
    if (!(bound[e] > limit)) continue;
    HexRecord &h = *b.hex[e];
    if (h.marked) continue;
    Vec3 direction(1.0, 0.0, 0.0);
    const double value = value_of(b, e, direction);
    if (!(value > limit) || is_shielded(h, p, value, limit, direction)) continue;
    sys.elements.mark(k, e);
    marked_here = MAX(marked_here, 1);
    if (!h.extra || h.extra->shields.empty()) note_jump(h.id, value / limit);
  }
}

/* ----------------------------------------------------------------------
   between two evaluations of the elements, and in a window, those that were marked stay so
------------------------------------------------------------------------- */

void DefeMarks::begin_run()
{
  convert_step = -1;    // what is marked is scheduled anew
  jump = Jump();
  const auto &subcycle = sys.clock.subcycle();
  if (subcycle.due() && window() == 1) sys.elements.unmark_all();
  marked_here = !sys.elements.marked().empty();
  if (subcycle.due())
    mark();
  else if (subcycle.phase() < subcycle.steps_of_impulse() &&
           closes(update->ntimestep - subcycle.phase())) {
    int mine = marked_here || !sys.joints.asking.empty(), all = 0;
    MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_MAX, world);
    if (all) schedule(subcycle.steps_of_impulse() - subcycle.phase());
  }
}

/* ----------------------------------------------------------------------
   the last moment before LAMMPS decides whether to reneighbour
------------------------------------------------------------------------- */

void DefeMarks::answer()
{
  if (request == MPI_REQUEST_NULL) return;
  take();
  if (marked_anywhere) schedule(sys.clock.subcycle().steps_of_impulse() - 1);
  if (marked_anywhere > 1) report_jump();
}

/* ----------------------------------------------------------------------
   a run with `pre no` does not ask again whether elements convert in the next step
------------------------------------------------------------------------- */

void DefeMarks::end_run()
{
  const bool asked_for = request != MPI_REQUEST_NULL;
  take();
  if (asked_for && marked_anywhere) schedule(sys.clock.subcycle().steps_of_impulse());
  if (asked_for && marked_anywhere > 1) report_jump();
}

bool DefeMarks::any()
{
  take();
  return convert_step >= 0 || marked_anywhere;
}

/* ----------------------------------------------------------------------
   half of the impulse of m steps is still to come when elements are marked: they convert when
   their forces have ended
------------------------------------------------------------------------- */

void DefeMarks::schedule(int steps)
{
  convert_step = update->ntimestep + steps;
  sys.host->next_reneighbor = convert_step;
}

bool DefeMarks::due() const
{
  return update->ntimestep == convert_step;
}

void DefeMarks::done()
{
  convert_step = -1;
  marked_here = 0;
  jump = Jump();
  sys.host->next_reneighbor = -1;
}

void DefeMarks::follow(bigint steps)
{
  if (convert_step < 0) return;
  convert_step += steps;
  sys.host->next_reneighbor = convert_step;
}

/* ----------------------------------------------------------------------
   all ranks must reneighbour together: one number is reduced while LAMMPS goes on
------------------------------------------------------------------------- */

void DefeMarks::ask()
{
  take();
  MPI_Iallreduce(&marked_here, &marked_anywhere, 1, MPI_INT, MPI_MAX, world, &request);
}

void DefeMarks::take()
{
  if (request != MPI_REQUEST_NULL) MPI_Wait(&request, MPI_STATUS_IGNORE);
}

/* ----------------------------------------------------------------------
   the criterion is evaluated at every step: an element that is far above it at once means that the load rises
   faster than the steps can follow, and neighbours convert with it that would have been relieved. (Elements that
   shielding may have held back say nothing about this.) It needs no message of its own: it travels with the marks.
------------------------------------------------------------------------- */

void DefeMarks::note_jump(tagint tag, double ratio)
{
  if (jump_told || ratio < JUMP_LIMIT || ratio < jump.ratio) return;
  if (ratio == jump.ratio && tag > jump.id) return;
  jump.ratio = ratio;
  jump.id = tag;
  marked_here = 2;
}

void DefeMarks::report_jump()
{
  jump_told = true;
  struct {
    double ratio;
    int rank;
  } mine = {jump.ratio, comm->me}, most;
  MPI_Allreduce(&mine, &most, 1, MPI_DOUBLE_INT, MPI_MAXLOC, world);
  tagint lowest = mine.ratio == most.ratio ? jump.id : MAXTAGINT, tag;
  MPI_Allreduce(&lowest, &tag, 1, MPI_LMP_TAGINT, MPI_MIN, world);
  if (comm->me == 0)
    error->warning(
        FLERR,
        "Fix defe: element {} was {:.3g} times above its conversion stress when it was first seen "
        "above (step {}): the load comes faster than the steps can follow, and more converts than "
        "should: use a smaller timestep, less load at the start, or a higher conversion stress",
        tag, most.ratio, sys.clock.last_step());
}
