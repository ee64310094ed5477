/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_options.h"

#include "defe_system.h"

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "group.h"

#include <algorithm>
#include <cstring>

using namespace LAMMPS_NS;

static constexpr size_t MAX_PARTS = 127;    // a signed char in the records

DefeOptions::DefeOptions(DefeSystem &system, int n, char **words) :
    DefeComponent(system), narg(n), arg(words)
{
}

/* ---------------------------------------------------------------------- */

void DefeOptions::read()
{
  auto &m = sys.model;
  while (iarg < narg) {
    const std::string key = arg[iarg];
    if (key == "material")
      read_material();
    else if (key == "part")
      read_part();
    else if (key == "convert")
      read_convert();
    else if (key == "strength")
      read_strength();
    else if (key == "prestress")
      read_prestress();
    else if (key == "adhesive")
      read_adhesive();
    else if (key == "tied")
      read_tied();
    else if (key == "contact")
      read_contact();
    else if (key == "shield")
      m.shield = yes("shield");
    else if (key == "stress")
      m.gauss_stress = second_of("stress", "centre", "gauss");
    else if (key == "kernel")
      m.force_lagrangian = second_of("kernel", "auto", "lagrangian");
    else if (key == "every")
      read_every();
    else if (key == "collect")
      read_collect();
    else if (key == "inplace")
      m.in_place = yes("inplace");
    else if (key == "check")
      read_check();
    else if (key == "reproducible")
      m.reproducible = yes("reproducible");
    else if (key == "events") {
      need(2, "events");
      sys.events.set_file(arg[iarg + 1]);
      iarg += 2;
    } else
      error->all(FLERR,
                 "Unknown fix defe keyword {}: use material, part, convert, strength, prestress, "
                 "adhesive, tied, contact, shield, stress, kernel, every, collect, inplace, check, "
                 "reproducible or events",
                 key);
  }
  finish();
}

void DefeOptions::need(int n, const char *what)
{
  if (iarg + n > narg) utils::missing_cmd_args(FLERR, std::string("fix defe ") + what, error);
}

bool DefeOptions::yes(const char *what)
{
  need(2, what);
  const bool value = utils::logical(FLERR, arg[iarg + 1], false, lmp);
  iarg += 2;
  return value;
}

bool DefeOptions::second_of(const char *what, const char *first, const char *second)
{
  need(2, what);
  const bool is_second = strcmp(arg[iarg + 1], second) == 0;
  if (!is_second && strcmp(arg[iarg + 1], first) != 0)
    error->all(FLERR, "Fix defe {} must be {} or {}, not {}", what, first, second, arg[iarg + 1]);
  iarg += 2;
  return is_second;
}

/* ----------------------------------------------------------------------
   materials and parts
------------------------------------------------------------------------- */

int DefeOptions::material_index(const std::string &name) const
{
  const auto &materials = sys.model.materials;
  for (size_t i = 0; i < materials.size(); i++)
    if (materials[i].name == name) return static_cast<int>(i);
  return -1;
}

void DefeOptions::add_part(const std::string &name, int material)
{
  DefePart p;
  p.name = name;
  p.material = material;
  if (sys.model.parts.size() == MAX_PARTS)
    error->all(FLERR, "Fix defe can hold no more than {} parts", MAX_PARTS);
  sys.model.parts.push_back(p);
}

void DefeOptions::read_material()
{
  need(3, "material");
  DefeMaterial m;
  m.name = arg[iarg + 1];
  check_name("material", m.name);
  if (material_index(m.name) >= 0)
    error->all(FLERR, "Fix defe material {} is defined twice", m.name);
  const auto parsed =
      defe::fe::parse_material(std::vector<std::string>(arg + iarg + 2, arg + narg));
  if (!parsed.complaint.empty())
    error->all(FLERR, "Fix defe material {}: {}", m.name, parsed.complaint);
  m.law = parsed.law;
  m.words = parsed.description;
  iarg += 2 + parsed.used;
  sys.model.materials.push_back(m);
  add_part(m.name, static_cast<int>(sys.model.materials.size()) - 1);
}

