#ifndef DEFE_COUPLING_FLAW_GROWTH_H
#define DEFE_COUPLING_FLAW_GROWTH_H

/// \file
/// Flaws that grow before they break: stress corrosion, as of glass in humid air.
///
/// A flaw of depth a under the tension sigma has K = Y sigma sqrt(pi a), and grows with
///
///     da/dt = v_0 (K/K_Ic)^n
///
/// (Charles, J. Appl. Phys. 29 (1958) 1549; Evans, Int. J. Fract. 10 (1974) 251; for glass in buildings Haldimann, thesis 3671,
/// EPF Lausanne (2006)). It breaks when K = K_Ic, so that its strength is S = K_Ic/(Y sqrt(pi a)), K/K_Ic = sigma/S, and
///
///     d(S^(n-2))/dt = -sigma^n / B,    B = 2 K_Ic^2 / ((n - 2) v_0 Y^2 pi)
///
/// What remains of the strength S_i of a fresh flaw is S = (S_i^(n-2) - D/B)^(1/(n-2)), with the history D = integral of sigma^n dt. S
/// says as much as D does, so that a flaw keeps its strength of the moment and nothing else. Under a tension that rises with the
/// constant rate r it breaks at sigma_f with
///
///     sigma_f^(n+1) = (n + 1) B r (S_i^(n-2) - sigma_f^(n-2)),
///
/// which is S_i when the load is fast, and rises with r^(1/(n+1)) when it is slow.

#include <string>
#include <vector>

namespace defe {

struct FlawGrowth {
  double v_0 = 0.0;     ///< speed at K_Ic; 0: flaws do not grow
  double K_Ic = 0.0;    ///< toughness
  double n = 16.0;      ///< > 2
  double Y = 1.12;      ///< of the flaw's shape: a long scratch; 0.637 of a half-penny inside

  bool on() const { return v_0 > 0.0; }
  double B() const;

  /// Strength after `dt` under a tension. A flaw that cannot bear the tension any more breaks now: how far it would have
  /// grown does not matter, and its strength stays above half of the tension.
  double weakened(double strength, double tension, double dt) const;

  /// Share of its strength below which the growth of a flaw is left out: it would lose its strength in 1e12 times the time
  /// that it takes at a tension equal to its strength (0.18 for n = 16).
  double least_share() const;

  /// A tension that rises faster breaks a flaw above 0.99 of its strength: growth hardly matters.
  double inert_rate(double strength) const;

  /// As in an input line; numbers in one way of writing.
  std::string words() const;
};

struct ParsedGrowth {
  FlawGrowth growth;
  std::string complaint;    ///< one line: what is wrong with which value, and what to write instead
  int used = 0;             ///< number of words that belong to it
};

/// words: rate v_0 K_Ic, then perhaps `exponent n` and `geometry Y`; then whatever else follows on the line.
ParsedGrowth parse_growth(const std::vector<std::string> &words);

}    // namespace defe

#endif
