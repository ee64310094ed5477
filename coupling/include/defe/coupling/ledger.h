#ifndef DEFE_COUPLING_LEDGER_H
#define DEFE_COUPLING_LEDGER_H

/// \file
/// The account of energies: running sums of what is dissipated or lost for good, energies stored now, and the
/// list of all entries of fix defe's vector with the part that each has in the total.

#include <array>

namespace defe {

/// Entries of fix defe's vector, from 0; in scripts they are numbered from 1.
namespace entries {
  enum Entry : int {
    ELEMENTS,
    CONVERTED,
    DES,
    CONNECTIVE,
    COHESIVE,
    CONTACT,
    TIES,
    S1_MAX,
    E_ELEMENTS,
    E_JOINTS,
    E_TIES,
    E_COHESIVE,
    E_CONTACT,
    E_KINETIC,
    FRACTURE,
    RELEASE,
    DAMPING,
    FRICTION,
    CONV_STRAIN,
    CONV_KINETIC,
    EXTERNAL,
    TOTAL,
    BALANCE,
    FIRST_CONVERSION,
    FIRST_DAMAGE,
    VISCOUS,
    TIES_SOFTENING,
    TIES_BROKEN,
    LET_THROUGH,
    E_LET_THROUGH,
    COUNT
  };
}    // namespace entries

using Entry = entries::Entry;
using EntryValues = std::array<double, entries::COUNT>;

struct EntryFacts {
  const char *name;      ///< as on the page of fix defe
  const char *column;    ///< as in the files that the examples write
  const char *unit;      ///< "energy", "pressure", "time", or "" for a number
  int in_total;          ///< it is added to the total (1), subtracted (-1) or left out (0)
  bool in_balance;       ///< the balance has it beside the total
  bool cumulative;       ///< of the run so far; it goes on over restarts
  const char *meaning;
};
/// In the order of Entry. The page of fix defe and the examples are checked against it.
extern const std::array<EntryFacts, entries::COUNT> entry_facts;

/// Running sums (J) of one rank. They may become negative on a rank, only their sums over the ranks mean
/// something. Plain data: an array of `size` doubles in files.
struct EnergyLedger {
  double fracture = 0.0;    ///< of joints: G_f times area times damage
  double release = 0.0;     ///< rest of what joints lose
  double damping = 0.0;     ///< restitution
  double friction = 0.0;
  double conv_strain = 0.0;     ///< lost (+) or gained (-) at conversions
  double conv_kinetic = 0.0;    ///< the same
  double external = 0.0;        ///< work of all other forces
  double viscous = 0.0;         ///< of viscoelastic materials and of plastic flow
  double through = 0.0;         ///< of contacts that were let through

  static constexpr int size = 9;
  void pack(double *to) const;
  void unpack(const double *from);

  /// Puts the sums into their entries.
  void fill(EntryValues &) const;
};

/// Energies (J) that joints and contacts of spheres of one rank store at the last evaluation of forces.
struct StoredEnergy {
  double joints = 0.0, ties = 0.0, cohesive = 0.0, contact = 0.0;
};

/// What is stored, moving or dissipated, less the work done from outside: constant but for what conversions lose.
/// Added in the order of the entries, and then what is subtracted, so that its bits are always the same.
double total_of(const EntryValues &);

/// The total and what conversions lose: constant up to the error of the time integration.
double balance_of(const EntryValues &);

}    // namespace defe

#endif