void DefeOptions::read_part()
{
  need(3, "part");
  const int m = material_index(arg[iarg + 2]);
  if (m < 0)
    error->all(FLERR, "Fix defe part {}: unknown material {}", arg[iarg + 1], arg[iarg + 2]);
  if (sys.model.find_part(arg[iarg + 1]) >= 0)
    error->all(FLERR, "Fix defe part {} is defined twice", arg[iarg + 1]);
  check_name("part", arg[iarg + 1]);
  add_part(arg[iarg + 1], m);
  iarg += 3;
}

/* ----------------------------------------------------------------------
   conversion
------------------------------------------------------------------------- */

void DefeOptions::read_convert()
{
  need(3, "convert");
  const int ip = sys.model.find_part(arg[iarg + 1]);
  if (ip < 0) error->all(FLERR, "Fix defe convert: unknown part {}", arg[iarg + 1]);
  DefePart &p = sys.model.parts[ip];
  const auto &m = sys.model.material_of(p);
  if (m.rigid()) error->all(FLERR, "Fix defe convert: part {} is rigid and cannot convert", p.name);
  if (!m.law->linear())
    error->all(FLERR,
               "Fix defe convert: part {} cannot convert: DEs have the law elastic, its material "
               "{} has another one",
               p.name, m.name);
  p.convertible = true;
  p.group = group->find("all");
  iarg += 2;
  read_criterion(p);
  read_des(p);
  if (p.type == 0)
    error->all(FLERR, "Fix defe convert {}: give the atom type of its DEs: type N", p.name);
}

void DefeOptions::read_criterion(DefePart &p)
{
  const auto parsed = defe::parse_criterion(std::vector<std::string>(arg + iarg, arg + narg),
                                            sys.model.material_of(p).elastic());
  if (!parsed.complaint.empty())
    error->all(FLERR, "Fix defe convert {}: {}", p.name, parsed.complaint);
  p.criterion = parsed.criterion;
  p.stress = p.criterion->tensile_stress();
  p.criterion_words = parsed.entry == defe::conversion_criteria().front() ? "" : parsed.entry->name;
  for (double number : p.criterion->numbers())
    p.criterion_words += fmt::format("{}{}", p.criterion_words.empty() ? "" : " ", number);
  iarg += parsed.used;
}

void DefeOptions::read_des(DefePart &p)
{
  while (iarg < narg) {
    const std::string opt = arg[iarg];
    if (opt == "type") {
      need(2, "convert ... type");
      p.type = utils::inumeric(FLERR, arg[iarg + 1], false, lmp);
      if (p.type < 1 || p.type > atom->ntypes)
        error->all(FLERR, "Fix defe convert {}: atom type {} does not exist (1 to {})", p.name,
                   p.type, atom->ntypes);
    } else if (opt == "group") {
      need(2, "convert ... group");
      p.group = group->find(arg[iarg + 1]);
      if (p.group < 0)
        error->all(FLERR,
                   "Fix defe convert {}: group {} does not exist; define it first, for "
                   "instance 'group {} empty'",
                   p.name, arg[iarg + 1], arg[iarg + 1]);
    } else if (opt == "split") {
      need(2, "convert ... split");
      const int along = utils::inumeric(FLERR, arg[iarg + 1], false, lmp);
      if (along < 1 || along > defe::ElementSplit::most)
        error->all(FLERR,
                   "Fix defe convert {}: split must be 1, 2 or 3 (an element becomes 1, 8 or 27 "
                   "DEs), not {}",
                   p.name, along);
      p.split = defe::ElementSplit(along);
    } else if (opt == "start") {
      need(2, "convert ... start");
      p.start = arg[iarg + 1];
      if (p.start == "no") p.start.clear();
      if (!p.start.empty() && p.start != "all" && !domain->get_region_by_id(p.start))
        error->all(FLERR, "Fix defe convert {}: start must be no, all or a region, not {}", p.name,
                   p.start);
    } else
      break;
    iarg += 2;
  }
}

/* ----------------------------------------------------------------------
   flaws of a part's surface or inside
------------------------------------------------------------------------- */

