#ifndef DEFE_TEST_CRACK_STRIP_H
#define DEFE_TEST_CRACK_STRIP_H

// A notched strip of glass between grips that draw it apart, its lattice turned; and what the event file says of
// the crack. The grips stay finite elements; the glass is DEs from the start, or converts before the crack.
//
// The notch is a plane through the lattice, not a slot of the mesh: the joints that cross it are made weak and break
// in the first steps.

#include "events.h"
#include "glass_block.h"
#include "mesh_file.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace defe::test {

/// Turned about x, then about z (degrees).
inline Mat3 turned(double about_z, double about_x = 0.0)
{
  return (Eigen::AngleAxisd(about_z * M_PI / 180.0, Vec3::UnitZ()) *
          Eigen::AngleAxisd(about_x * M_PI / 180.0, Vec3::UnitX()))
      .toRotationMatrix();
}

/// A lattice of which this direction is along y.
inline Mat3 with_along_y(const Vec3 &direction)
{
  Mat3 axes;    // of the body in those of the lattice
  axes.col(1) = direction.normalized();
  axes.col(0) = axes.col(1).cross(std::abs(axes(2, 1)) < 0.9 ? Vec3::UnitZ() : Vec3::UnitX());
  axes.col(0).normalize();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes.transpose();
}

struct CrackStrip {
  static constexpr double d = 1e-3, h = 2.0 * d;    // spacing of DEs, edge of elements

  Mat3 turn = Mat3::Identity();
  double left = -16.0, right = 20.0, height = 24.0,
         thickness = 6.0;    // in d; the notch ends at x = 0
  double G_f = 10.0;
  bool adaptive = false;
  double moved = 0.0;                    // nodes, by h
  double strain = 1.6e-4, rate = 4.0;    // at the beginning, and of it
  double stop = 16.0;                    // where the crack has come far enough, in d
  double tough_end = 0.0;                // at the right, of elements that do not convert, in d
  double dt = 5e-8;
  std::string name = "strip", options;

  bool holds(const Vec3 &c) const
  {
    return c[0] > left * d && c[0] < right * d && std::abs(c[1]) < 0.5 * height * d &&
        std::abs(c[2]) < 0.5 * thickness * d;
  }
  bool grips(const Vec3 &c) const { return std::abs(c[1]) > (0.5 * height - 2.5) * d; }
};

/// The elements of a turned block whose centre is in the strip. Node types: 1, and 2 of grips.
inline MeshFile mesh_of(const CrackStrip &strip)
{
  constexpr double h = CrackStrip::h;
  const double reach =
      Vec3(std::max(-strip.left, strip.right), 0.5 * strip.height, 0.5 * strip.thickness).norm() *
      CrackStrip::d;
  const int n = 2 * static_cast<int>(std::ceil(reach / h)) +
      1;    // odd: the axis of the strip runs inside elements
  MeshFile all, mesh;
  tagint tag = 0;
  all.add_block("glass", 1, n, n, n, h, [&](const Vec3 &X) {
    return Vec3(strip.turn *
                (X - Vec3::Constant(0.5 * n * h) + strip.moved * h * random_of(++tag, 12)));
  });
  std::vector<tagint> id(all.X.size(), 0);
  for (auto nodes : all.hex) {
    Vec3 c = Vec3::Zero();
    for (tagint t : nodes) c += all.X[t - 1] / 8.0;
    if (!strip.holds(c)) continue;
    for (tagint &t : nodes) {
      if (!id[t - 1]) {
        mesh.X.push_back(all.X[t - 1]);
        mesh.type.push_back(1);
        id[t - 1] = static_cast<tagint>(mesh.X.size());
      }
      t = id[t - 1];
      if (strip.grips(c)) mesh.type[t - 1] = 2;
    }
    mesh.hex.push_back(nodes);
    const bool tough = strip.grips(c) || c[0] > (strip.right - strip.tough_end) * CrackStrip::d;
    mesh.part.push_back(tough ? "grip" : "glass");
  }
  mesh.types = 5;
  const double deep = 0.5 * std::max(strip.height, strip.thickness + 6.0);
  mesh.lo = Vec3(1.5 * strip.left, -strip.height, -deep) * CrackStrip::d;
  mesh.hi = Vec3(1.5 * strip.right, strip.height, deep) * CrackStrip::d;
  return mesh;
}

