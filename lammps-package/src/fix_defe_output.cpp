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
  return vector_values[8] + surface_energy_all;
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

/* ---------------------------------------------------------------------- */

void FixDefe::fill_vector()
{
  // between runs these are the values of the last one: commands like write_restart move atoms to other
  // ranks, and the tables of local indices do not hold any more

  if (between_runs || vector_step == update->ntimestep) return;
  vector_step = update->ntimestep;

  enum {
    CONNECTIVE,
    COHESIVE,
    CONTACT,
    TIES,
    TIES_COHESIVE,
    TIES_BROKEN,
    E_FE,
    E_JOINTS,
    E_TIES,
    E_COHESIVE,
    E_SURFACE,
    E_SPHERES,
    KINETIC,
    FRACTURE,
    RELEASE,
    DAMPING,
    FRICTION,
    CONV_STRAIN,
    CONV_KINETIC,
    EXTERNAL,
    GONE,
    VISCOUS,
    THROUGH,
    NSUM
  };
  double mine[NSUM] = {0.0}, all[NSUM];

  mine[E_FE] = fe_energy_all();

  // with a slow clock, nodes have had half of the impulse of m steps, or are still to get it: their
  // kinetic energy is that of the velocity which the elements' forces of now would have given them

  double ahead = 0.0;
  if (fe_every > 1 && fe_clock > 0) {
    ahead = (0.5 * fe_every - fe_clock) * update->dt;
    comm_mode = FINITE;
    comm->reverse_comm(this, 3);
  }

  const int nlocal = atom->nlocal;
  for (int i = 0; i < nlocal; i++) {
    if (de[i]) {
      for (const auto &slot : de[i]->slot) {
        if (slot.kind == DefeJoint::TIE)
          mine[TIES + slot.state] += 1.0;
        else if (slot.kind == DefeJoint::DE && atom->tag[i] < slot.other)
          mine[CONNECTIVE + slot.state] += 1.0;
      }
    } else if (!in_account(i))
      continue;
    mine[KINETIC] += kinetic_energy(i);
    if (ahead == 0.0 || de[i]) continue;
    for (int k = 0; k < 3; k++) {
      const double v = atom->v[i][k];
      if (v == 0.0) continue;    // held
      const double dv = ahead * scratch[3 * i + k] / atom->rmass[i];
      mine[KINETIC] += 0.5 * atom->rmass[i] * (dv * dv - 2.0 * v * dv);
    }
  }
  mine[E_JOINTS] = stored.joints;
  mine[E_TIES] = stored.ties;
  mine[E_COHESIVE] = stored.cohesive;
  mine[E_SURFACE] = contact_energy;
  mine[E_SPHERES] = stored.contact + wall_energy();
  mine[FRACTURE] = ledger.fracture;
  mine[RELEASE] = ledger.release;
  mine[DAMPING] = ledger.damping;
  mine[FRICTION] = ledger.friction;
  mine[CONV_STRAIN] = ledger.conv_strain;
  mine[CONV_KINETIC] = ledger.conv_kinetic;
  mine[EXTERNAL] = ledger.external;
  mine[VISCOUS] = ledger.viscous;
  mine[THROUGH] = ledger.through;
  mine[GONE] = static_cast<double>(des_gone);

  double s1 = -1.0e300, s1_all;
  for (const auto &b : batches) {
    if (!b.convertible) continue;
    const auto &kernel = *kernels[b.kernel].kernel;
    for (size_t e = 0; e < b.node.size(); e++) {
      if (b.bound[e] <= s1) continue;
      HexCoords x, X;
      hex_coords(b.node[e].data(), x, X);
      s1 = MAX(s1, defe::fe::max_principal(kernel.stress(x, X, Vec3::Zero())));
    }
  }
  MPI_Allreduce(mine, all, NSUM, MPI_DOUBLE, MPI_SUM, world);
  MPI_Allreduce(&s1, &s1_all, 1, MPI_DOUBLE, MPI_MAX, world);

  surface_energy_all = all[E_SURFACE];
  double *w = vector_values;
  w[0] = static_cast<double>(hexes_total);
  w[1] = static_cast<double>(conversions_total);
  w[2] = static_cast<double>(des_total) - all[GONE];
  w[3] = all[CONNECTIVE];
  w[4] = all[COHESIVE];
  w[5] = all[CONTACT];
  w[6] = all[TIES];
  w[7] = s1_all > -1.0e300 ? s1_all : 0.0;
  w[8] = all[E_FE];
  w[9] = all[E_JOINTS];
  w[10] = all[E_TIES];
  w[11] = all[E_COHESIVE];
  w[12] = all[E_SURFACE] + all[E_SPHERES];
  w[13] = all[KINETIC];
  w[14] = all[FRACTURE];
  w[15] = all[RELEASE];
  w[16] = all[DAMPING];
  w[17] = all[FRICTION];
  w[18] = all[CONV_STRAIN];
  w[19] = all[CONV_KINETIC];
  w[20] = all[EXTERNAL];
  w[25] = all[VISCOUS];
  report_contacts();
  w[28] = static_cast<double>(through_total);
  w[29] = all[THROUGH];
  w[26] = all[TIES_COHESIVE];
  w[27] = all[TIES_BROKEN];
  w[21] = w[8] + w[9] + w[10] + w[11] + w[12] + w[13] + w[14] + w[15] + w[16] + w[17] + w[25] +
      all[THROUGH] - w[20];
  w[22] = w[21] + w[18] + w[19];
  double first[2] = {first_conversion, first_damage};
  for (auto &t : first)
    if (t < 0.0) t = HUGE_VAL;
  MPI_Allreduce(first, &w[23], 2, MPI_DOUBLE, MPI_MIN, world);
  for (int k : {23, 24})
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
