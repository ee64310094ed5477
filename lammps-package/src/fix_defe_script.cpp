/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

// What the script said, in restart files: materials and parts must be the same when a run goes on; of other
// settings, what has changed is said.

#include "fix_defe.h"

#include "atom.h"
#include "comm.h"
#include "error.h"

#include "defe/coupling/words.h"

#include <cstring>

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

std::string FixDefe::describe_part(const Part &p) const
{
  return p.name + ": " + material_of(p).words +
      (p.convertible ? ", DEs of type " + std::to_string(p.type) : "");
}

/* ----------------------------------------------------------------------
   keywords and values that may change; numbers with all their digits
------------------------------------------------------------------------- */

std::map<std::string, std::string> FixDefe::settings() const
{
  std::map<std::string, std::string> s;
  s["contact"] = fmt::format("{}", contact_factor);
  s["contact ... friction"] = fmt::format("{}", contact_friction);
  s["contact ... overlap"] = refuse_overlaps ? "refuse" : "ease";
  s["shield"] = shield ? "yes" : "no";
  s["stress"] = gauss_stress ? "gauss" : "centre";
  s["kernel"] = force_lagrangian ? "lagrangian" : "auto";
  s["every"] = std::to_string(subcycle.every());
  s["reproducible"] = reproducible ? "yes" : "no";
  for (const auto &p : parts)
    if (p.convertible) s["convert " + p.name] = p.criterion_words;
  for (const auto &a : adhesives)
    s["adhesive " + parts[a.part].name + " " + parts[a.base].name] =
        fmt::format("{} {} {}", a.law.sigma_t, a.law.G_f, a.law.beta);
  return s;
}

/* ---------------------------------------------------------------------- */

std::string FixDefe::pack_script() const
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
  const int counts[2] = {static_cast<int>(de_radius_max.size()), static_cast<int>(parts.size())};
  put(counts, sizeof(counts));
  put(de_radius_max.data(), sizeof(double) * de_radius_max.size());
  for (const auto &p : parts) put(&p.shield_time, sizeof(double));
  std::string texts, set;
  for (const auto &p : parts) texts += describe_part(p) + "\n";
  for (const auto &s : settings()) set += s.first + "\n" + s.second + "\n";
  put_text(texts);
  put_text(set);
  put_text(event_log.written().name);
  return all;
}

std::string FixDefe::unpack_script(const char *data, size_t bytes)
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
  if (counts[0] != static_cast<int>(de_radius_max.size()) ||
      counts[1] != static_cast<int>(parts.size()))
    error->all(FLERR,
               "Fix defe in the restart file had {} parts and {} atom types, now {} and {}: give "
               "the same fix defe command as before",
               counts[1], counts[0] - 1, parts.size(), de_radius_max.size() - 1);
  get(de_radius_max.data(), sizeof(double) * de_radius_max.size());
  for (auto &p : parts) get(&p.shield_time, sizeof(double));
  const auto texts = utils::split_lines(get_text());
  for (size_t p = 0; p < parts.size(); p++) {
    const std::string before = p < texts.size() ? texts[p] : "";
    if (!defe::same_words(before, describe_part(parts[p])))
      error->all(FLERR,
                 "Fix defe part {} was '{}' in the restart file and is '{}' now: give the same "
                 "materials and parts in the same order",
                 p + 1, before, describe_part(parts[p]));
  }
  const auto lines = utils::split_lines(get_text());
  std::map<std::string, std::string> before;
  for (size_t k = 0; k + 1 < lines.size(); k += 2) before[lines[k]] = lines[k + 1];
  note_changes(before);
  return get_text();
}

void FixDefe::note_changes(const std::map<std::string, std::string> &before)
{
  if (comm->me) return;
  const auto now = settings();
  auto changed = [this](const std::string &key, const std::string &is, const std::string &was) {
    utils::logmesg(lmp, "Note: fix {} defe has {} {}, and had {} in the restart file\n", id, key,
                   is, was);
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