/// Where DE `id` begins.
inline Vec3 place_of(const MeshFile &mesh, long id)
{
  const long k = id - 1 - static_cast<long>(mesh.X.size());
  Vec3 X = Vec3::Zero();
  for (int a = 0; a < 8; a++) {
    double weight = 1.0;
    for (int c = 0; c < 3; c++) weight *= 0.5 + 0.25 * fe::hex_sign[a][c] * fe::hex_sign[k % 8][c];
    X += weight * mesh.X[mesh.hex[k / 8][a] - 1];
  }
  return X;
}

inline std::string header_of(const CrackStrip &)
{
  return script_head();
}

inline std::string fix_of(const CrackStrip &strip)
{
  return "region seam block INF 1.5e-3 -3e-3 3e-3 INF INF\n"
         "fix fe all defe material glass elastic 74.09e9 0.2 2500 part grip glass convert glass "
         "56e6 type 3 "
         "group particles start " +
      std::string(strip.adaptive ? "seam" : "all") + " events " + strip.name + ".txt " +
      strip.options + "\n";
}

inline std::string motion_of(const CrackStrip &strip)
{
  return "fix move1 nodes nve\nfix move2 particles nve/sphere\nfix hold grips setforce 0 0 0\n"
         "neighbor 3e-4 bin\ntimestep " +
      number(strip.dt) + "\n";
}

/// Ready to be drawn apart: the notch is there, and 40 steps are done.
inline void prepare(Lammps &lmp, const CrackStrip &strip, const MeshFile &mesh, MPI_Comm comm)
{
  const std::string joint =
      " connective material cohesive 60e6 " + number(strip.G_f) + " 0.1 contact 0.9 0.2\n";
  std::string box;
  for (int k = 0; k < 3; k++) box += " " + number(mesh.lo[k]) + " " + number(mesh.hi[k]);
  remove_file(strip.name + ".txt", comm);
  mesh.write(strip.name + ".data", comm);
  lmp.commands(header_of(strip) + "region box block" + box +
               "\ncreate_box 5 box\npair_style defe/joint\npair_coeff 3*5 3*5" + joint +
               "group particles empty\n" + fix_of(strip) + read_mesh(strip.name + ".data") +
               "group nodes type 1 2\ngroup grips type 2\n" + motion_of(strip));
  lmp.change([&](Particle &p) {
    p.v = Vec3(0.0, strip.rate * p.x[1], 0.0);
    p.x[1] *= 1.0 + strip.strain;
    p.x[2] *= 1.0 - 0.25 * strip.strain;
  });
  lmp.run(0);
  lmp.commands(
      "region above block INF 0 0 3e-3 INF INF\nregion below block INF 0 -3e-3 0 INF INF\n"
      "group above region above\ngroup above1 intersect above particles\nset group above1 type 4\n"
      "group below region below\ngroup below1 intersect below particles\nset group below1 type 5\n"
      "pair_coeff 4 5 connective material cohesive 1e6 1e-6 0.1 contact 0.9 0.2\nrun 40\n"
      "pair_coeff 4 5" +
      joint);
}

/// How far joints have broken, in d; half of the thickness.
inline double tip_of(const CrackStrip &strip, const std::vector<Event> &events)
{
  std::vector<double> x;
  for (const auto &e : events)
    if (e.what == "broken" && e.step > 40) x.push_back(e.x[0] / CrackStrip::d);
  const size_t row = static_cast<size_t>(0.6 * strip.thickness);
  if (x.size() < row) return 0.0;
  std::nth_element(x.begin(), x.end() - row, x.end());
  return *(x.end() - row);
}

struct CrackPath {
  double tilt_along = 0.0, tilt_across = 0.0, scatter = 0.0;    // of the mean plane in degrees; d
  double area = 0.0;    // projected area of broken joints by true area
  double work = 0.0;    // fracture energy by projected area of damage, over G_f
  double rise = 0.0;    // of kinetic and stored energy less the work done, of the largest
  double tip = 0.0;
  int cut = 0, stray = 0, loose = 0;    // joints, those beside the crack; DEs without joints
  int converted = 0, holding = 0;       // elements, beside the notch; those with a cut joint
  double energy() const { return area * work; }    // fracture energy by true area, over G_f
};

class PathOf {
 public:
  PathOf(const CrackStrip &strip, const MeshFile &mesh) : strip(strip), mesh(mesh) {}

