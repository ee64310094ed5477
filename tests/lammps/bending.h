#ifndef DEFE_TEST_BENDING_H
#define DEFE_TEST_BENDING_H

// A beam along x on two supports, struck at mid-span by a rigid block of 1 kg: the set-up of the
// paper's benchmark, for beams of other lengths, heights and layers.

#include "lammps_run.h"

#include <string>

namespace defe::test {

struct Bending {
  std::string box;                  // region box, 6 numbers
  std::string glass;                // fix defe: materials and parts of the beam
  std::string options;              // fix defe: more keywords
  std::string elements;             // fix defe: their type in the supports, if not the default
  std::string mesh;                 // commands that make the beam, from y = 0 upwards
  std::string outer, inner;         // |x| at which the supports end and begin
  std::string law;                  // "lattice": of joints by their own tractions
  std::string height, block_top;    // y of the top of the beam, and of the block on it
  double dt = 6e-8;

  std::string script() const
  {
    return script_head() + R"(
    region          box block )" +
        box + R"(
    create_box      5 box
    pair_style      defe/joint
    pair_coeff      4 4 connective 74.09e9 0.2 cohesive 60e6 10.0 0.1 )" +
        law + R"( contact 0.9 0.2
    group           particles empty
    fix             fe all defe )" +
        glass + R"( &
                                material supports elastic 5e9 0.4 2400 )" +
        elements + R"( material impactor rigid 6.25e6 &
                                )" +
        options + "\n" + mesh + "\ncreate_hexes fe supports 2 x -" + outer + " 5 -" + inner +
        " y -0.004 2 0 z 0 5 0.010\ncreate_hexes fe supports 2 x " + inner + " 5 " + outer +
        " y -0.004 2 0 z 0 5 0.010\ncreate_hexes fe impactor 3 x -0.002 2 0.002 y " + height +
        " 2 " + block_top + R"( z 0 5 0.010
    group           nodes    type 1 2
    group           impactor type 3
    region          floor block INF INF INF -0.0039 INF INF
    group           floor region floor
    velocity        impactor set 0 -3.13 0
    timestep        )" +
        number(dt) + R"(
    neighbor        0.0002 bin
    neigh_modify    every 1 delay 0 check yes binsize 0.002
    fix             move1 nodes nve
    fix             move2 particles nve/sphere
    fix             ram   impactor rigid/nve single
    fix             fixed floor setforce 0 0 0
  )";
  }
};

}    // namespace defe::test

#endif