void DefeOptions::read_strength()
{
  need(3, "strength");
  const int ip = sys.model.find_part(arg[iarg + 1]);
  if (ip < 0)
    error->all(FLERR, "Fix defe strength: unknown part {}: define it before", arg[iarg + 1]);
  DefePart &p = sys.model.parts[ip];
  const std::vector<std::string> words(arg + iarg + 2, arg + narg);
  if (words[0] == "rate") {
    const auto growth = defe::parse_growth(words);
    if (!growth.complaint.empty())
      error->all(FLERR, "Fix defe strength {} rate: {}", p.name, growth.complaint);
    if (p.strength.growth.on())
      error->all(FLERR, "Fix defe strength {}: rate is given twice", p.name);
    p.strength.growth = growth.growth;
    iarg += 2 + growth.used;
    return;
  }
  const auto parsed = defe::parse_flaws(words);
  if (!parsed.complaint.empty())
    error->all(FLERR, "Fix defe strength {}: {}", p.name, parsed.complaint);
  const std::string &surface = parsed.flaws.surface;
  for (const auto &f : p.strength.flaws)
    if (f.surface == surface)
      error->all(FLERR, "Fix defe strength {}: {} is given twice", p.name,
                 surface.empty() ? "the inside" : "surface " + surface);
  p.strength.flaws.push_back(parsed.flaws);
  iarg += 2 + parsed.used;
}

/* ----------------------------------------------------------------------
   stress before any load
------------------------------------------------------------------------- */

void DefeOptions::read_prestress()
{
  need(3, "prestress");
  const int ip = sys.model.find_part(arg[iarg + 1]);
  if (ip < 0)
    error->all(FLERR, "Fix defe prestress: unknown part {}: define it before", arg[iarg + 1]);
  DefePart &p = sys.model.parts[ip];
  if (p.prestress.given()) error->all(FLERR, "Fix defe prestress {} is given twice", p.name);
  const auto parsed = defe::parse_prestress(std::vector<std::string>(arg + iarg + 2, arg + narg));
  if (!parsed.complaint.empty())
    error->all(FLERR, "Fix defe prestress {}: {}", p.name, parsed.complaint);
  p.prestress = parsed.rule;
  iarg += 2 + parsed.used;
}

void DefeOptions::read_adhesive()
{
  need(6, "adhesive");
  defe::Adhesive a;
  int *const which[2] = {&a.part, &a.base};
  for (int k = 0; k < 2; k++) {
    *which[k] = sys.model.find_part(arg[iarg + 1 + k]);
    if (*which[k] < 0)
      error->all(FLERR, "Fix defe adhesive: unknown part {}: define it before", arg[iarg + 1 + k]);
  }
  a.law.sigma_t = utils::numeric(FLERR, arg[iarg + 3], false, lmp);
  a.law.G_f = utils::numeric(FLERR, arg[iarg + 4], false, lmp);
  a.law.beta = utils::numeric(FLERR, arg[iarg + 5], false, lmp);
  a.law.reciprocal = false;
  if (!(a.law.sigma_t > 0.0) || !(a.law.G_f > 0.0) || !(a.law.beta >= 0.0))
    error->all(FLERR,
               "Fix defe adhesive {} {}: strength and fracture energy must be > 0 and beta >= "
               "0, not {} {} {}",
               arg[iarg + 1], arg[iarg + 2], a.law.sigma_t, a.law.G_f, a.law.beta);
  if (sys.model.adhesive_of(a.part, a.base))
    error->all(FLERR, "Fix defe adhesive {} {} is given twice", arg[iarg + 1], arg[iarg + 2]);
  iarg += 6;
  if (const int curve = iarg < narg ? defe::find_softening_curve(arg[iarg]) : -1; curve >= 0) {
    a.law.softening = static_cast<unsigned char>(curve);
    iarg++;
  }
  sys.model.adhesives.push_back(a);
}

/* ----------------------------------------------------------------------
   surfaces that are glued
------------------------------------------------------------------------- */

