#ifndef DEFE_FE_KERNEL_H
#define DEFE_FE_KERNEL_H

#include "defe/exact_sum.h"
#include "defe/fe/elastic.h"
#include "defe/fe/principal.h"
#include "defe/fe/topology.h"

#include <memory>

namespace defe::fe {

/// What has flowed in an element: means over its Gauss points.
struct PlasticState {
  double strain = 0.0;         ///< equivalent plastic strain
  double temperature = 0.0;    ///< its rise by plastic work
};

/// How the strain in an element follows from its nodes.
/// - plain: from the trilinear displacements alone. A bent element is too stiff: its edges stay straight, so it
///   shears where it should bend (1.5 times with one cube through the thickness, with elements a times as long as
///   thick 1 + a^2/2 times, Poisson's ratio 0).
/// - enhanced: strains of nine more displacements, alpha_k (1 - xi_k^2), k = 1, 2, 3, take such a value that the
///   energy is least (see src/enhanced.h). Parallelepipeds bend as they should; nothing else changes: uniform
///   strain, mass, the stress at the centre.
enum class ElementType { plain, enhanced };

/// Internal forces of 8-node hexahedra with 2 x 2 x 2 Gauss points.
///
/// Contract for every kernel, whatever its material:
/// - add_forces() adds the exact negative gradient of a stored energy W(x, history), so the sum of
///   an element's forces and the sum of their moments vanish to rounding for any x, and energy is
///   conserved as well as the time integration can. Elastic laws have no history. Where there is
///   one, it changes with time and W with it: the sum of W and of what Output::dissipation was told
///   is then the work that was put in.
/// - W does not change under rigid translation and rotation of x by any angle. A history belongs to
///   the reference configuration and need not be turned.
/// - stress() is the Cauchy stress of the current configuration in global axes.
/// - All functions are const, allocate nothing on the heap (constructors may) and may be called
///   from several threads at once as long as no two of them write to the same node or history.
/// - The result does not depend on how a list of elements is cut into calls, except for the order
///   of the additions to f, virial and dissipation.
/// - An element is lost when its Jacobian dx/dX is not positive (corotational kernels look at the
///   centre, Lagrangian ones at all Gauss points, FBarKernels at both) or not a number. Its forces,
///   energy and bound are then NaN, so that nobody computes on with it unawares, and its index
///   goes to Output::inverted. Its history is of no use afterwards.
class HexKernel {
 public:
  HexKernel() = default;
  HexKernel(const HexKernel &) = delete;
  HexKernel &operator=(const HexKernel &) = delete;
  virtual ~HexKernel();

  /// What add_forces() shall deliver besides forces, and the history; null pointers cost nothing.
  struct Output {
    /// [n] strain energy per element (stored energy W, for laws with history)
    double *energy = nullptr;
    /// [n] stress_bound() of the Cauchy stress at the element's centre, by the weights below
    double *stress_bound = nullptr;
    StressBound bound_weights;
    /// [6] sum over elements of sum_a x_a f_a is ADDED; order xx yy zz xy xz yz. Every element's
    /// forces are in balance, so this does not depend on the origin; it is evaluated relative to
    /// the element's first node for precision.
    double *virial = nullptr;
    /// set to the index (0..n-1) of the first lost element, -1 if there is none
    int *inverted = nullptr;
    /// stress_bound is the largest of the bounds at the eight Gauss points instead of the centre's
    bool bound_at_gauss_points = false;

    /// [n] history of each element, history_size() doubles; needed if that is not 0, else ignored.
    /// Read, and overwritten if dt > 0.
    double *const *history = nullptr;
    /// Time that has passed since the history was advanced the last time. 0: the history stays as
    /// it is; at the positions of the last call with dt > 0 this gives that call's forces and energy
    /// bit for bit, elsewhere the response of the same moment.
    double dt = 0.0;
    /// [1] the energy that the elements dissipated in the time dt is ADDED
    double *dissipation = nullptr;

    /// What is added to each node is a multiple of its quantum: sums over elements are then exact
    /// (exact_sum.h), in any order.
    const SumGrid *grid = nullptr;
    /// set to the index of an element of which a force is beyond the grid, if it was negative
    int *beyond = nullptr;
  };

  /// Doubles of history per element, 0 for elastic laws. A history of zeros is that of an element
  /// that was never strained. The class of the law documents the layout.
  virtual int history_size() const { return 0; }

  /// Adds f_a -= dW/dx_a for n elements.
  /// nodes: local node indices; x, f: current positions and forces, 3 contiguous doubles per node;
  /// X: reference positions, the same layout, may be null if !uses_reference().
  /// A node may occur in any number of elements. f must not overlap x or X.
  /// Throws std::invalid_argument if a law with history gets none, or a dt that is negative or NaN.
  virtual void add_forces(int n, const int (*nodes)[8], const double *x, const double *X, double *f,
                          const Output &out) const = 0;

