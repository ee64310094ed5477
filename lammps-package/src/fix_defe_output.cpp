/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   What one can see: energies, counts, events, and the outer faces for dump image.
------------------------------------------------------------------------- */

#include "fix_defe.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "update.h"

#include "defe/fe/principal.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#if __has_include("graphics.h")
#include "graphics.h"
static constexpr int IMAGE_TRI = LAMMPS_NS::Graphics::TRI;
#else
static constexpr int IMAGE_TRI = 2;    // dump_image.cpp of 4Feb2025
#endif

using namespace LAMMPS_NS;
namespace entries = defe::entries;
using defe::Vec3;
using defe::fe::HexCoords;

/* ----------------------------------------------------------------------
   strain energy of all elements of this rank at the current positions
------------------------------------------------------------------------- */

double FixDefe::fe_energy_all()
{
  const size_t nall = atom->nlocal + atom->nghost;
  scratch.assign(3 * nall + 3, 0.0);
  std::vector<double> energy;
  double sum = 0.0;
  for (auto &b : batches) {
    if (b.rigid || b.node.empty()) continue;
    energy.assign(b.node.size(), 0.0);
    defe::fe::HexKernel::Output out;
    out.energy = energy.data();
    if (!b.history.empty()) out.history = b.history.data();
    kernels[b.kernel].kernel->add_forces(static_cast<int>(b.node.size()),
                                         reinterpret_cast<const int(*)[8]>(b.node.data()),
                                         &atom->x[0][0], &xframe[0][0], scratch.data(), out);
    for (double e : energy) sum += e;
  }
  return sum;
}

/* ----------------------------------------------------------------------
   elastic energy of elements and surface contact, for fix_modify energy yes
------------------------------------------------------------------------- */

double FixDefe::compute_scalar()
{
  fill_vector();
  return vector_values[entries::E_ELEMENTS] + surface_energy_all;
}

double FixDefe::compute_vector(int n)
{
  fill_vector();
  return vector_values[n];
}

double FixDefe::kinetic_energy(int i) const
{
  const double *v = atom->v[i], *w = atom->omega[i];
  return 0.5 * atom->rmass[i] *
      (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] +
       0.4 * atom->radius[i] * atom->radius[i] * (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]));
}

/* ----------------------------------------------------------------------
   of this rank, at this step
------------------------------------------------------------------------- */

void FixDefe::count_joints_and_motion(defe::EntryValues &mine)
{
  // with a slow clock, nodes have had half of the impulse of m steps, or are still to get it: their
  // kinetic energy is that of the velocity which the elements' forces of now would have given them

  double ahead = 0.0;
  if (!subcycle.due()) {
    ahead = subcycle.velocity_lead(update->dt);
    comm_mode = FINITE;
    comm->reverse_comm(this, 3);
  }

  static constexpr defe::Entry of_joint[] = {entries::CONNECTIVE, entries::COHESIVE,
                                             entries::CONTACT};
  static constexpr defe::Entry of_tie[] = {entries::TIES, entries::TIES_SOFTENING,
                                           entries::TIES_BROKEN};
  double kinetic = 0.0;
  const int nlocal = atom->nlocal;
  for (int i = 0; i < nlocal; i++) {
    if (de[i]) {
      for (const auto &slot : de[i]->slot) {
        if (slot.kind == DefeJoint::TIE)
          mine[of_tie[slot.state]] += 1.0;
        else if (slot.kind == DefeJoint::DE && atom->tag[i] < slot.other)
          mine[of_joint[slot.state]] += 1.0;
      }
    } else if (!in_account(i))
      continue;
    kinetic += kinetic_energy(i);
    if (ahead == 0.0 || de[i]) continue;
    for (int k = 0; k < 3; k++) {
      const double v = atom->v[i][k];
      if (v == 0.0) continue;    // held
      const double dv = ahead * scratch[3 * i + k] / atom->rmass[i];
      kinetic += 0.5 * atom->rmass[i] * (dv * dv - 2.0 * v * dv);
    }
  }
  mine[entries::E_KINETIC] = kinetic;
}

/* ----------------------------------------------------------------------
   largest principal stress at the centres of elements of this rank that can convert, -1e300 if there are none
------------------------------------------------------------------------- */