void DefeOptions::read_tied()
{
  need(3, "tied");
  DefeTiedPair pair;
  int *const which[2] = {&pair.a, &pair.b};
  for (int k = 0; k < 2; k++) {
    *which[k] = sys.model.find_part(arg[iarg + 1 + k]);
    if (*which[k] < 0)
      error->all(FLERR, "Fix defe tied: unknown part {}: define it before", arg[iarg + 1 + k]);
  }
  const std::string names = std::string(arg[iarg + 1]) + " " + arg[iarg + 2];
  const auto &parts = sys.model.parts;
  if (pair.a == pair.b)
    error->all(FLERR,
               "Fix defe tied {}: a part cannot be tied to itself: make its bodies two parts, with "
               "'part NAME {}'",
               names, sys.model.material_of(parts[pair.a]).name);
  if (sys.model.material_of(parts[pair.a]).rigid() && sys.model.material_of(parts[pair.b]).rigid())
    error->all(FLERR,
               "Fix defe tied {}: both parts are rigid: move them as one body, with one fix rigid",
               names);
  if (sys.model.are_tied(pair.a, pair.b))
    error->all(FLERR, "Fix defe tied {} is given twice", names);
  const auto parsed = defe::parse_tie(std::vector<std::string>(arg + iarg + 3, arg + narg));
  if (!parsed.complaint.empty()) error->all(FLERR, "Fix defe tied {}: {}", names, parsed.complaint);
  pair.rule = parsed.rule;
  iarg += 3 + parsed.used;
  sys.model.tied.push_back(pair);
}

/* ----------------------------------------------------------------------
   contact of surfaces
------------------------------------------------------------------------- */

void DefeOptions::read_contact()
{
  auto &m = sys.model;
  need(2, "contact");
  m.contact_given = true;
  m.contact_factor = utils::numeric(FLERR, arg[iarg + 1], false, lmp);
  if (!(m.contact_factor >= 0.0))
    error->all(FLERR, "Fix defe contact factor must be >= 0, not {}", arg[iarg + 1]);
  iarg += 2;
  if (iarg < narg && strcmp(arg[iarg], "friction") == 0) {
    need(2, "contact f_s friction");
    m.contact_friction = utils::numeric(FLERR, arg[iarg + 1], false, lmp);
    if (!(m.contact_friction >= 0.0))
      error->all(FLERR, "Fix defe friction must be >= 0, not {}", arg[iarg + 1]);
    iarg += 2;
  }
  if (iarg < narg && strcmp(arg[iarg], "overlap") == 0) {
    need(2, "contact f_s overlap");
    m.refuse_overlaps = strcmp(arg[iarg + 1], "refuse") == 0;
    m.ease_overlaps = strcmp(arg[iarg + 1], "ease") == 0;
    if (!m.refuse_overlaps && !m.ease_overlaps)
      error->all(FLERR, "Fix defe contact overlap is ease or refuse, not {}", arg[iarg + 1]);
    iarg += 2;
  }
}

void DefeOptions::read_every()
{
  need(2, "every");
  const int every = utils::inumeric(FLERR, arg[iarg + 1], false, lmp);
  if (every < 1) error->all(FLERR, "Fix defe every must be at least 1 step, not {}", every);
  sys.clock.subcycle().set_every(every);
  iarg += 2;
}

void DefeOptions::read_collect()
{
  need(2, "collect");
  const std::string steps = arg[iarg + 1];
  sys.model.collect = steps == "auto" ? 0 : utils::inumeric(FLERR, steps, false, lmp);
  if (steps != "auto" && sys.model.collect < 1)
    error->all(FLERR, "Fix defe collect must be auto or at least 1 step, not {}",
               sys.model.collect);
  iarg += 2;
}

void DefeOptions::read_check()
{
  need(2, "check");
  if (strcmp(arg[iarg + 1], "energy") != 0) {
    sys.model.checking = yes("check");
    return;
  }
  need(3, "check energy");
  const std::string how = arg[iarg + 2];
  if (how != "no" && how != "warn" && how != "stop")
    error->all(FLERR, "Fix defe check energy is no, warn or stop, not {}", how);
  sys.model.energy_check = how == "no" ? DefeModel::ENERGY_NO
      : how == "warn"                  ? DefeModel::ENERGY_WARN
                                       : DefeModel::ENERGY_STOP;
  iarg += 3;
}