  /// False if the kernel holds the reference shape itself and never reads X.
  virtual bool uses_reference() const = 0;

  /// Strain energy of one element; X is ignored if !uses_reference(). history: that of the element,
  /// null for an element that was never strained.
  virtual double energy(const HexCoords &x, const HexCoords &X,
                        const double *history = nullptr) const = 0;

  /// Cauchy stress at natural coordinates xi; X and history as above.
  virtual Mat3 stress(const HexCoords &x, const HexCoords &X, const Vec3 &xi,
                      const double *history = nullptr) const = 0;

  /// Zero for laws that know no plastic flow; history as above.
  virtual PlasticState plastic_state(const double * /*history*/) const { return {}; }

  /// Density and elastic constants of the first small and fast deformation: the small-strain limit
  /// of a finite-strain law, the instantaneous moduli of a viscoelastic one.
  virtual const IsotropicElastic &material() const = 0;
};

/// Corotational linear elasticity: W = 1/2 u.K u, K = stiffness() or stiffness_enhanced() (hex8.h), with u_a = R^T (x_a - x_0) - (X_a - X_0), R from
/// the polar decomposition F = R U of the deformation gradient at the element's centre. Forces
/// contain the derivative of R (see src/corotational.h), stress() is R (C : strain) R^T at xi, with the strain sym
/// grad u and that of the enhanced modes.
/// The law is linear in the stretch: it differs from any hyperelastic law with the same constants
/// at second order in strain.
class CorotationalKernel : public HexKernel {
 public:
  bool uses_reference() const override { return false; }
  double energy(const HexCoords &x, const HexCoords &X,
                const double *history = nullptr) const override;
  Mat3 stress(const HexCoords &x, const HexCoords &X, const Vec3 &xi,
              const double *history = nullptr) const override;
  const IsotropicElastic &material() const override { return elastic; }

  /// The shape that all elements of this kernel have in the reference configuration, node 0 at the
  /// origin.
  const HexCoords &reference() const { return shape0; }

 protected:
  CorotationalKernel(const HexCoords &X, const IsotropicElastic &material, ElementType);

  ElementType type;
  IsotropicElastic elastic;
  HexCoords shape0;
  Eigen::Matrix<double, 24, 24> K;
};

/// Congruent boxes (rectangular parallelepipeds) in any common orientation. K is applied after a
/// Walsh-Hadamard transform over the nodes, where the box's three reflections split it into small
/// blocks. The fastest kernel, whatever the type of its elements.
/// Throws std::invalid_argument if X is not a box or the material is not valid.
class BrickKernel : public CorotationalKernel {
 public:
  BrickKernel(const HexCoords &X, const IsotropicElastic &material,
              ElementType = ElementType::enhanced);
  ~BrickKernel() override;
  void add_forces(int n, const int (*nodes)[8], const double *x, const double *X, double *f,
                  const Output &out) const override;

 private:
  struct Data;
  std::unique_ptr<const Data> data;
};

/// Plain hexahedra of any valid shape, each with its own: total Lagrangian St Venant-Kirchhoff,
/// S = lambda tr(E) I + 2 mu E with the Green strain E, Cauchy stress F S F^T / det F.
/// Throws std::invalid_argument if the material is not valid. Reference shapes are not checked in
/// add_forces(): use check_hex() when the mesh is read.
class LagrangianKernel : public HexKernel {
 public:
  explicit LagrangianKernel(const IsotropicElastic &material);
  void add_forces(int n, const int (*nodes)[8], const double *x, const double *X, double *f,
                  const Output &out) const override;
  bool uses_reference() const override { return true; }
  double energy(const HexCoords &x, const HexCoords &X,
                const double *history = nullptr) const override;
  Mat3 stress(const HexCoords &x, const HexCoords &X, const Vec3 &xi,
              const double *history = nullptr) const override;
  const IsotropicElastic &material() const override { return elastic; }

 private:
  IsotropicElastic elastic;
};

/// True if X is a box: edges orthogonal, opposite edges equal, right-handed; node positions within
/// tol times its diagonal.
bool is_box(const HexCoords &X, double tol = 1e-11);

/// True if both are equal up to translation: node positions within tol times the diagonal of A.
bool congruent(const HexCoords &A, const HexCoords &B, double tol = 1e-11);

/// The shape with its lengths rounded, node 0 at the origin: by 4e-13 of its size at the most, or by
/// some last digits of its coordinates if these are more. Elements that differ by rounding get the same bits,
/// but for few, and each gets the same wherever it is asked: a kernel made of it does not depend on which of
/// its elements came first.
HexCoords rounded_shape(const HexCoords &X);

}    // namespace defe::fe

#endif
