// The clock of the finite elements.

#include "defe/coupling/subcycle.h"

#include <gtest/gtest.h>

#include <vector>

using namespace defe;

TEST(Subcycle, OneClockIsDueAlways)
{
  Subcycle clock;
  for (int step = 0; step < 5; step++) {
    EXPECT_TRUE(clock.due());
    EXPECT_EQ(clock.velocity_lead(0.1), 0.0);
    clock.advance(0.1);
  }
  EXPECT_EQ(clock.steps_of_impulse(), 1);    // elements that are marked convert in the next step
}

TEST(Subcycle, DueAtEveryMthStep)
{
  for (int m : {2, 3, 5}) {
    Subcycle clock;
    clock.set_every(m);
    for (int step = 0; step < 4 * m; step++) {
      EXPECT_EQ(clock.due(), step % m == 0) << m;
      EXPECT_EQ(clock.phase(), step % m) << m;
      clock.advance(0.1);
    }
  }
}

TEST(Subcycle, TimeOfHistories)
{
  Subcycle clock;
  clock.set_every(3);
  for (int step = 0; step < 3; step++) clock.advance(step < 2 ? 0.5 : 0.25);
  EXPECT_EQ(clock.since_history(), 1.25);    // the step may change
  clock.history_advanced();
  EXPECT_EQ(clock.since_history(), 0.0);
}

// A constant acceleration in impulses, by the half kicks of velocity Verlet: less its lead, the velocity is that of
// all steps.
TEST(Subcycle, VelocityWithoutItsLeadIsSmooth)
{
  const double a = 3.0, dt = 0.125;
  for (int m : {1, 2, 3, 4, 5}) {
    Subcycle clock;
    clock.set_every(m);
    double v = 0.0;
    for (int step = 1; step <= 4 * m; step++) {
      if (clock.due()) v += 0.5 * m * a * dt;
      clock.advance(dt);
      if (clock.due()) v += 0.5 * m * a * dt;
      EXPECT_NEAR(v - a * clock.velocity_lead(dt), a * step * dt, 1e-12) << m << " " << step;
    }
  }
}

// What an impulse stands for has passed before its elements convert, and the next one has not begun.
TEST(Subcycle, ConversionsWaitForTheImpulse)
{
  for (int m = 1; m <= 8; m++) {
    Subcycle clock;
    clock.set_every(m);
    const int wait = clock.steps_of_impulse();
    EXPECT_GE(2 * wait, m);
    EXPECT_LE(wait, m);
    for (int step = 1; step < wait; step++) {
      clock.advance(1.0);
      EXPECT_FALSE(clock.due());
    }
  }
}

TEST(Subcycle, RestartsKeepThePhase)
{
  Subcycle clock;
  clock.set_every(3);
  clock.advance(0.5);
  Subcycle same, other;
  same.set_every(3);
  EXPECT_TRUE(same.go_on(clock.state()));
  EXPECT_EQ(same.phase(), 1);
  EXPECT_EQ(same.since_history(), 0.5);
  other.set_every(2);
  EXPECT_FALSE(other.go_on(clock.state()));
  clock.advance(0.5);
  clock.advance(0.5);
  EXPECT_TRUE(other.go_on(clock.state()));    // where both meet
  EXPECT_EQ(other.every(), 2);
}
