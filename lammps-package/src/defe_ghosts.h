/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_GHOSTS_H
#define LMP_DEFE_GHOSTS_H

#include "defe_component.h"

#include <vector>

namespace LAMMPS_NS {

/** What goes to ghosts, or comes back from them. */
class DefeMessage {
 public:
  virtual ~DefeMessage() = default;
  /** \param shift  of positions, across a periodic border */
  virtual int pack_forward(int /*n*/, const int * /*list*/, const double * /*shift*/,
                           double * /*buf*/)
  {
    return 0;
  }
  virtual void unpack_forward(int /*n*/, int /*first*/, const double * /*buf*/) {}
  virtual int pack_reverse(int /*n*/, int /*first*/, double * /*buf*/) { return 0; }
  virtual void unpack_reverse(int /*n*/, const int * /*list*/, const double * /*buf*/) {}
};

/** Ghosts, only as far away as elements, joints and contacts need them; and messages to them. */
class DefeGhosts : protected DefeComponent {
 public:
  using DefeComponent::DefeComponent;

  // with the host's communication; size: most doubles per atom

  void forward(DefeMessage &, int size);
  void reverse(DefeMessage &, int size);
  int pack_forward(int n, const int *list, double *buf, int pbc_flag, const int *pbc);
  void unpack_forward(int n, int first, const double *buf);
  int pack_reverse(int n, int first, double *buf);
  void unpack_reverse(int n, const int *list, const double *buf);

  /** Whether there can be any. */
  bool any() const;

  /** Before a run: cutoff for what can be needed in it; collective. */
  void find_largest_ball();
  void set_cutoff();
  /** The same once LAMMPS has its collections of types: with comm_modify mode multi only balls reach as far as they need. */
  void set_cutoff_of_types();
  /** Distance from its sub-domain to which a rank needs ghosts. */
  double reach() const { return reach(largest_ball_); }
  /** More ghosts from the next exchange on, if elements have become longer or there are DEs now. */
  void provide(double longest);
  /** The ghost cutoff is what is needed now, for elements no longer than at the last reneighbouring. */
  bool enough() const;
  /** The ghost cutoff is certainly enough for elements of this length. */
  double provided() const;
  double largest_ball() const { return largest_ball_; }

  void make_for_setup();
  void find_all_nodes();
  /** Current positions and velocities: LAMMPS does not send them on a reneighbouring step. */
  void update_positions();
  /** Masses, which nodes lose as elements convert: LAMMPS sends them on a reneighbouring step only. */
  void update_masses();

 private:
  double longest_provided =
      0.0;    // distance between nodes of an element that the cutoff is enough for
  double largest_ball_ = 0.0;
  std::vector<double> ball;    // largest radius by type, of spheres that are no DEs
  DefeMessage *message = nullptr;
  bool told_of_mode = false;

  double reach(double ball_radius) const;
  bool by_type() const;
  void tell_of_mode();
  bool raise();
  bool longest_of_all(double &longest) const;

  class Masses : public DefeMessage {
   public:
    explicit Masses(Atom *a) : atom(a) {}
    int pack_forward(int n, const int *list, const double *shift, double *buf) override;
    void unpack_forward(int n, int first, const double *buf) override;

   private:
    Atom *atom;
  };

  class Positions : public DefeMessage {
   public:
    explicit Positions(Atom *a) : atom(a) {}
    int pack_forward(int n, const int *list, const double *shift, double *buf) override;
    void unpack_forward(int n, int first, const double *buf) override;

   private:
    Atom *atom;
  };
};

}    // namespace LAMMPS_NS

#endif
