#ifndef DEFE_COUPLING_SUBCYCLE_H
#define DEFE_COUPLING_SUBCYCLE_H

/// \file
/// Two clocks: the elements' forces act at every m-th step only, and then m-fold, as impulses (Grubmueller et al.
/// 1991; Tuckerman, Berne and Martyna, J. Chem. Phys. 97 (1992) 1990). The two half kicks of velocity Verlet
/// around that step make the method symmetric: the impulse stands for the m steps around it.

namespace defe {

class Subcycle {
 public:
  /// What restart files keep.
  struct State {
    int every = 1, phase = 0;
    double since_history = 0.0;
  };

  void set_every(int m) { state_.every = m; }
  int every() const { return state_.every; }
  /// Steps since the last evaluation of the elements, 0 = it is in this step.
  int phase() const { return state_.phase; }
  bool due() const { return state_.phase == 0; }

  /// Time since the histories of materials were advanced.
  double since_history() const { return state_.since_history; }
  void history_advanced() { state_.since_history = 0.0; }

  /// A step begins.
  void advance(double dt)
  {
    state_.phase = (state_.phase + 1) % state_.every;
    state_.since_history += dt;
  }

  /// Steps from an evaluation to the end of those that its impulse stands for: until then its elements stay.
  int steps_of_impulse() const { return (state_.every + 1) / 2; }

  /// Time by which the velocities of nodes are ahead of their positions: they have got the impulse of the m/2 steps
  /// after the last evaluation at once, and `phase` of these have passed.
  double velocity_lead(double dt) const
  {
    return state_.phase == 0 ? 0.0 : (0.5 * state_.every - state_.phase) * dt;
  }

  const State &state() const { return state_; }
  /// Between two evaluations m cannot be changed: false, and nothing is taken over.
  bool go_on(const State &then)
  {
    if (then.phase != 0 && then.every != state_.every) return false;
    state_.phase = then.phase;
    state_.since_history = then.since_history;
    return true;
  }

 private:
  State state_;
};

}    // namespace defe

#endif
