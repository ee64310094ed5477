#include "defe/coupling/ledger.h"

namespace defe {

const std::array<EntryFacts, entries::COUNT> entry_facts = {{
    {"elements", "elements", "", 0, false, false,
     "finite elements there are now, those of rigid parts included"},
    {"converted", "converted", "", 0, false, true,
     "elements converted so far, at the start or by the criterion"},
    {"DEs", "des", "", 0, false, false, "DEs there are now"},
    {"connective", "connective", "", 0, false, false, "joints between two DEs that are intact"},
    {"cohesive", "cohesive", "", 0, false, false, "joints that are softening"},
    {"contact", "contact", "", 0, false, false,
     "joints that are broken, whether the DEs touch or not"},
    {"ties", "ties", "", 0, false, false,
     "joints between a DE and the face of a finite element that hold"},
    {"s1max", "s1max", "pressure", 0, false, false,
     "largest principal stress at the center of any element that can convert"},
    {"E elements", "e_elements", "energy", 1, false, false,
     "strain energy of the finite elements and of tied surfaces"},
    {"E joints", "e_joints", "energy", 1, false, false,
     "strain energy of the DEs, share of the joints"},
    {"E ties", "e_ties", "energy", 1, false, false, "the same, share of the ties (by number)"},
    {"E cohesive", "e_cohesive", "energy", 1, false, false, "energy stored in softening joints"},
    {"E contact", "e_contact", "energy", 1, false, false,
     "energy of all contacts, tangential springs included"},
    {"E kinetic", "e_kinetic", "energy", 1, false, false,
     "kinetic energy of nodes, DEs, and (with *contact*) balls in the group of this fix, spin "
     "included"},
    {"fracture", "fracture", "energy", 1, false, true,
     "dissipated by softening joints, as far as it is fracture energy"},
    {"released", "released", "energy", 1, false, true, "what joints lose beyond that"},
    {"damping", "damping", "energy", 1, false, true, "lost by restitution in contacts of spheres"},
    {"friction", "friction", "energy", 1, false, true,
     "lost by friction in contacts of spheres, surfaces and walls"},
    {"conversion, strain", "conv_strain", "energy", 0, true, true,
     "strain energy, and energy of contacts with surfaces, balls and walls, lost (gained, if "
     "negative) at conversions"},
    {"conversion, kinetic", "conv_kinetic", "energy", 0, true, true,
     "kinetic energy lost at conversions"},
    {"external", "external", "energy", -1, false, true,
     "work done on the system by forces that other fixes set after this one, and by overlaps from "
     "before the first step that are eased out"},
    {"total", "total", "energy", 0, false, false,
     "sum of entries 9 to 18, 26 and 30 less entry 21"},
    {"balance", "balance", "energy", 0, false, false, "entry 22 plus entries 19 and 20"},
    {"t conversion", "t_conversion", "time", 0, false, false,
     "time of the first conversion, -1 if there was none"},
    {"t damage", "t_damage", "time", 0, false, false,
     "time when the first joint became cohesive, -1 if none did"},
    {"viscous", "viscous", "energy", 1, false, true,
     "dissipated by viscoelastic materials and by plastic flow"},
    {"ties softening", "softening_ties", "", 0, false, false, "ties that soften"},
    {"ties broken", "broken_ties", "", 0, false, false,
     "ties that are broken, whether DE and face touch or not"},
    {"let through", "let_through", "", 0, false, true,
     "contacts with a face that ended because they got too deep"},
    {"E let through", "e_let_through", "energy", 1, false, true,
     "energy of these contacts when they ended, less what they got again"},
}};

void EnergyLedger::pack(double *to) const
{
  const double all[size] = {fracture,     release,  damping, friction, conv_strain,
                            conv_kinetic, external, viscous, through};
  for (int k = 0; k < size; k++) to[k] = all[k];
}

void EnergyLedger::unpack(const double *from)
{
  double *const all[size] = {&fracture,     &release,  &damping, &friction, &conv_strain,
                             &conv_kinetic, &external, &viscous, &through};
  for (int k = 0; k < size; k++) *all[k] = from[k];
}

void EnergyLedger::fill(EntryValues &values) const
{
  values[entries::FRACTURE] = fracture;
  values[entries::RELEASE] = release;
  values[entries::DAMPING] = damping;
  values[entries::FRICTION] = friction;
  values[entries::CONV_STRAIN] = conv_strain;
  values[entries::CONV_KINETIC] = conv_kinetic;
  values[entries::EXTERNAL] = external;
  values[entries::VISCOUS] = viscous;
  values[entries::E_LET_THROUGH] = through;
}

double total_of(const EntryValues &values)
{
  double sum = 0.0;
  for (int k = 0; k < entries::COUNT; k++)
    if (entry_facts[k].in_total > 0) sum += values[k];
  for (int k = 0; k < entries::COUNT; k++)
    if (entry_facts[k].in_total < 0) sum -= values[k];
  return sum;
}

double balance_of(const EntryValues &values)
{
  double sum = total_of(values);
  for (int k = 0; k < entries::COUNT; k++)
    if (entry_facts[k].in_balance) sum += values[k];
  return sum;
}

}    // namespace defe