  CrackPath measure(const std::vector<Event> &events)
  {
    CrackPath r;
    for (const auto &e : events) {
      if (e.step <= 40) continue;
      if (e.what == "cohesive") started.push_back(e);
      if (e.what == "broken") broken.push_back(e);
    }
    r.tip = tip_of(strip, events);
    mean_plane(r);
    spread(r);
    r.cut = static_cast<int>(started.size());
    elements(r, events);
    return r;
  }

  /// Projected area times damage of all joints; `damage` of those that soften: ID, ID, D.
  double damaged_area(const std::vector<std::vector<double>> &damage) const
  {
    std::map<std::pair<long, long>, double> softening;
    for (const auto &row : damage)
      if (row[2] > 0.0) softening[{std::lround(row[0]), std::lround(row[1])}] = row[2];
    double sum = 0.0;
    for (const auto &e : broken) sum += area(e);
    for (const auto &e : started) {
      const auto found = softening.find({e.a, e.b});
      if (found != softening.end()) sum += found->second * area(e);
    }
    return sum;
  }

 private:
  /// Projected area of a joint.
  double area(const Event &e) const
  {
    const Vec3 axis = (place_of(mesh, e.b) - place_of(mesh, e.a)).normalized();
    return CrackStrip::d * CrackStrip::d * std::abs(axis.dot(Vec3(e.n)));
  }

  void elements(CrackPath &r, const std::vector<Event> &events) const
  {
    std::set<long> with;
    const auto element_of = [this](long de) {
      return (de - 1 - static_cast<long>(mesh.X.size())) / 8 + 1;
    };
    for (const auto &e : started) with.insert({element_of(e.a), element_of(e.b)});
    for (const auto &e : events)
      if (e.what == "convert" && e.step > 0) {
        r.converted++;
        r.holding += static_cast<int>(with.count(e.a));
      }
  }

  const CrackStrip &strip;
  const MeshFile &mesh;
  std::vector<Event> started, broken;
  static constexpr double begin = 2.0;    // d from the notch
  Vec3 k, n;

  /// y = k0 + k1 x + k2 z, in d
  void mean_plane(CrackPath &r)
  {
    Mat3 A = Mat3::Zero();
    Vec3 b = Vec3::Zero();
    for (const auto &e : broken) {
      if (e.x[0] < begin * CrackStrip::d) continue;
      const Vec3 row = Vec3(CrackStrip::d, e.x[0], e.x[2]) / CrackStrip::d;
      A += area(e) * row * row.transpose();
      b += area(e) * e.x[1] / CrackStrip::d * row;
    }
    k = A.ldlt().solve(b);
    n = Vec3(-k[1], 1.0, -k[2]).normalized();
    r.tilt_along = std::atan(k[1]) * 180.0 / M_PI;
    r.tilt_across = std::atan(k[2]) * 180.0 / M_PI;
  }

  double off(const Event &e) const
  {
    return (Vec3(e.x) / CrackStrip::d - k[0] * Vec3::UnitY()).dot(n);
  }

  /// Smooth, so that it does not matter where rows of the lattice lie; it leaves out the jagged faces.
  static double window(double x, double x1, double x2)
  {
    return std::clamp(0.5 * std::min(x - x1, x2 - x), 0.0, 1.0);
  }

  void spread(CrackPath &r) const
  {
    const double z = 0.5 * strip.thickness - 0.5, end = r.tip - 2.0;
    double squares = 0.0, sum = 0.0, inside = 0.0, whole = 0.0;
    for (const auto &e : broken) {
      if (e.x[0] < begin * CrackStrip::d) continue;
      squares += area(e) * off(e) * off(e);
      sum += area(e);
      inside += area(e) * window(e.x[0] / CrackStrip::d, begin, end) *
          window(e.x[2] / CrackStrip::d, -z, z);
    }
    // at jagged faces, of lattices tilted out of the plane, the edge of the crack may run 2 d beside it
    const bool jagged = std::abs(strip.turn(2, 2)) < 0.999;
    const double within = 0.5 * strip.thickness - (jagged ? 3.0 : 0.0);
    for (const auto &e : started)
      r.stray += e.x[0] > begin * CrackStrip::d && std::abs(off(e)) > 1.5 &&
          std::abs(e.x[2]) < within * CrackStrip::d;
    constexpr double step = 1.0 / 12.0;
    for (double x = begin + 0.5 * step; x < end; x += step)
      for (double y = -z + 0.5 * step; y < z; y += step)
        whole += window(x, begin, end) * window(y, -z, z) * step * step;
    r.scatter = std::sqrt(squares / sum);
    r.area = inside / (CrackStrip::d * CrackStrip::d * whole / n[1]);
  }
};

