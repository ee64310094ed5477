/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#include "defe_system.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "fix.h"

#include "defe/coupling/words.h"

#include <cstring>

using namespace LAMMPS_NS;

/* ----------------------------------------------------------------------
   keywords and values that may change; numbers with all their digits
------------------------------------------------------------------------- */

DefeScript::Settings DefeScript::settings() const
{
  Settings s;
  s["contact"] = fmt::format("{}", sys.model.contact_factor);
  s["contact ... friction"] = fmt::format("{}", sys.model.contact_friction);
  s["contact ... overlap"] = sys.model.refuse_overlaps ? "refuse" : "ease";
  s["shield"] = sys.model.shield ? "yes" : "no";
  s["stress"] = sys.model.gauss_stress ? "gauss" : "centre";
  s["kernel"] = sys.model.force_lagrangian ? "lagrangian" : "auto";
  s["every"] = std::to_string(sys.clock.subcycle().every());
  if (sys.model.collect != 1)
    s["collect"] = sys.model.collect ? std::to_string(sys.model.collect) : "auto";
  s["reproducible"] = sys.model.reproducible ? "yes" : "no";
  for (const auto &p : sys.model.parts)
    if (p.convertible) s["convert " + p.name] = p.criterion_words;
  for (const auto &p : sys.model.parts)
    for (const auto &f : p.strength.flaws)
      s["strength " + p.name + (f.surface.empty() ? "" : " surface " + f.surface)] = f.words();
  for (const auto &p : sys.model.parts)
    if (p.strength.growth.on()) s["strength " + p.name + " rate"] = p.strength.growth.words();
  for (const auto &p : sys.model.parts)
    if (p.prestress.given()) s["prestress " + p.name] = p.prestress.words();
  for (const auto &t : sys.model.tied)
    s["tied " + sys.model.parts[t.a].name + " " + sys.model.parts[t.b].name] =
        defe::words_of(t.rule);
  for (const auto &a : sys.model.adhesives)
    s["adhesive " + sys.model.parts[a.part].name + " " + sys.model.parts[a.base].name] =
        fmt::format("{} {} {}", a.law.sigma_t, a.law.G_f, a.law.beta) +
        (a.law.softening ? std::string(" ") + defe::softening_curve(a.law.softening).name() : "");
  return s;
}

/* ---------------------------------------------------------------------- */

std::string DefeScript::pack() const
{
  std::string all;
  auto put = [&all](const void *data, size_t bytes) {
    all.append(static_cast<const char *>(data), bytes);
  };
  auto put_text = [&](const std::string &text) {
    const int n = static_cast<int>(text.size());
    put(&n, sizeof(int));
    all += text;
  };
  const int counts[2] = {static_cast<int>(sys.mesh.de_radii().size()),
                         static_cast<int>(sys.model.parts.size())};
  put(counts, sizeof(counts));
  put(sys.mesh.de_radii().data(), sizeof(double) * sys.mesh.de_radii().size());
  for (const auto &p : sys.model.parts) put(&p.shield_time, sizeof(double));
  std::string texts, set;
  for (const auto &p : sys.model.parts) texts += sys.model.describe(p) + "\n";
  for (const auto &s : settings()) set += s.first + "\n" + s.second + "\n";
  put_text(texts);
  put_text(set);
  put_text(sys.events.written().name);
  return all;
}

std::string DefeScript::unpack(const char *data, size_t bytes)
{
  // its checksum is right; still, nothing is read beyond its end

  auto get = [&](void *to, size_t n) {
    if (n > bytes) error->all(FLERR, "The restart file is damaged: use an older file");
    if (n) memcpy(to, data, n);
    data += n;
    bytes -= n;
  };
  auto get_text = [&] {
    int n = 0;
    get(&n, sizeof(int));
    std::string text(n < 0 || static_cast<size_t>(n) > bytes ? bytes + 1 : n, ' ');
    get(&text[0], text.size());
    return text;
  };
  int counts[2];
  get(counts, sizeof(counts));
  if (counts[0] != static_cast<int>(sys.mesh.de_radii().size()) ||
      counts[1] != static_cast<int>(sys.model.parts.size()))
    error->all(FLERR,
               "Fix defe in the restart file had {} parts and {} atom types, now {} and {}: give "
               "the same fix defe command as before",
               counts[1], counts[0] - 1, sys.model.parts.size(), sys.mesh.de_radii().size() - 1);
  get(sys.mesh.de_radii().data(), sizeof(double) * sys.mesh.de_radii().size());
  for (auto &p : sys.model.parts) get(&p.shield_time, sizeof(double));
  check_parts(get_text());
  const auto lines = utils::split_lines(get_text());
  Settings before;
  for (size_t k = 0; k + 1 < lines.size(); k += 2) before[lines[k]] = lines[k + 1];
  check_strengths(before);
  check_prestress(before);
  check_tied(before);
  note_changes(before);
  return get_text();
}

