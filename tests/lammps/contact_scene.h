#ifndef DEFE_TEST_CONTACT_SCENE_H
#define DEFE_TEST_CONTACT_SCENE_H

// Bodies of any mesh that meet, without friction and damping unless they are asked for.

#include "glass_block.h"
#include "mesh_file.h"

#include <Eigen/Geometry>

#include <fstream>

namespace defe::test {

/// Atom types: 1 the body that moves, 2 the other one, 3 a ball, 4 DEs.
struct Scene {
  MeshFile mesh;
  std::string materials = "material glass elastic 74.09e9 0.2 2500 part pane glass";
  std::string convert;    // options of fix defe; empty: nothing converts
  std::string contact = "contact 0.2";
  std::string coeff = "connective material cohesive 1e12 1e6 0.1 contact 1.0 0.0";
  std::string regions;    // commands before the fix
  std::string more;       // commands after the mesh
  double dt = 1e-8;
  double skin = 4e-4;

  Scene()
  {
    mesh.types = 4;
    mesh.lo = Vec3::Constant(-0.04);
    mesh.hi = Vec3::Constant(0.04);
  }

  /// n elements with edges h, the middle of the block at the origin, moved by `map`.
  void add(const std::string &part, int type, const std::array<int, 3> &n, double h,
           const std::function<Vec3(const Vec3 &)> &map)
  {
    const Vec3 middle = 0.5 * h * Vec3(n[0], n[1], n[2]);
    mesh.add_block(part, type, n[0], n[1], n[2], h, [&](const Vec3 &X) {
      return map(X - middle);
    });
  }

  static std::string header() { return script_head(); }
  std::string fix_only() const
  {
    return "fix fe all defe " + materials + " " + convert + " " + contact + "\n";
  }
  std::string motion() const
  {
    return "group nodes type 1 2\nfix move1 nodes nve\nfix move2 particles nve/sphere\nneighbor " +
        number(skin) + " bin\nneigh_modify every 1 delay 0 check yes\ntimestep " + number(dt) +
        "\n";
  }

  /// All but `run`. The mesh goes through a file of this name.
  void start(Lammps &lmp, MPI_Comm comm = MPI_COMM_WORLD,
             const std::string &file = "contact_scene.data") const
  {
    mesh.write(file, comm);
    std::string box = "region box block";
    for (int k = 0; k < 3; k++) box += " " + number(mesh.lo[k]) + " " + number(mesh.hi[k]);
    lmp.commands(header() + box + "\ncreate_box " + std::to_string(mesh.types) + " box\n" +
                 regions + "\npair_style defe/joint\npair_coeff 4 4 " + coeff +
                 "\ngroup particles empty\n" + fix_only() + read_mesh(file) + more + motion());
  }
};

inline Mat3 turn(double angle, const Vec3 &axis)
{
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

/// A steel ball of 8 mm hits a bar of 16 x 5 x 2 cubes of glass.
inline Scene ball_on_bar(double fs, double v, double dt, const std::string &law = "")
{
  Scene s;
  s.dt = dt;
  s.contact = "contact " + number(fs);
  s.convert = "convert glass 56e6 type 4 group particles";
  s.coeff = "connective material cohesive 60e6 10 0.1 " + law +
      " contact 1.0 0.0\npair_coeff 3 4 contact 1.0 0.0";
  s.add("glass", 1, {16, 5, 2}, 2e-3, [](const Vec3 &X) {
    return Vec3(X + Vec3(16e-3, 5e-3, 2e-3));
  });
  s.more = "create_atoms 3 single 0.0173 0.01401 0.0021\nset type 3 diameter 0.008 density 7800\n"
           "group ball type 3\nfix move3 ball nve/sphere\nvelocity ball set 3 " +
      number(-v) + " 1\n";
  return s;
}

/// Mean velocity of all atoms of this type.
inline Vec3 velocity_of(const Particles &all, int type)
{
  Vec3 p = Vec3::Zero();
  double m = 0.0;
  for (const auto &one : all)
    if (one.second.type == type) {
      p += one.second.mass * one.second.v;
      m += one.second.mass;
    }
  return p / m;
}

/// What a frictionless flight conserves, and how hard the bodies met.
struct Flight {
  double energy0 = 0.0;      // total energy at the start
  double deviation = 0.0;    // largest of the total energy, by energy0
  double contact = 0.0;      // largest energy of contact, by energy0
  double momentum = 0.0;     // change by the sum of the m v
  double angular = 0.0;      // change by the sum of the |m (x - c) x v|
  double left = 0.0;         // energy of contact at the end, by energy0
  double through = 0.0;      // entry 29
  Particles start, end;
  std::vector<double> total;
};

/// Sum of the sizes of momenta of bodies: what a change is compared with.
inline double momentum_size(const Particles &all)
{
  double sum = 0.0;
  for (const auto &p : all) sum += p.second.mass * p.second.v.norm();
  return sum;
}

inline Flight fly(Lammps &lmp, int steps, int every = 1)
{
  Flight f;
  lmp.run(0);
  f.start = lmp.particles();
  f.energy0 = lmp.fe(TOTAL);
  EXPECT_EQ(lmp.fe(E_CONTACT), 0.0) << "they touch already";
  lmp.record({"f_fe[22]", "f_fe[13]"}, every);
  lmp.run(steps);
  f.end = lmp.particles();
  f.total = lmp.recorded(0);
  const auto contact = lmp.recorded(1);
  f.deviation = largest_deviation(f.total) / f.energy0;
  f.contact = *std::max_element(contact.begin(), contact.end()) / f.energy0;
  f.left = lmp.fe(E_CONTACT) / f.energy0;
  const double scale = momentum_size(f.start);
  f.momentum = (momentum(f.end) - momentum(f.start)).norm() / scale;
  const Vec3 c = centre_of_mass(f.start);
  double reach = 0.0;
  for (const auto &p : f.start) reach = std::max(reach, (p.second.x - c).norm());
  f.angular = (angular_momentum(f.end, c) - angular_momentum(f.start, c)).norm() / (scale * reach);
  f.through = lmp.value("f_fe[29]");
  return f;
}

/// What a log file holds after WARNING:, of the commands from the construction on.
class WarningLog {
 public:
  WarningLog(Lammps &lmp, const std::string &name) : lmp(lmp), file(name)
  {
    lmp.command("log " + file);
  }
  std::vector<std::string> warnings()
  {
    lmp.command("log none");
    MPI_Barrier(MPI_COMM_WORLD);
    std::vector<std::string> found;
    std::ifstream in(file);
    EXPECT_TRUE(in.good()) << file;
    for (std::string line; std::getline(in, line);)
      if (line.compare(0, 9, "WARNING: ") == 0) found.push_back(line.substr(9));
    MPI_Barrier(MPI_COMM_WORLD);
    return found;
  }

 private:
  Lammps &lmp;
  std::string file;
};

}    // namespace defe::test

#endif
