/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.

   What a run with fix defe asks to be cited (log file, -cite file): the papers that the method comes from.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_CITATION_H
#define LMP_DEFE_CITATION_H

namespace LAMMPS_NS {

// as on the page of fix defe: the copy that DEFE was written from names neither authors nor journal of the first

inline const char cite_defe[] =
    "fix defe: finite elements that become bonded spheres\n\n"
    "@Misc{AdaptiveDEFE,\n"
    " title = {Adaptive combined {DE/FE} algorithm for analyzing impact fracture problem}\n"
    "}\n\n"
    "@Article{Lei2010,\n"
    " author = {Lei, Z. and Zang, M. Y.},\n"
    " title = {An approach to combining {3D} discrete and finite element methods based on penalty "
    "function method},\n"
    " journal = {Computational Mechanics},\n"
    " volume = {46},\n"
    " number = {4},\n"
    " pages = {609--619},\n"
    " year = {2010}\n"
    "}\n\n"
    "@Article{Gao2014,\n"
    " author = {Gao, Wei and Zang, Mengyan},\n"
    " title = {The simulation of laminated glass beam impact problem by developing fracture model "
    "of spherical {DEM}},\n"
    " journal = {Engineering Analysis with Boundary Elements},\n"
    " volume = {42},\n"
    " pages = {2--7},\n"
    " year = {2014}\n"
    "}\n\n";

}    // namespace LAMMPS_NS

#endif