/* ----------------------------------------------------------------------
   what can be said when all is known
------------------------------------------------------------------------- */

void DefeOptions::finish()
{
  if (sys.model.materials.empty()) error->all(FLERR, "Fix defe needs at least one material");
  check_numbers_as_names();
  check_adhesives();
  check_strengths();
  check_prestress();
  sys.strengths.begin();
  sys.prestress.begin();
  sys.tied.begin();
  sys.tied_des.begin();
  for (const auto &p : sys.model.parts) {
    const auto &m = sys.model.material_of(p);
    sys.model.corner_moduli.push_back(
        m.rigid() ? defe::CornerModuli{0.0, 0.0}
                  : defe::CornerModuli{m.elastic().lambda(), m.elastic().mu()});
  }
}

/* ----------------------------------------------------------------------
   names of parts and materials must be such that a data file can hold them
------------------------------------------------------------------------- */

void DefeOptions::check_name(const char *what, const std::string &name) const
{
  if (name.empty() || name.find_first_of(" \t\r\n\f\v#") != std::string::npos)
    error->all(
        FLERR,
        "Fix defe {} '{}': names must not be empty nor have blanks or #, data files could not "
        "hold them",
        what, name);
}

void DefeOptions::check_numbers_as_names() const
{
  const auto &parts = sys.model.parts;
  for (size_t k = 0; k < parts.size(); k++)
    for (size_t other = 0; other < parts.size(); other++)
      if (other != k && parts[k].name == std::to_string(other + 1))
        error->all(
            FLERR,
            "Fix defe: part {} has the name {}, which in data files is also the number of part "
            "{}: give it another name",
            k + 1, parts[k].name, parts[other].name);
}

void DefeOptions::check_adhesives() const
{
  const auto &parts = sys.model.parts;
  for (const auto &a : sys.model.adhesives) {
    if (!parts[a.part].convertible)
      error->all(FLERR,
                 "Fix defe adhesive {0} {1}: elements of part {0} do not convert, so it has no "
                 "ties: name the part that converts first",
                 parts[a.part].name, parts[a.base].name);
    if (parts[a.base].convertible)
      error->all(FLERR,
                 "Fix defe adhesive {0} {1}: part {1} converts: the joints between two parts that "
                 "convert have their strength by pair_coeff cohesive",
                 parts[a.part].name, parts[a.base].name);
  }
}

void DefeOptions::check_prestress() const
{
  for (const auto &p : sys.model.parts)
    if (p.prestress.given() && !sys.model.material_of(p).law->linear())
      error->all(FLERR,
                 "Fix defe prestress {}: only parts of the law elastic can have a stress before "
                 "any load, its material is '{}'",
                 p.name, sys.model.material_of(p).words);
}

/* ----------------------------------------------------------------------
   what has flaws breaks everywhere: below a surface, too
------------------------------------------------------------------------- */

void DefeOptions::check_strengths() const
{
  for (const auto &p : sys.model.parts) {
    if (p.strength.growth.on() && !p.strength.given())
      error->all(FLERR,
                 "Fix defe strength {}: rate says how flaws grow, but there are none: give their "
                 "strength, too, for instance 'strength {} constant' with that of fast loads",
                 p.name, p.name);
    if (!p.strength.given()) continue;
    if (p.strength.growth.on() && p.convertible && !utils::is_double(p.criterion_words))
      error->all(FLERR,
                 "Fix defe strength {} rate: flaws grow with the largest principal stress, but "
                 "elements convert by '{}': convert by a stress, or leave out rate",
                 p.name, p.criterion_words);
    if (!p.convertible)
      error->all(FLERR,
                 "Fix defe strength {}: its elements do not convert, so nothing in it breaks: give "
                 "'convert {} ...' too, or leave it out",
                 p.name, p.name);
    const bool inside =
        std::any_of(p.strength.flaws.begin(), p.strength.flaws.end(), [](const defe::Flaws &f) {
          return f.surface.empty();
        });
    if (!inside)
      error->all(FLERR,
                 "Fix defe strength {}: only surfaces have a strength: give that of the inside, "
                 "too, for instance 'strength {} constant' with some times that of the surface",
                 p.name, p.name);
  }
}