void DefeScript::check_parts(const std::string &of_file) const
{
  const auto texts = utils::split_lines(of_file);
  for (size_t p = 0; p < sys.model.parts.size(); p++) {
    const std::string before = p < texts.size() ? texts[p] : "";
    if (!defe::same_words(before, sys.model.describe(sys.model.parts[p])))
      error->all(FLERR,
                 "Fix defe part {} was '{}' in the restart file and is '{}' now: give the same "
                 "materials and parts in the same order",
                 p + 1, before, sys.model.describe(sys.model.parts[p]));
  }
}

/* ----------------------------------------------------------------------
   strengths are drawn once, and are in the records of atoms
------------------------------------------------------------------------- */

void DefeScript::check_strengths(const Settings &before) const
{
  const auto lines = [](const Settings &settings) {
    std::string text;
    for (const auto &s : settings)
      if (s.first.rfind("strength ", 0) == 0)
        text += (text.empty() ? "'" : " ") +
            ("strength " + s.first.substr(9, s.first.find(' ', 9) - 9)) + " " + s.second;
    return text.empty() ? std::string("no strength") : text + "'";
  };
  const std::string is = lines(settings()), was = lines(before);
  if (is != was)
    error->all(FLERR,
               "Fix defe had {} in the restart file and has {} now: strengths are drawn once for "
               "all, give them as before",
               was, is);
}

/* ----------------------------------------------------------------------
   so is the stress before any load
------------------------------------------------------------------------- */

void DefeScript::check_prestress(const Settings &before) const
{
  const auto now = settings();
  for (const auto &p : sys.model.parts) {
    const auto of = [&p](const Settings &s) {
      const auto found = s.find("prestress " + p.name);
      return found == s.end() ? "no prestress" : "prestress " + found->second;
    };
    if (of(before) != of(now))
      error->all(FLERR,
                 "Fix defe part {} had {} in the restart file and has {} now: the stress before "
                 "any load is found once, with the mesh, give it as before",
                 p.name, of(before), of(now));
  }
}

/* ----------------------------------------------------------------------
   and so are ties of surfaces
------------------------------------------------------------------------- */

void DefeScript::check_tied(const Settings &before) const
{
  const auto of = [](const Settings &settings) {
    std::string text;
    for (const auto &s : settings)
      if (s.first.rfind("tied ", 0) == 0)
        text += (text.empty() ? "'" : " ") + s.first + " " + s.second;
    return text.empty() ? std::string("no tied surfaces") : text + "'";
  };
  const std::string is = of(settings()), was = of(before);
  if (is != was)
    error->all(FLERR,
               "Fix defe had {} in the restart file and has {} now: surfaces are tied once, with "
               "the mesh, give them as before",
               was, is);
}

void DefeScript::note_changes(const Settings &before) const
{
  if (comm->me) return;
  const auto now = settings();
  auto changed = [this](const std::string &key, const std::string &is, const std::string &was) {
    utils::logmesg(lmp, "Note: fix {} defe has {} {}, and had {} in the restart file\n",
                   sys.host->id, key, is, was);
  };
  for (const auto &s : now) {
    const auto old = before.find(s.first);
    if (old == before.end())
      changed(s.first, s.second, "none");
    else if (old->second != s.second)
      changed(s.first, s.second, old->second);
  }
  for (const auto &s : before)
    if (!now.count(s.first)) changed("no", s.first, s.second);
}