/// Between the times at which the farthest broken joint passes x1 and x2 (in d).
inline double speed_between(const std::vector<Event> &events, double x1, double x2)
{
  double t1 = -1.0;
  for (const auto &e : events) {
    if (e.what != "broken") continue;
    const double x = e.x[0] / CrackStrip::d;
    if (t1 < 0.0 && x >= x1) t1 = e.time;
    if (x >= x2) return (x2 - x1) * CrackStrip::d / (e.time - t1);
  }
  return 0.0;
}

/// Cracks that pass this place, at least 3 d from each other.
inline int arms_at(const std::vector<Event> &events, double x)
{
  std::vector<double> y;
  for (const auto &e : events)
    if (e.what == "broken" && std::abs(e.x[0] / CrackStrip::d - x) < 2.0)
      y.push_back(e.x[1] / CrackStrip::d);
  std::sort(y.begin(), y.end());
  int arms = y.empty() ? 0 : 1;
  for (size_t k = 1; k < y.size(); k++) arms += y[k] - y[k - 1] > 3.0;
  return arms;
}

/// DEs beyond the notch without any joint.
inline int loose(Lammps &lmp)
{
  std::map<tagint, double> joints;
  for (int k = 1; k <= 3; k++)
    for (const auto &[tag, count] : lmp.per_atom("held", k)) joints[tag] += count;
  int found = 0;
  for (const auto &[tag, p] : lmp.particles())
    found += p.radius > 0.0 && p.x[0] > 2.0 * CrackStrip::d && joints[tag] == 0.0;
  return found;
}

/// Measured while it is drawn apart, until the crack is far enough.
inline CrackPath crack_of(const CrackStrip &strip, MPI_Comm comm = MPI_COMM_WORLD)
{
  const MeshFile mesh = mesh_of(strip);
  Lammps lmp(comm);
  prepare(lmp, strip, mesh, comm);
  const double before = lmp.fe(FRACTURE);
  lmp.commands("compute joints all defe/joint/local id1 id2 damage\n"
               "compute held all defe/atom connective cohesive ties\n");
  lmp.record({"f_fe[14]+pe-f_fe[21]", "f_fe[14]+pe"}, 5);
  std::vector<Event> events;
  for (int k = 0; k < 40 && tip_of(strip, events) < strip.stop; k++) {
    lmp.run(50);
    MPI_Barrier(comm);
    events = read_events(strip.name + ".txt");
  }
  PathOf path(strip, mesh);
  CrackPath r = path.measure(events);
  r.work = (lmp.fe(FRACTURE) - before) / (strip.G_f * path.damaged_area(lmp.local("joints")));
  r.loose = loose(lmp);
  double lowest = HUGE_VAL, most = 0.0;
  for (double e : lmp.recorded(0)) {
    lowest = std::min(lowest, e);
    r.rise = std::max(r.rise, e - lowest);
  }
  for (double e : lmp.recorded(1)) most = std::max(most, e);
  r.rise /= most;
  return r;
}

inline void report(const std::string &name, const CrackPath &r)
{
  std::printf("%-34s tilt %5.1f %5.1f deg, scatter %.2f d, area %.3f, energy %.3f G_f, stray %d of "
              "%d, loose %d, "
              "energy up %.1e, elements %d of %d, tip %.1f\n",
              name.c_str(), r.tilt_along, r.tilt_across, r.scatter, r.area, r.energy(), r.stray,
              r.cut, r.loose, r.rise, r.holding, r.converted, r.tip);
}

/// What the law promises.
inline CrackPath expect_straight(const std::string &name, const CrackStrip &strip,
                                 double area = 0.1, double energy = 0.1)
{
  const CrackPath r = crack_of(strip, MPI_COMM_SELF);
  report(name, r);
  EXPECT_GT(r.tip, strip.stop) << name;
  EXPECT_LT(std::abs(r.tilt_along), 4.0) << name;
  EXPECT_LT(std::abs(r.tilt_across), 4.0) << name;
  EXPECT_LT(r.scatter, 1.0) << name;
  EXPECT_NEAR(r.area, 1.0, area) << name;
  EXPECT_NEAR(r.energy(), 1.0, energy) << name;
  EXPECT_LE(r.stray, r.cut / 40) << name;
  EXPECT_EQ(r.loose, 0) << name;
  EXPECT_LT(r.rise, 1e-3) << name;
  return r;
}

}    // namespace defe::test

#endif
