#include "added_forces.h"

#include "defe/coupling/friction.h"
#include "defe/coupling/surface_contact.h"

#include <algorithm>
#include <cmath>

namespace defe {

void SurfaceTables::clear()
{
  facets.clear();
  planes.clear();
  points.clear();
  candidates.clear();
  patches.clear();
  balls.clear();
}

double side_weight(double own_area, double facet_area)
{
  const double own = own_area * own_area, other = facet_area * facet_area;
  return other / (own + other);
}

namespace {

  /// The softer deformable side.
  double softer(double one, double other)
  {
    if (one < 0.0) return other;
    return other < 0.0 ? one : std::min(one, other);
  }

  // viscous coefficient of a ball's friction where it hardly slides, in masses per time step: each node carries
  // up to 4 facets
  constexpr double stick = 0.1;

  // an overlap cannot grow faster than this multiple of speed and area: by the depth itself, and by the shares
  constexpr double growth = 4.0;

  /// One patch (or the sphere) on one facet.
  struct Active {
    int facet;
    int patch;    // index into patches, -1 for a sphere
    SurfacePair pair;
    SurfaceContact contact;
    double weight;    // its area (of a sphere: 1), then its force along the normal
  };

  /// Those of one point. Reused from point to point and filled in place: leftovers of the last point are never
  /// read.
  class ActiveList {
   public:
    void clear() { count = 0; }
    bool empty() const { return count == 0; }
    Active &add()
    {
      if (count == list.size()) list.resize(2 * count + 8);
      return list[count++];
    }
    void drop_last() { --count; }
    Active *begin() { return list.data(); }
    Active *end() { return list.data() + count; }
    const Active *begin() const { return list.data(); }
    const Active *end() const { return list.data() + count; }

   private:
    std::vector<Active> list;
    size_t count = 0;
  };

