/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_VTK_KINDS_H
#define LMP_DEFE_VTK_KINDS_H

#include "pointers.h"

#include "defe/coupling/vtk_grid.h"

#include <array>
#include <string>
#include <vector>

namespace LAMMPS_NS {

class Compute;
class Fix;
class Region;
struct DefeSystem;

/** What fix defe/vtk writes of elements, of spheres or of joints. Values come from the computes that dumps use. */
class DefeVtkKind : protected Pointers {
 public:
  /** A value that can be chosen. */
  struct Field {
    const char *name;
    int components;
    bool whole;
    bool needs_flaws;            // only there with the keyword strength of fix defe
    bool needs_metal = false;    // only there if a part yields
  };

  const std::string name;

  /** \param host  whose group is written, and whose communication is used */
  DefeVtkKind(const std::string &name, LAMMPS *, Fix *host);
  virtual ~DefeVtkKind() = default;

  /** Fields by name; without names, all that there are. */
  void choose(const std::vector<std::string> &names);
  /** After the choice. */
  virtual void add_computes() = 0;
  void delete_computes();
  /** Before a run: fix defe may be another one than before, and computes can be deleted by the script. */
  void init();

  /** Collective; what lies in the region, if there is one. Each rank has its own by their IDs. */
  virtual void collect(Region *, defe::VtkGrid &) = 0;

  virtual int pack_forward(int n, const int *list, double *buf);
  virtual void unpack_forward(int n, int first, const double *buf);
  virtual int pack_reverse(int n, int first, double *buf);
  virtual void unpack_reverse(int n, const int *list, const double *buf);

 protected:
  Fix *const host;
  DefeSystem *sys;
  std::vector<int> chosen;    // in fields()

  virtual const std::vector<Field> &fields() const = 0;
  bool has(int field) const;
  void add_compute(const std::string &group, const std::string &style_and_values);
  Compute &compute(int k) const { return *computes[k]; }    // in the order in which they were added
  void sort_by_tag(std::vector<int> &atoms) const;
  bigint before_me(std::size_t mine) const;    // sum over the ranks before this one

 private:
  std::vector<std::string> compute_ids;
  std::vector<Compute *> computes;    // of these IDs, of this run
};

/** Hexahedra, with the nodes that are theirs. A node is written by the rank that owns it. */
class DefeVtkElements : public DefeVtkKind {
 public:
  using DefeVtkKind::DefeVtkKind;
  void add_computes() override;
  void collect(Region *, defe::VtkGrid &) override;

  int pack_forward(int n, const int *list, double *buf) override;
  void unpack_forward(int n, int first, const double *buf) override;
  int pack_reverse(int n, int first, double *buf) override;
  void unpack_reverse(int n, const int *list, const double *buf) override;

 private:
  enum {
    ID,
    PART,
    STRESS,
    S1,
    VONMISES,
    STRENGTH,
    PLASTIC,
    CELLS,
    NODE = CELLS,
    VELOCITY,
    DISPLACEMENT
  };

  struct Hex {
    tagint id;
    int row;    // of the compute
    std::array<int, 8> node;
  };
  std::vector<Hex> hexes;
  std::vector<char> used;        // nodes of these elements, as the next: of owned and ghost atoms
  std::vector<bigint> number;    // of their points in the file

  const std::vector<Field> &fields() const override;
  void find_hexes(Region *);
  void add_nodes(defe::VtkGrid &);
  void add_node(int i, defe::VtkGrid &) const;
  void add_hex(const double *row, defe::VtkGrid &) const;
};

/** DEs, and other spheres, as points with a radius. */
class DefeVtkSpheres : public DefeVtkKind {
 public:
  using DefeVtkKind::DefeVtkKind;
  void add_computes() override;
  void collect(Region *, defe::VtkGrid &) override;

 private:
  enum { ID, TYPE, PART, ELEMENT, RADIUS, DAMAGE, FRAGMENT, VELOCITY, OMEGA, STRENGTH };
  const std::vector<Field> &fields() const override;
  void add_values(int i, defe::VtkGrid &) const;
};

/** Joints and ties that are not broken, and joints to tied surfaces, as lines from a DE to the other one or to the point on
    the face. */
class DefeVtkJoints : public DefeVtkKind {
 public:
  using DefeVtkKind::DefeVtkKind;
  void add_computes() override;
  void collect(Region *, defe::VtkGrid &) override;

 private:
  const std::vector<Field> &fields() const override;
};

}    // namespace LAMMPS_NS

#endif