double FixDefe::largest_stress() const
{
  double s1 = -1.0e300;
  for (const auto &b : batches) {
    if (!b.convertible) continue;
    const auto &kernel = *kernels[b.kernel].kernel;
    // bounds of other criteria say nothing about it
    const auto &part = parts[kernels[b.kernel].part];
    const bool bounded = part.criterion->bound() == defe::fe::StressBound();
    for (size_t e = 0; e < b.node.size(); e++) {
      if (bounded && b.bound[e] <= s1) continue;
      HexCoords x, X;
      hex_coords(b.node[e].data(), x, X);
      s1 = MAX(s1, defe::fe::max_principal(kernel.stress(x, X, Vec3::Zero())));
    }
  }
  return s1;
}

/* ---------------------------------------------------------------------- */

void FixDefe::fill_vector()
{
  // between runs these are the values of the last one: commands like write_restart move atoms to other
  // ranks, and the tables of local indices do not hold any more

  if (between_runs || vector_step == update->ntimestep) return;
  vector_step = update->ntimestep;

  struct Sums {
    defe::EntryValues entry{};
    double surface = 0.0, gone = 0.0;
  } mine, all;
  static_assert(sizeof(Sums) == (entries::COUNT + 2) * sizeof(double),
                "it is reduced as one array");

  mine.entry[entries::E_ELEMENTS] = fe_energy_all();
  count_joints_and_motion(mine.entry);
  mine.entry[entries::E_JOINTS] = stored.joints;
  mine.entry[entries::E_TIES] = stored.ties;
  mine.entry[entries::E_COHESIVE] = stored.cohesive;
  mine.entry[entries::E_CONTACT] = stored.contact + wall_energy();
  ledger.fill(mine.entry);
  mine.surface = contact_energy;
  mine.gone = static_cast<double>(des_gone);
  const double s1 = largest_stress();
  double s1_all;
  MPI_Allreduce(&mine, &all, entries::COUNT + 2, MPI_DOUBLE, MPI_SUM, world);
  MPI_Allreduce(&s1, &s1_all, 1, MPI_DOUBLE, MPI_MAX, world);

  auto &w = vector_values;
  w = all.entry;
  surface_energy_all = all.surface;
  w[entries::E_CONTACT] += all.surface;
  w[entries::ELEMENTS] = static_cast<double>(hexes_total);
  w[entries::CONVERTED] = static_cast<double>(conversions_total);
  w[entries::DES] = static_cast<double>(des_total) - all.gone;
  w[entries::S1_MAX] = s1_all > -1.0e300 ? s1_all : 0.0;
  report_contacts();
  w[entries::LET_THROUGH] = static_cast<double>(through_total);
  w[entries::TOTAL] = defe::total_of(w);
  w[entries::BALANCE] = defe::balance_of(w);
  double first[2] = {first_conversion, first_damage};
  for (auto &t : first)
    if (t < 0.0) t = HUGE_VAL;
  MPI_Allreduce(first, &w[entries::FIRST_CONVERSION], 2, MPI_DOUBLE, MPI_MIN, world);
  for (int k : {entries::FIRST_CONVERSION, entries::FIRST_DAMAGE})
    if (w[k] == HUGE_VAL) w[k] = -1.0;
}

/* ----------------------------------------------------------------------
   outer faces of the finite elements, two triangles each
   dump image shades a triangle by (p1-p2) x (p3-p2): clockwise seen from outside
------------------------------------------------------------------------- */

int FixDefe::image(int *&objs, double **&parms)
{
  image_vec.clear();
  image_data.clear();
  for (const auto &b : batches)
    for (size_t e = 0; e < b.node.size(); e++)
      for (int f = 0; f < 6; f++) {
        if (b.hex[e]->nb[f] > 0) continue;
        const int *face = defe::fe::hex_face[f];
        static constexpr int corner[2][3] = {{0, 2, 1}, {0, 3, 2}};
        for (const auto &tri : corner) {
          image_vec.push_back(IMAGE_TRI);
          image_data.push_back(atom->type[b.node[e][0]]);
          for (int k : tri)
            for (int d = 0; d < 3; d++) image_data.push_back(atom->x[b.node[e][face[k]]][d]);
        }
      }
  image_rows.clear();
  for (size_t k = 0; k < image_vec.size(); k++) image_rows.push_back(&image_data[10 * k]);
  objs = image_vec.data();
  parms = image_rows.data();
  return static_cast<int>(image_vec.size());
}