  /// exact: all that is added to forces and torques is on the grids of the arrays.
  template <bool exact> class Loop {
   public:
    Loop(const SurfaceTables &tables, const ContactPairs &near, const SurfaceArrays &arrays,
         ContactMemory &history) :
        t(tables),
        pairs(near), a(arrays), memory(history), add(arrays)
    {
    }

    SurfaceResult run()
    {
      for (size_t k = 0; k < pairs.points.size(); ++k) point(static_cast<int>(k));
      for (size_t k = 0; k < t.balls.size(); ++k) ball(static_cast<int>(k));
      result.beyond = add.beyond;
      return std::move(result);
    }

   private:
    const SurfaceTables &t;
    const ContactPairs &pairs;
    const SurfaceArrays &a;
    ContactMemory &memory;
    AddedForces<exact> add;
    SurfaceResult result;
    ActiveList active;
    // of this point in this step: energy that came from nowhere, and energy that was let through
    double returned = 0.0, lost = 0.0;
    double area = 1.0;    // of its patches

    void add_load(const ContactFacet &facet, const FacetLoad &load)
    {
      for (int k = 0; k < 4; ++k) add.force(facet.node[k], load.on_node(k));
    }

    void add_virial(const FacetPlane &g, const FacetLoad &load, const Vec3 &origin)
    {
      if (!a.virial) return;
      const Mat3 w = load.virial(g, origin);
      result.virial[0] += w(0, 0);
      result.virial[1] += w(1, 1);
      result.virial[2] += w(2, 2);
      result.virial[3] += w(0, 1);
      result.virial[4] += w(0, 2);
      result.virial[5] += w(1, 2);
    }

    Vec3 facet_velocity(const ContactFacet &facet, double xi, double eta) const
    {
      double N[4];
      facet_shape(xi, eta, N);
      Vec3 v = Vec3::Zero();
      for (int k = 0; k < 4; ++k) v += N[k] * vector_at(a.v, facet.node[k]);
      return v;
    }

    // a step ago; velocities are those of half a step ago
    Vec3 place_before(int i) const { return vector_at(a.x, i) - a.dt * vector_at(a.v, i); }
    FacetPlane plane_before(const ContactFacet &facet) const
    {
      double x[12];
      for (int k = 0; k < 4; ++k) Vec3::Map(x + 3 * k) = place_before(facet.node[k]);
      const int node[1][4] = {{0, 1, 2, 3}};
      FacetPlane plane;
      facet_planes(1, node, x, &plane);
      return plane;
    }

    SurfaceContact contact_before(const ContactPoint &cp, const Active &one) const
    {
      const FacetPlane g = plane_before(t.facets[one.facet]);
      const Vec3 p = place_before(cp.atom);
      if (one.patch >= 0) {
        const ContactPatch &patch = t.patches[one.patch];
        return patch_on_facet(plane_before(t.facets[patch.facet]), patch.corner, p, g, one.pair);
      }
      return sphere_on_facet(p, cp.r, g, one.pair);
    }

    /// If in this step it crossed the depth to which points are followed, inwards or (sign < 0) outwards: the
    /// energy that is lost or comes from nowhere, with half of the work of the step, as the half kicks of velocity
    /// Verlet have it.
    void cross_limit(const ContactPoint &cp, const Active &one, double sign)
    {
      if (!a.moving || a.energy_only) return;
      const SurfaceContact before = contact_before(cp, one);
      if (!(before.share > 0.0) || (before.raw_depth > one.pair.depth_max) == (sign > 0.0)) return;
      const ContactHistory *history = memory.find(cp.atom, cp.part);
      const double offset = history ? history->offset : 0.0;
      Penalty both{0.0, 0.0};
      add_penalty(one, before, offset, both);
      add_penalty(one, one.contact, offset, both);
      const double energy = 0.5 * both.energy;
      if (sign > 0.0) {
        lost += energy;
        if (energy == 0.0 && one.contact.depth <= 0.0)
          return;    // beside the rim, not through the face
        // the DEs in the middle of an element's edge are as deep behind faces round the corner from the start
        const LocalPoint &at = one.contact.point;
        const bool over = cp.r == 0.0 || (std::abs(at.xi) <= 1.0 && std::abs(at.eta) <= 1.0);
        result.let_through.push_back({cp.atom, one.facet, one.contact.raw_depth, energy, over});
      } else
        returned += energy;
    }

    /// The last one of `active` presses, or is dropped. in_contact: it has a share.
    void keep_active(const ContactPoint &cp, bool in_contact)
    {
      const Active &one = *(active.end() - 1);
      if (in_contact) {
        if (one.contact.raw_depth > one.pair.depth_max)
          cross_limit(cp, one, 1.0);
        else if (one.contact.depth > 0.0) {
          // at most 0.1 of that in a step
          if (one.contact.raw_depth > 0.9 * one.pair.depth_max) cross_limit(cp, one, -1.0);
          return;
        }
      }
      active.drop_last();
    }

    Active &add_active(int index, int patch, const ContactFacet &facet, double stiffness,
                       double half, double depth_max)
    {
      Active &one = active.add();
      one.facet = index;
      one.patch = patch;
      SurfacePair &pair = one.pair;
      pair.stiffness = stiffness;
      pair.t_xi = half / facet.half_xi;
      pair.t_eta = half / facet.half_eta;
      pair.half_xi = facet.half_xi;
      pair.half_eta = facet.half_eta;
      pair.depth_max = depth_max;
      std::copy_n(facet.rim, 4, pair.rim);
      return one;
    }

    /// The patches of a node side by side, for all facets that it is tested against.
    struct OwnPatch {
      Vec3 normal;
      double quarter, area, half, k_area;
    };
    std::vector<OwnPatch> own_patches;
    bool own_equal = false;    // all of one size and stiffness

    void gather_own_patches(const ContactPoint &cp)
    {
      own_patches.resize(cp.nown);
      own_equal = true;
      for (int m = 0; m < cp.nown; ++m) {
        const int facet = t.patches[cp.own + m].facet;
        const ContactFacet &own = t.facets[facet];
        OwnPatch &patch = own_patches[m];
        patch.normal = t.planes[facet].normal;
        patch.area = own.area;
        patch.quarter = 0.25 * own.area;
        patch.half = 0.5 * std::min(own.half_xi, own.half_eta);
        patch.k_area = own.k_area;
        // up to rounding of the coordinates
        const OwnPatch &first = own_patches[0];
        own_equal = own_equal && patch.k_area == first.k_area &&
            std::abs(patch.area - first.area) <= 1e-12 * first.area &&
            std::abs(patch.half - first.half) <= 1e-12 * first.half;
      }
    }

    void find_active_of_node(const ContactPoint &cp, const Vec3 &p)
    {
      bool gathered = false;
      for (int k = cp.first; k < cp.first + cp.count; ++k) {
        const FacetPlane &g = t.planes[pairs.candidates[k]];
        const Vec3 off = p - g.mid;
        const double h = off.dot(g.normal);
        if (h >= 0.0) continue;
        const ContactFacet &facet = t.facets[pairs.candidates[k]];
        // on its far side; beside a rim a node can be far below the plane, and its patch still press
        const bool deep = h < -1.5 * facet.depth_max;
        if (deep && !(facet.rim[0] || facet.rim[1] || facet.rim[2] || facet.rim[3])) continue;
        const LocalPoint at = {off.dot(g.to_xi), off.dot(g.to_eta), h};
        const double beside[2] = {(std::abs(at.xi) - 1.0) * facet.half_xi,
                                  (std::abs(at.eta) - 1.0) * facet.half_eta};
        if (deep && beside[0] <= 0.0 && beside[1] <= 0.0) continue;
        // where the surface goes on, no share is left from half a patch on
        if (beside[0] > (facet.rim[at.xi < 0.0] ? 1.1 : 0.5) * cp.half ||
            beside[1] > (facet.rim[2 + (at.eta < 0.0)] ? 1.1 : 0.5) * cp.half)
          continue;
        if (!gathered) gather_own_patches(cp);
        gathered = true;
        if (!whole_node(cp, pairs.candidates[k], at)) patches_of_node(cp, pairs.candidates[k], p);
      }
      area = 0.0;
      if (active.empty()) return;
      for (const OwnPatch &own : own_patches) area += own.quarter;
    }

    /// All patches of a node together, where neither their places nor their normals make a difference: far
    /// from rims, and parallel to the facet or turned away from it. False: each must be computed on its own.
    bool whole_node(const ContactPoint &cp, int index, const LocalPoint &at)
    {
      const ContactFacet &facet = t.facets[index];
      const Vec3 &n = t.planes[index].normal;
      double stiffness = 0.0, area = 0.0, half = 0.0;
      int facing = 0;
      for (const OwnPatch &own : own_patches) {
        const double c = -own.normal.dot(n);
        if (c <= facing_limit) continue;
        if (c < parallel_limit) return false;
        ++facing;
        if (own_equal) continue;
        if (half == 0.0) half = own.half;
        if (std::abs(own.half - half) > 1e-12 * half) return false;
        const double share = own.quarter * side_weight(own.area, facet.area);
        stiffness += softer(own.k_area, facet.k_area) * share;
        area += share;
      }
      if (facing == 0) return true;
      if (own_equal) {
        const OwnPatch &own = own_patches[0];
        half = own.half;
        area = facing * own.quarter * side_weight(own.area, facet.area);
        stiffness = softer(own.k_area, facet.k_area) * area;
      }
      // the middle of a patch is at most 0.65 of its reach from its node
      const double clear = 0.65 * cp.half + std::max(half, -2.0 * at.h);
      const double way[4] = {(1.0 - at.xi) * facet.half_xi, (1.0 + at.xi) * facet.half_xi,
                             (1.0 - at.eta) * facet.half_eta, (1.0 + at.eta) * facet.half_eta};
      for (int e = 0; e < 4; ++e)
        if (facet.rim[e] && way[e] < clear) return false;
      for (int e = 0; e < 4; ++e)
        if (!facet.rim[e] && way[e] <= -half) return true;    // its share is 0
      Active &one = add_active(index, -1, facet, stiffness, half, facet.depth_max);
      one.weight = area;
      keep_active(cp, sphere_on_facet(at, 0.0, one.pair, one.contact));
      return true;
    }

    void patches_of_node(const ContactPoint &cp, int index, const Vec3 &p)
    {
      const ContactFacet &facet = t.facets[index];
      const FacetPlane &g = t.planes[index];
      for (int m = 0; m < cp.nown; ++m) {
        const OwnPatch &own = own_patches[m];
        if (-own.normal.dot(g.normal) <= facing_limit) continue;
        const ContactPatch &patch = t.patches[cp.own + m];
        Active &one =
            add_active(index, cp.own + m, facet, softer(own.k_area, facet.k_area) * own.quarter,
                       own.half, facet.depth_max);
        one.pair.weight = {side_weight(own.area, facet.area), cp.sharp};
        one.weight = own.quarter;
        keep_active(
            cp, patch_on_facet(t.planes[patch.facet], patch.corner, p, g, one.pair, one.contact));
      }
    }

    void find_active_of_sphere(const ContactPoint &cp, const Vec3 &p)
    {
      for (int k = cp.first; k < cp.first + cp.count; ++k) {
        const ContactFacet &facet = t.facets[pairs.candidates[k]];
        const FacetPlane &g = t.planes[pairs.candidates[k]];
        const Vec3 off = p - g.mid;
        const double h = off.dot(g.normal);
        if (h >= cp.r || h < -1.5 * facet.depth_max) continue;
        const LocalPoint at = {off.dot(g.to_xi), off.dot(g.to_eta), h};
        if ((std::abs(at.xi) - 1.0) * facet.half_xi >= cp.half ||
            (std::abs(at.eta) - 1.0) * facet.half_eta >= cp.half)
          continue;
        if (memory.tied(cp.atom, facet.element)) continue;
        Active &one =
            add_active(pairs.candidates[k], -1, facet, softer(cp.k_own, facet.k_area) * cp.area,
                       cp.half, cp.r + facet.depth_max);
        one.weight = 1.0;
        keep_active(cp, sphere_on_facet(at, cp.r, one.pair, one.contact));
      }
    }

    /// Energy of all that press, and -d energy / d offset.
    Penalty all_at(double offset) const
    {
      Penalty sum{0.0, 0.0};
      for (const Active &one : active) add_penalty(one, one.contact, offset, sum);
      return sum;
    }
    double energy_at(double offset) const { return all_at(offset).energy; }

    static void add_penalty(const Active &one, const SurfaceContact &c, double offset, Penalty &sum)
    {
      const double scale = one.pair.stiffness * c.share;
      const Penalty psi = penalty_potential(c.depth - offset, one.pair.depth_max);
      sum.energy += scale * psi.energy;
      sum.force += scale * psi.force;
    }

    /// What an offset that is raised in motion does to the energy. The kicks of velocity Verlet do half of the
    /// work of this step with the force of the last evaluation and half with the present one. So the total changes
    /// by the energy with the new offset less that with the old one, the mean of both positions, of all that pressed
    /// before. What did not press a step ago had no energy, however deep it is found now: `history` says what there
    /// was.
    double raised(const ContactPoint &cp, const ContactHistory &history, double old_offset) const
    {
      Penalty now{0.0, 0.0}, before{0.0, 0.0}, old_now{0.0, 0.0}, old_before{0.0, 0.0};
      for (const Active &one : active) {
        add_penalty(one, one.contact, history.offset, now);
        const SurfaceContact c = contact_before(cp, one);
        if (!(c.share > 0.0)) continue;
        add_penalty(one, c, history.offset, before);
        if (c.raw_depth > one.pair.depth_max) continue;
        add_penalty(one, c, old_offset, old_before);
        add_penalty(one, one.contact, old_offset, old_now);
      }
      const bool known = std::abs(old_before.energy - history.energy) <= 1e-6 * history.energy;
      const double had = known ? 0.5 * (old_before.energy + old_now.energy) : history.energy - lost;
      return 0.5 * (before.energy + now.energy) - had;
    }

    /// Largest speed of the point against the nodes of its facets and of those that it presses on, or any that is
    /// `enough`.
    double largest_speed(const ContactPoint &cp, double enough) const
    {
      const Vec3 v = vector_at(a.v, cp.atom);
      double square = 0.0;
      for (const Active &one : active) {
        for (int node : t.facets[one.facet].node)
          square = std::max(square, (v - vector_at(a.v, node)).squaredNorm());
        if (one.patch >= 0)
          for (int node : t.facets[t.patches[one.patch].facet].node)
            square = std::max(square, (v - vector_at(a.v, node)).squaredNorm());
        if (square > enough * enough) break;
      }
      return std::sqrt(square);
    }

    /// DEs of distorted or pressed elements reach below faces beside those that they are tied to: where these are of
    /// the same body, no contact was there before.
    bool inherits(const ContactPoint &cp) const
    {
      return memory.inherits(cp.atom, cp.part) &&
          std::none_of(active.begin(), active.end(), [&](const Active &one) {
               return memory.was_joined(cp.atom, t.facets[one.facet]);
             });
    }

    /// The overlap of this step, compared with that of the last one and what motion can have added to it.
    /// overlap: depth times area, of the part `share` of the area that presses; what has come at once is as much
    /// deeper everywhere. (No mean: patches that have no share may go with their elements.)
    void update_history(const ContactPoint &cp, ContactHistory &history, double overlap,
                        double share)
    {
      double deepest = 0.0;
      for (const Active &one : active) deepest = std::max(deepest, one.contact.depth);
      const double depth = overlap / area;
      double allowed = history.overlap + 1e-6 * area * t.facets[active.begin()->facet].half_xi;
      if (a.minimizing) allowed = HUGE_VAL;
      if (overlap > allowed && a.moving && !memory.newborn(cp.atom)) {
        const double per_speed = area * growth * a.dt;
        allowed += per_speed * largest_speed(cp, (overlap - allowed) / per_speed);
      }
      const double offset =
          history.overlap > 0.0 ? history.offset + (overlap - history.overlap) / share : deepest;
      if (overlap > allowed && inherits(cp)) {
        result.inherited.push_back(
            {cp.atom, active.begin()->facet, depth, energy_at(history.offset) - energy_at(offset)});
      } else if (overlap > allowed) {
        const double last = history.offset;
        history.offset = offset;
        history.eased = a.moving ? 0.0 : 1.0;
        if (a.moving && !a.changed) returned = raised(cp, history, last);
        if (history.offset > result.offset_max) {
          result.offset_max = history.offset;
          result.offset_atom = cp.atom;
        }
        result.offset_count++;
      }
      if (returned != 0.0)
        result.let_through.push_back({cp.atom, active.begin()->facet, depth, -returned, false});
      history.overlap = overlap;
      const double before = history.offset;
      history.offset = std::min(history.offset, deepest);
      if (a.energy_only || !(history.eased > 0.0)) return;
      if (a.moving) history.offset *= 1.0 - a.ease;
      // what easing puts in: the force on the offset, the mean of both steps, as the kicks of velocity
      // Verlet do with the forces on the atoms
      const double push = all_at(history.offset).force;
      if (a.moving) result.eased += 0.5 * (history.push + push) * (before - history.offset);
      history.push = push;
    }

    void point(int index)
    {
      const ContactPoint &cp = pairs.points[index];
      const Vec3 p = vector_at(a.x, cp.atom);
      active.clear();
      returned = lost = 0.0;
      area = 1.0;
      if (cp.r > 0.0)
        find_active_of_sphere(cp, p);
      else
        find_active_of_node(cp, p);

      ContactHistory *history = memory.find(cp.atom, cp.part);
      if (active.empty()) {
        if (history && !a.energy_only) {
          result.friction += history->tangential.stored();    // it is released
          memory.drop(cp.atom, cp.part);
        }
        return;
      }
      double overlap = 0.0, share = 0.0;
      for (const Active &one : active) {
        share += one.weight * one.contact.share;
        overlap += one.weight * one.contact.share * one.contact.depth;
      }
      if (!history) {
        history = &memory.make(cp.atom, cp.part);
        *history = ContactHistory{};
      }
      update_history(cp, *history, overlap, share);
      if (a.energy_only) {
        result.energy += history->energy = energy_at(history->offset);
        return;
      }

      Vec3 on_point = Vec3::Zero(), normal = Vec3::Zero();
      double pushes = 0.0, stiffness = 0.0, energy = 0.0;
      for (Active &one : active) {
        const ContactFacet &facet = t.facets[one.facet];
        const FacetPlane &g = t.planes[one.facet];
        FacetLoad load, on_own;
        SurfaceForce r;
        if (one.patch < 0)
          r = sphere_force(one.contact, history->offset, cp.r, g, one.pair, on_point, load);
        else {
          const ContactPatch &patch = t.patches[one.patch];
          const FacetPlane &o = t.planes[patch.facet];
          r = patch_force(one.contact, history->offset, o, patch.corner, g, one.pair, on_point,
                          on_own, load);
          if (r.normal != 0.0) {
            add_load(t.facets[patch.facet], on_own);
            add_virial(o, on_own, p);
          }
        }
        one.weight = r.normal;    // from here on: the force
        if (r.normal == 0.0) continue;
        energy += r.energy;
        pushes += r.normal;
        stiffness += one.pair.stiffness * one.contact.share;
        normal += r.normal * g.normal;
        add_load(facet, load);
        add_virial(g, load, p);
      }
      result.energy += energy;
      history->energy = energy;
      if (a.friction > 0.0 && pushes > 0.0)
        on_point += friction_of_point(cp, *history, p, normal, pushes, stiffness);
      else if (a.moving) {    // nothing presses: no spring holds
        result.friction += history->tangential.stored();
        history->tangential = {};
      }
      add.force(cp.atom, on_point);
    }

    /// Coulomb friction of a node or DE: one tangential spring against the facets that it presses on, each
    /// by its share of the pressure.
    Vec3 friction_of_point(const ContactPoint &cp, ContactHistory &history, const Vec3 &p,
                           const Vec3 &sum, double pushes, double stiffness)
    {
      const double length = sum.norm();
      if (!(length > 0.0)) return Vec3::Zero();
      const Vec3 n = sum / length;
      const bool sphere = cp.r > 0.0;
      Vec3 slip = Vec3::Zero(), arm = Vec3::Zero();
      if (a.moving)
        for (const Active &one : active) {
          if (one.weight == 0.0) continue;
          const LocalPoint &at = one.contact.point;
          const double share = one.weight / pushes;
          slip += share *
              (vector_at(a.v, cp.atom) - facet_velocity(t.facets[one.facet], at.xi, at.eta));
          if (sphere) arm -= share * at.h * t.planes[one.facet].normal;
        }
      else if (sphere)
        for (const Active &one : active)
          arm -= one.weight / pushes * one.contact.point.h * t.planes[one.facet].normal;
      if (sphere && a.moving) slip += vector_at(a.omega, cp.atom).cross(arm);
      TangentialSpring spring = history.tangential;
      const FrictionResult r =
          coulomb_friction(spring, n, a.moving ? Vec3(a.dt * slip) : Vec3(Vec3::Zero()), stiffness,
                           a.friction * length);
      result.springs += r.stored;
      if (a.moving) {
        history.tangential = spring;
        result.friction += r.rubbed;
      }
      if (sphere) add.torque(cp.atom, arm.cross(r.force));
      for (const Active &one : active) {
        if (one.weight == 0.0) continue;
        const FacetPlane &g = t.planes[one.facet];
        const LocalPoint &at = one.contact.point;
        FacetLoad load;
        load.add(g, -one.weight / pushes * r.force, at.xi, at.eta, sphere ? 0.0 : at.h);
        add_load(t.facets[one.facet], load);
        add_virial(g, load, p);
      }
      return r.force;
    }

    /// Friction has no history: Coulomb's, and viscous where that is less.
    void ball(int index)
    {
      const ContactBall &pair = t.balls[index];
      const ContactFacet &facet = t.facets[pair.facet];
      const FacetPlane &g = t.planes[pair.facet];
      const int i = pair.atom;
      const double R = a.radius[i];
      const Vec3 c = vector_at(a.x, i);
      const LocalPoint at = local_point(g, c);
      if (at.h >= R || at.h < -R) return;
      const double disc = std::sqrt(R * R - at.h * at.h);
      if (std::abs(at.xi) - 1.0 > disc * g.to_xi.norm() ||
          std::abs(at.eta) - 1.0 > disc * g.to_eta.norm())
        return;
      if (at.h <= 0.0) {
        ball_goes_in(pair, at);
        return;
      }
      double over = 1.0;
      Vec3 by_foot = Vec3::Zero();
      if (!facet.outer) {
        constexpr double border = 0.25;    // natural coordinates
        const Share xi = patch_share(at.xi, border), eta = patch_share(at.eta, border);
        over = std::max(0.0, xi.value) * std::max(0.0, eta.value);
        if (over == 0.0 || std::abs(at.xi) > 1.0 + border || std::abs(at.eta) > 1.0 + border)
          return;
        by_foot = xi.slope * eta.value * g.to_xi + xi.value * eta.slope * g.to_eta;
      }
      Vec3 force = Vec3::Zero();
      FacetLoad load;
      const BallForce r = ball_on_facet(c, R, g, over * facet.k_area, facet.area, force, load);
      if (a.energy_only) result.energy += r.energy;
      if (a.energy_only || r.energy == 0.0) return;
      if (!facet.outer) {
        const Vec3 aside = -r.energy / over * by_foot;
        force += aside;
        load.add(g, -aside, at.xi, at.eta, at.h);
      }
      result.energy += r.energy;
      if (a.moving)
        ball_comes_out(pair, r);
      else
        ball_is_in(pair, at, r.energy);
      if (a.friction > 0.0) {
        const Vec3 point = g.mid + r.xi * g.a + r.eta * g.b, off = c - point;
        const Vec3 n = force.normalized();
        Vec3 slip = vector_at(a.v, i) - vector_at(a.omega, i).cross(off) -
            facet_velocity(facet, r.xi, r.eta);
        slip -= slip.dot(n) * n;
        const double speed = slip.norm();
        double mass = HUGE_VAL;
        for (int node : facet.node) mass = std::min(mass, a.mass[node]);
        // as many facets as the ball can cover share its mass
        const double facets = 1.0 + 3.14159265358979323846 * R * R / facet.area;
        const double viscous = stick / (a.dt * (1.0 / mass + facets / a.mass[i]));
        if (speed > 0.0) {
          const double drag = std::min(a.friction * r.normal, viscous * speed);
          const Vec3 rub = -drag / speed * slip;
          force += rub;
          load.add(g, -rub, r.xi, r.eta, 0.0);
          add.torque(i, rub.cross(off));
          if (a.moving) result.friction += drag * speed * a.dt;
        }
      }
      add.force(i, force);
      add_load(facet, load);
      add_virial(g, load, c);
    }

    double height_before(const ContactBall &pair) const
    {
      return local_point(plane_before(t.facets[pair.facet]), place_before(pair.atom)).h;
    }

    void ball_is_in(const ContactBall &pair, const LocalPoint &at, double energy)
    {
      // with its centre inside it is behind several faces, and no one knows which it came through
      const double R = a.radius[pair.atom], depth = std::min(R - at.h, R);
      if (depth < 1e-6 * R) return;    // it touches
      result.ball_energy += energy;
      if (depth <= result.ball_depth) return;
      result.ball_depth = depth;
      result.ball_atom = pair.atom;
    }

    /// Its centre has gone through the plane of the facet in this step: the contact is no more.
    void ball_goes_in(const ContactBall &pair, const LocalPoint &at)
    {
      if (a.energy_only) return;
      const bool over = std::abs(at.xi) <= 1.0 && std::abs(at.eta) <= 1.0;
      if (!a.moving) {
        if (over) ball_is_in(pair, at, 0.0);
        return;
      }
      const double height = height_before(pair);
      if (height <= 0.0) return;    // since some time
      const ContactFacet &facet = t.facets[pair.facet];
      Vec3 force = Vec3::Zero();
      FacetLoad load;
      const BallForce r = ball_on_facet(place_before(pair.atom), a.radius[pair.atom],
                                        plane_before(facet), facet.k_area, facet.area, force, load);
      if (r.energy > 0.0 || over)
        result.let_through.push_back({pair.atom, pair.facet, a.radius[pair.atom] - at.h,
                                      r.energy + 0.5 * r.normal * (height - at.h), over});
    }

    /// It comes out of the body that it was let into: what that stores at once is booked against what was lost.
    void ball_comes_out(const ContactBall &pair, const BallForce &r)
    {
      const double R = a.radius[pair.atom];
      const FacetPlane &g = t.planes[pair.facet];
      const double height = (vector_at(a.x, pair.atom) - g.mid).dot(g.normal);
      const ContactFacet &facet = t.facets[pair.facet];
      const Vec3 way = a.dt * (vector_at(a.v, pair.atom) - facet_velocity(facet, 0.0, 0.0));
      if (height > 2.0 * way.norm()) return;    // it was in front of the facet, most likely
      const double before = height_before(pair);
      if (before > 0.0) return;
      result.let_through.push_back({pair.atom, pair.facet, R - height,
                                    -r.energy - 0.5 * r.normal * (height - before), false});
    }
  };

}    // namespace

SurfaceResult surface_forces(const SurfaceTables &tables, const SurfaceArrays &arrays,
                             ContactMemory &memory, const ContactPairs *near)
{
  const ContactPairs &pairs = near ? *near : tables;
  if (arrays.force_grid.on()) return Loop<true>(tables, pairs, arrays, memory).run();
  return Loop<false>(tables, pairs, arrays, memory).run();
}

}    // namespace defe
