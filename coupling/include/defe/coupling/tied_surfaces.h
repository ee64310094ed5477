#ifndef DEFE_COUPLING_TIED_SURFACES_H
#define DEFE_COUPLING_TIED_SURFACES_H

/// \file
/// Tied surfaces: faces of two meshes that need not match are glued. The energy of a glue line is
///
///     E = k/2 integral |g|^2 dA,    g = u_A(X) - u_B(X)
///
/// over the area in which two faces lie on each other in the reference configuration, cut out as a polygon and
/// integrated exactly, as in mortar methods (Puso and Laursen 2004): constant stress passes from one mesh into the other with the nodal
/// forces that both have for it (patch test). u_A is that of A's face at X; u_B that of B's element, continued to X if
/// the faces are not quite at one place (surfaces that are curved, or tied at a distance). So g vanishes in every
/// linear displacement field, rotations included, whatever the distance: the forces have neither a sum nor a moment.
///
/// k is `stiffness` times that of a layer of the two elements: a tie yields as much as a mean one of them
/// of 1/stiffness of its height. Between two bodies it must be the same everywhere, that of the softest place: where one
/// place yields less it takes more, and constant stress does not pass.

#include "defe/exact_sum.h"
#include "defe/fe/topology.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace defe {

/// An element with a face that may be tied, in the reference configuration.
struct TiedElement {
  fe::HexCoords X;
  int face;            ///< 0..5, order of fe::hex_face
  double volume;       ///< of the element
  double modulus;      ///< lambda + 2 mu; 0: rigid
  double mass;         ///< of the element
  double frequency;    ///< its largest one (rad/s), 0 if rigid
};

/// What two faces have in common. The forces of a tie on its nodes are -M u, in each direction: 4 of A's face, then
/// those of B's face, in the order of fe::hex_face, and then B's other four, if the faces are not at one place.
struct Tie {
  static constexpr int most_nodes = 12;
  int nodes = 0;    ///< 8 or 12; 0: they have nothing in common
  double area = 0.0;
  double distance = 0.0;    ///< largest one from X on A's face to B's
  std::array<double, most_nodes *(most_nodes + 1) / 2> M{};    ///< lower triangle by rows
  double stiffness = 0.0;                                      ///< k
  /// Of the two elements: the square of the largest frequency, and by what a tie of k = 1 raises it.
  std::array<double, 2> squared{}, raise{};
  /// Of the two elements: stiffness per area of what lies between its face and the DEs behind it, once it is eight DEs
  std::array<double, 2> beside{};

  /// Another k: that of the softest place.
  void set_stiffness(double k);
  /// No mode of the meshes is faster, as far as these two elements and this tie matter.
  /// \param becomes  of each element: it may become DEs, which are tied to the other one then (tied_quarters.h)
  double frequency(const std::array<bool, 2> &becomes = {false, false}) const;
};

/// How surfaces are tied.
struct TieRule {
  double stiffness = 4.0;
  double distance = -1.0;    ///< that is bridged; < 0: a tenth of the smaller face's size
};

/// Ties two faces. Faces that are more than 45 degrees from facing each other have nothing in common. If they are too far
/// apart, nodes is 0, area what they would have in common, and distance what would have to be bridged.
Tie tie_faces(const TiedElement &a, const TiedElement &b, const TieRule &);

/// Local number (0..7) of B's node number k of a tie, k from 0.
int tied_node_of_b(int face, int k);

struct ParsedTie {
  TieRule rule;
  std::string complaint;    ///< one line, if it is not usable
  int used = 0;             ///< number of words that belong to it
};

/// words: what follows the names of the parts, and whatever else is on the line.
///
///     [distance D] [stiffness S]
ParsedTie parse_tie(const std::vector<std::string> &words);
/// As in the script, numbers with all their digits.
std::string words_of(const TieRule &);

/// Ties of one rank, in flat arrays of local indices.
class TiedSurfaces {
 public:
  void clear();
  /// node: indices of its particles.
  void add(const Tie &, const int *node);
  int count() const { return static_cast<int>(first_.size()); }

  /// Adds forces on the particles, and the virial if there is one. x, X and f: 3 doubles per particle.
  /// \param grid  if on: of what is added to f
  /// \return a particle with a force beyond the grid, -1: none
  int forces(const double *x, const double *X, double *f, const SumGrid &grid,
             double *virial) const;
  /// Adds the forces and returns the energy.
  double energy(const double *x, const double *X, double *f) const;
  /// Of one of them, and the power of its forces.
  double energy_of(int tie, const double *x, const double *X, const double *v, double &power) const;

 private:
  struct Place {
    int nodes;
    std::size_t node, matrix;    ///< where they begin
  };
  std::vector<Place> first_;
  std::vector<int> node_;
  std::vector<double> matrix_;    ///< squares

  struct Local;
  void evaluate(const Place &, const double *x, const double *X, Local &) const;
};

}    // namespace defe

#endif
