#include "surface_kept.h"

#include <algorithm>

namespace defe::search {

bool KeptSearch::same_settings(const SurfaceScene &s)
{
  const auto same_part = [](const SurfacePart &a, const SurfacePart &b) {
    return a.rigid == b.rigid && a.bulk == b.bulk;
  };
  const bool same = settings.skin == s.skin && settings.factor == s.factor &&
      settings.tied_parts == s.tied_parts &&
      std::equal(settings.parts.begin(), settings.parts.end(), s.parts.begin(), s.parts.end(),
                 same_part);
  if (!same) settings = {s.skin, s.factor, s.parts, s.tied_parts};
  return same;
}

/// Numbers that are spread over all bits, so that sums tell sets apart (the multiplier is that of splitmix64's last step).
static std::uint64_t name_of(const Face &face)
{
  std::uint64_t name = 16 * static_cast<std::uint64_t>(face.id) + 2 * face.face + face.free;
  name = (name ^ (name >> 31)) * 0x94d049bb133111ebULL;
  return name ^ (name >> 29);
}

void KeptSearch::look_at(int i, const SurfaceScene &s, const SurfaceFaces &faces)
{
  if (find(marks, i)) return;
  const double *x = s.particles.at(i);
  Mark mark{i, -1, false, s.particles.id[i], 0, {x[0], x[1], x[2]}};
  for (int k = faces.first_of(i); k < faces.end_of(i); k++)
    mark.faces += name_of(faces.all[faces.at_nodes(k)]);
  if (const Mark *then = find(marks_before, i)) {
    mark.facet = then->facet;
    mark.still = mark.id == then->id && mark.faces == then->faces &&
        dist_sq(x, then->place) <= slack * s.skin * slack * s.skin;
    if (mark.still) std::copy_n(then->place, 3, mark.place);
  }
  mark_at[i] = static_cast<int>(marks.size());
  marks.push_back(mark);
}

int KeptSearch::find_before(const Face &face) const
{
  for (int node : face.node)
    if (!still(node)) return -1;
  for (int k = find(marks, face.node[0])->facet; k >= 0; k = known_before[k].next) {
    const Known &one = known_before[k];
    if (one.element == face.id && one.face == face.face)
      return dist_sq(one.normal, face.normal) <= turn * turn ? k : -1;
  }
  return -1;
}

void KeptSearch::compare(const SurfaceScene &scene, const SurfaceFaces &faces,
                         const ContactFacets &facets)
{
  if (!same_settings(scene)) forget();
  std::swap(marks, marks_before);
  marks.clear();
  if (static_cast<int>(mark_at.size()) < scene.particles.nall) mark_at.resize(scene.particles.nall);
  const auto face_of = [&](int k) -> const Face & {
    return faces.all[facets.side(k).face];
  };
  for (int k = 0; k < facets.count(); k++)
    for (int node : face_of(k).node) look_at(node, scene, faces);
  for (int d = 0; d < scene.des.count; d++) look_at(scene.des.particle[d], scene, faces);

  std::swap(known, known_before);
  known.resize(facets.count());
  now.assign(known_before.size(), -1);
  before.resize(facets.count());
  fresh.clear();
  for (int k = 0; k < facets.count(); k++) {
    const Face &face = face_of(k);
    const int then = find_before(face);
    before[k] = then;
    known[k] = {face.id, face.face, -1, {face.normal[0], face.normal[1], face.normal[2]}};
    if (then >= 0) {
      now[then] = k;
      std::copy_n(known_before[then].normal, 3, known[k].normal);
    } else
      fresh.push_back(k);
  }
  for (Mark &mark : marks) mark.facet = -1;
  for (int k = 0; k < facets.count(); k++)
    known[k].next = std::exchange(marks[mark_at[face_of(k).node[0]]].facet, k);
}

}    // namespace defe::search
