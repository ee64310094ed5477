/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifdef FIX_CLASS
// clang-format off
FixStyle(defe/wall,FixDefeWall);
// clang-format on
#else

#ifndef LMP_FIX_DEFE_WALL_H
#define LMP_FIX_DEFE_WALL_H

#include "fix.h"

#include "defe/types.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

/** Planes, or the surface of a region, that finite elements and DEs cannot pass. */
class FixDefeWall : public Fix {
 public:
  FixDefeWall(class LAMMPS *, int, char **);
  int setmask() override;
  void init() override;
  void setup_pre_neighbor() override { pre_neighbor(); }
  void min_pre_neighbor() override { pre_neighbor(); }
  void pre_neighbor() override;
  void setup_pre_reverse(int eflag, int vflag) override { pre_reverse(eflag, vflag); }
  void min_pre_reverse(int eflag, int vflag) override { pre_reverse(eflag, vflag); }
  void pre_reverse(int, int) override;
  double compute_scalar() override;
  double compute_vector(int) override;
  void *extract(const char *, int &) override;
  double memory_usage() override;

  /** Before a conversion: keep the energy at the current positions. That after it follows with the
      next tables, and the difference is booked with the conversion. */
  void note_energy();

  std::string words;    // the arguments, as given

 private:
  struct Plane {
    int dim;
    double side, place;    // side: +1 lets live above, -1 below
  };
  std::vector<Plane> planes;
  std::string region_id;
  class Region *region = nullptr;
  double factor = 0.2, friction = 0.0;
  double stiffest = 0.0;    // bulk modulus of any part, for rigid ones
  struct DefeSystem *sys = nullptr;

  // what may touch the wall before the next reneighbouring

  struct Face {
    int node[4];
    double k_area;
  };
  struct Sphere {
    int atom;
    double reach, k;
  };
  std::vector<Face> faces;
  std::vector<Sphere> spheres;

  struct Overlap {
    double depth;
    defe::Vec3 normal;    // out of the wall
  };
  std::vector<Overlap> overlaps;    // of the point asked last
  std::vector<Overlap> of_node[4];
  void find_overlaps(const double *x, double reach);
  void add_overlap(double depth, const defe::Vec3 &normal);

  double energy = 0.0;    // of this rank, at the last force evaluation
  double sums[4];         // the same, and the force on the wall
  double sums_all[4];
  bool summed = false;
  double energy_before_conversion = 0.0;
  bool converting = false;
  double energy_now();
  bool depths_of(const Face &face, size_t wall, double *depth, defe::Vec3 *normal);
  void push_faces();
  void push_spheres();
  void tally(const defe::Vec3 &arm, const defe::Vec3 &force);
};

}    // namespace LAMMPS_NS

#endif
#endif
