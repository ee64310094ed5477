// Wrong input ends with one line that names the cause and the remedy.
//
// Two tables: mistakes that all ranks find, and mistakes that one rank finds (LAMMPS then ends the
// others, so that these run on rank 0 alone). A row is a name, an input script, and words that must
// be in the message.
//
// ranks: 1 2 4
// timeout: 240

#include "failure.h"
#include "glass_block.h"
#include "mesh_file.h"

#include "comm.h"

#include <gmock/gmock.h>

#include <fstream>

using namespace defe::test;
using defe::Vec3;
using testing::AllOf;
using testing::HasSubstr;

namespace {

std::string replaced(std::string text, const std::string &what, const std::string &by)
{
  const auto at = text.find(what);
  if (at == std::string::npos) throw std::runtime_error("'" + what + "' is not in the script");
  return text.replace(at, what.size(), by);
}

// ---- scripts with one thing wrong ----

std::string good()
{
  return Block().script();
}

/// Another word in the good script.
std::string with(const std::string &by, const std::string &instead_of)
{
  return replaced(good(), instead_of, by) + "run 0";
}

/// More commands after the good script.
std::string then(const std::string &commands)
{
  return good() + commands;
}

/// Other options of fix defe, whose material glass and `convert glass` are there.
std::string option(const std::string &options)
{
  Block block;
  block.options = options;
  return block.script() + "run 0";
}

/// Other numbers of material glass.
std::string glass(const std::string &constants)
{
  return replaced(good(), "elastic " + number(Block().E) + " " + number(Block().nu) + " 2500",
                  "elastic " + constants);
}

/// What follows `convert glass`.
std::string convert(const std::string &rest)
{
  Block block;
  block.convert = rest;
  return block.script();
}

/// The arguments of pair_coeff.
std::string coeff(const std::string &rest)
{
  return with("pair_coeff " + rest, "pair_coeff 2 2 " + Block().coeff);
}

/// create_hexes in a box with a fix defe.
std::string hexes(const std::string &arguments)
{
  return Block().header() + Block().box() + Block().fix() + "create_hexes " + arguments + "\nrun 0";
}

/// Two cubes of glass in a data file, with one text replaced by another.
struct DataFile {
  std::string text;

  DataFile() : text(good()) {}
  DataFile(const std::string &what, const std::string &by) : text(replaced(good(), what, by)) {}

  static std::string good()
  {
    MeshFile mesh;
    mesh.add_block("glass", 1, 2, 1, 1, 2e-3, [](const Vec3 &X) {
      return X;
    });
    const std::string file = "good." + std::to_string(rank_of(MPI_COMM_WORLD)) + ".data";
    mesh.write(file, MPI_COMM_SELF);
    std::ifstream in(file);
    std::ostringstream all;
    all << in.rdbuf();
    return all.str();
  }
};

const char *const ELEMENT_1 = "1 glass 1 2 5 4 7 8 11 10\n";
const char *const ELEMENT_2 = "2 glass 2 3 6 5 8 9 12 11\n";

struct Mistake {
  const char *name;
  std::string script;
  std::vector<std::string> words;
  std::string file = "";    // contents of wrong.data
};

void PrintTo(const Mistake &m, std::ostream *os)
{
  *os << m.name;
}

std::string name_of(const testing::TestParamInfo<Mistake> &info)
{
  return info.param.name;
}

/// The script that reads wrong.data.
std::string reading(const std::string &boundary = "f f f")
{
  Block block;
  block.boundary = boundary;
  return block.header() + block.box() + block.fix() + read_mesh("wrong.data") + block.motion() +
      "run 0";
}

Mistake data(const char *name, const std::string &what, const std::string &by,
             std::vector<std::string> words)
{
  return {name, reading(), std::move(words), DataFile(what, by).text};
}

/// The file ends before this text.
Mistake cut(const char *name, const std::string &before, std::vector<std::string> words)
{
  const auto text = DataFile().text;
  return {name, reading(), std::move(words), text.substr(0, text.find(before))};
}

void check(const Mistake &m, MPI_Comm comm)
{
  if (!m.file.empty()) {
    if (rank_of(comm) == 0) std::ofstream("wrong.data") << m.file;
    MPI_Barrier(comm);
  }
  const auto message = failure(m.script, comm);
  EXPECT_FALSE(message.empty()) << "the mistake was not noticed";
  for (const auto &word : m.words) EXPECT_THAT(message, HasSubstr(word));
  if (std::getenv("DEFE_TEST_MESSAGES") && rank_of(MPI_COMM_WORLD) == 0)
    std::printf("%-28s %s\n", m.name, message.c_str());
}

// ---- found by all ranks ----

std::vector<Mistake> of_all_ranks()
{
  const std::string pair = "pair_style defe/joint\npair_coeff 2 2 " + Block().coeff;
  const std::string fix = Block().fix_only();
  const std::string mesh = Block().mesh();
  const std::string motion = Block().motion();
  const std::string front = Block().header() + Block().box();

  return {
      // settings of LAMMPS
      {"newton_off", with("newton off", "newton off on"), {"'newton off on'"}},
      {"no_ghost_velocities", with("", "comm_modify vel yes"), {"comm_modify vel yes"}},
      {"atom_style_atomic", with("atom_style atomic", "atom_style sphere"), {"atom_style sphere"}},
      {"units_real", with("units real", "units si"), {"consistent units", "si", "not real"}},
      {"units_metal", with("units metal", "units si"), {"consistent units", "not metal"}},
      {"units_electron", with("units electron", "units si"), {"consistent units"}},
      {"triclinic_box",
       replaced(with("region box prism", "region box block"), "\ncreate_box", " 0 0 0\ncreate_box"),
       {"triclinic"}},
      {"two_dimensions",
       with("dimension 2\nboundary f f p", "boundary f f f"),
       {"three-dimensional"}},
      {"respa", then("run_style respa 2 2\nrun 0"), {"run_style respa"}},
      {"neigh_modify_include",
       then("atom_modify first nodes\nneigh_modify include nodes\nrun 0"),
       {"neigh_modify include"}},
      // 2 mm cubes of glass: 2.2e-7 s
      {"time_step", then("timestep 1e-6\nrun 0"), {"Time step 1e-06 is above the stable", "e-07"}},
      {"time_step_later",
       then("run 1\ntimestep 3e-7\nrun 1"),
       {"Time step 3e-07 is above the stable", "e-07", "timestep"}},

      // pair style
      {"no_pair_style", with("", pair), {"use pair_style defe/joint"}},
      {"other_pair_style",
       with("pair_style zero 0.002\npair_coeff * *", pair),
       {"use pair_style defe/joint"}},
      {"pair_style_arguments",
       with("pair_style defe/joint 0.001", "pair_style defe/joint"),
       {"takes no arguments", "pair_coeff"}},
      {"no_pair_coeff",
       with("pair_style defe/joint", pair),
       {"part glass", "type 2", "pair_coeff 2 2"}},
      {"pair_coeff_of_another_type",
       with("pair_coeff 1 1", "pair_coeff 2 2"),
       {"part glass", "type 2", "pair_coeff 2 2"}},
      {"pair_coeff_types_out_of_range", coeff("9 9 connective material"), {"9", "out of bounds"}},
      {"pair_coeff_types_no_range",
       coeff("1*- 2 connective material"),
       {"1*- 2 are no ranges of atom types"}},
      {"pair_coeff_between_types_only",
       coeff("1 2 " + Block().coeff),
       {"part glass", "pair_coeff 2 2"}},
      {"pair_coeff_too_short", coeff("2 2"), {"pair_coeff", "missing argument"}},
      {"pair_coeff_incomplete",
       coeff("2 2 connective material"),
       {"pair_coeff 2 2", "cohesive", "contact"}},
      {"pair_coeff_unknown_word",
       coeff("2 2 glue 1e6"),
       {"Unknown pair_coeff keyword glue", "connective"}},
      {"connective_other_material",
       with("connective 70e9 0.2", "connective material"),
       {"differs from material glass", "connective material"}},
      {"connective_nu_too_large",
       with("connective 74.09e9 0.7", "connective material"),
       {"nu must be between -1 and 0.5", "0.7"}},
      {"connective_nu_one_half",
       with("connective 74.09e9 0.5", "connective material"),
       {"nu must be between -1 and 0.5", "0.5"}},
      {"connective_nu_minus_one",
       with("connective 74.09e9 -1", "connective material"),
       {"nu must be between"}},
      {"connective_E_negative",
       with("connective -74e9 0.2", "connective material"),
       {"E must be > 0"}},
      {"connective_E_nan", with("connective nan 0.2", "connective material"), {"'nan'"}},
      {"connective_nu_missing",
       coeff("2 2 connective 74e9"),
       {"pair_coeff connective E nu", "missing argument"}},
      {"cohesive_strength_zero", with("cohesive 0", "cohesive 1e12"), {"sigma_t", "> 0"}},
      {"cohesive_energy_negative",
       with("cohesive 60e6 -10 0.1", "cohesive 1e12 1e6 0.1"),
       {"G_f must be > 0"}},
      {"cohesive_beta_negative",
       with("cohesive 60e6 10 -0.1", "cohesive 1e12 1e6 0.1"),
       {"beta >= 0"}},
      {"cohesive_beta_zero_reciprocal",
       with("cohesive 60e6 10 0 reciprocal", "cohesive 1e12 1e6 0.1"),
       {"beta must be > 0 with reciprocal"}},
      {"cohesive_overstrength_below_one",
       with("cohesive 1e12 1e6 0.1 overstrength 0.9", "cohesive 1e12 1e6 0.1"),
       {"overstrength", "from 1 to 100, not 0.9"}},
      {"cohesive_overstrength_missing",
       coeff("2 2 connective material contact 0.9 0.2 cohesive 60e6 10 0.1 overstrength"),
       {"cohesive overstrength", "missing argument"}},
      {"cohesive_scatter_negative",
       with("cohesive 1e12 1e6 0.1 scatter -0.1", "cohesive 1e12 1e6 0.1"),
       {"scatter", "from 0 to 1, not -0.1"}},
      {"cohesive_scatter_nan",
       with("cohesive 1e12 1e6 0.1 scatter nan", "cohesive 1e12 1e6 0.1"),
       {"'nan'"}},
      {"cohesive_scatter_lattice",
       with("cohesive 1e12 1e6 0.1 scatter 0.1 lattice", "cohesive 1e12 1e6 0.1"),
       {"lattice", "leave scatter out"}},
      {"cohesive_strength_1e400", with("cohesive 1e400", "cohesive 1e12"), {"1e400", "range"}},
      {"cohesive_beta_missing",
       coeff("2 2 connective material cohesive 60e6 10"),
       {"cohesive sigma_t G_f beta", "missing argument"}},
      {"restitution_above_one", with("contact 1.9", "contact 0.9"), {"restitution", "1.9"}},
      {"restitution_zero", with("contact 0", "contact 0.9"), {"restitution must be in (0, 1]"}},
      {"friction_negative",
       with("contact 0.9 -0.2", "contact 0.9 0.2"),
       {"friction must be >= 0", "-0.2"}},
      {"contact_law_unknown",
       with("contact 0.9 0.2 hertzian", "contact 0.9 0.2"),
       {"Unknown pair_coeff keyword hertzian", "or after its numbers linear or hertz"}},
      {"joint_law_unknown",
       with("1e12 1e6 0.1 lattices", "1e12 1e6 0.1"),
       {"Unknown pair_coeff keyword lattices", "or after its numbers reciprocal",
        "linear or exponential, rings or lattice"}},
      {"style_without_connective",
       with("defe/contact", "defe/joint"),
       {"connective", "this pair style has no connective joints"}},
      {"no_coeff_between_parts",
       front + "region r block 0 0.001 0 0.001 0 0.001\npair_style defe/joint\npair_coeff 1 1 " +
           Block().coeff + "\npair_coeff 2 2 " + Block().coeff +
           "\nfix fe all defe material a elastic 1e9 0.2 1000 material b elastic 1e9 0.2 1000 "
           "convert a 1e6 type 1 convert b 1e6 type 2\ncreate_hexes fe a 1 x 0 1 0.001 y 0 1 0.001 "
           "z 0 1 0.001\nfix 1 all nve\nrun 0",
       {"parts a and b", "pair_coeff 1 2"}},
      {"pair_style_without_fix",
       front +
           "pair_style defe/joint\npair_coeff 2 2 connective 1e9 0.2 cohesive 1 1 0.1 contact "
           "0.9 0.1\nrun 0",
       {"fix defe", "define one"}},
      {"pair_style_twice",
       with("pair_style hybrid defe/joint defe/contact\npair_coeff * * defe/joint " +
                Block().coeff + "\npair_coeff 1 1 defe/contact contact 0.9 0.1",
            pair),
       {"only one pair style defe"}},
      {"hybrid_gives_des_to_another_style",
       with("pair_style hybrid defe/joint gran/hooke 1e6 NULL 0 NULL 0 0\npair_coeff * * gran/hooke"
            "\npair_coeff 1 1 defe/joint " +
                Block().coeff,
            pair),
       {"DEs of part glass have type 2", "pair_style hybrid", "pair_coeff 2 2 defe/joint"}},
      {"hybrid_without_coefficients",
       with("pair_style hybrid defe/joint gran/hooke 1e6 NULL 0 NULL 0 0\npair_coeff 1 * "
            "gran/hooke\npair_coeff 2 2 defe/joint connective material",
            pair),
       {"DEs of part glass have type 2", "pair_coeff 2 2 defe/joint", "cohesive contact"}},
      {"bonds_after_the_fix",
       replaced(replaced(good(), "atom_style sphere\nnewton off on",
                         "atom_style hybrid bond sphere\nnewton on off\n"
                         "special_bonds lj 0 1 1 coul 1 1 1"),
                "create_box 2 box", "create_box 2 box bond/types 1 extra/bond/per/atom 2") +
           "bond_style bpm/spring\nbond_coeff 1 1 1 1\nrun 0",
       {"Bond_style bpm/spring", "before fix fe"}},
      {"breaking_bonds_beside_contact_history",
       replaced(replaced(replaced(good(), "atom_style sphere\nnewton off on",
                                  "atom_style hybrid bond sphere\nnewton on off\n"
                                  "special_bonds lj 0 1 1 coul 1 1 1"),
                         "create_box 2 box",
                         "create_box 2 box bond/types 1 extra/bond/per/atom 2\n"
                         "bond_style bpm/spring\nbond_coeff 1 1 1 1"),
                pair,
                "pair_style hybrid defe/joint gran/hooke/history 1e6 NULL 0 NULL 0 0\n"
                "pair_coeff 1 * gran/hooke/history\npair_coeff 2 2 defe/joint " +
                    Block().coeff) +
           "run 0",
       {"Bond_style bpm/spring", "contact histories", "without history"}},

      // fix defe
      {"fix_without_arguments", front + "fix fe all defe", {"fix defe", "missing argument"}},
      {"fix_without_material", front + "fix fe all defe contact 0.1", {"at least one material"}},
      {"fix_before_box",
       Block().header() + "fix fe all defe material glass elastic 1e9 0.2 1000",
       {"before simulation box"}},
      {"unknown_keyword", option("colour blue"), {"Unknown fix defe keyword colour", "material"}},
      {"two_fixes",
       then("fix fe2 all defe material glass elastic 1e9 0.2 1000\nrun 0"),
       {"Only one fix defe", "any number of parts"}},
      {"E_zero", glass("0 0.2 2500"), {"material glass", "Young's modulus must be positive"}},
      {"E_negative", glass("-74e9 0.2 2500"), {"material glass", "Young's modulus", "-7.4e+10"}},
      {"E_nan", glass("nan 0.2 2500"), {"Young's modulus E must be a number, not nan"}},
      {"E_inf", glass("inf 0.2 2500"), {"Young's modulus E must be a number, not inf"}},
      {"E_1e400", glass("1e400 0.2 2500"), {"must be a number, not 1e400"}},
      {"nu_one_half", glass("74e9 0.5 2500"), {"material glass", "Poisson's ratio", "0.5"}},
      {"nu_minus_one", glass("74e9 -1 2500"), {"Poisson's ratio must lie between -1 and 0.5"}},
      {"nu_and_E_exchanged", glass("0.2 74e9 2500"), {"Poisson's ratio", "7.4e+10"}},
      {"density_zero", glass("74e9 0.2 0"), {"material glass", "density must be positive"}},
      {"density_negative", glass("74e9 0.2 -2500"), {"density must be positive, not -2500"}},
      {"density_word", glass("74e9 0.2 heavy"), {"density rho must be a number, not heavy"}},
      {"density_missing",
       front + "fix fe all defe material glass elastic 74e9 0.2",
       {"material glass", "density rho is missing", "use elastic E nu rho"}},
      {"rigid_density_zero",
       option("material ram rigid 0"),
       {"material ram", "density must be positive, not 0"}},
      {"unknown_law",
       option("material wood orthotropic 1e9"),
       {"material wood", "law orthotropic",
        "elastic, mooney, prony, plastic, johnson-cook or rigid"}},
      {"plastic_yield_missing",
       option("material steel plastic 210e9 0.3 7800"),
       {"material steel", "sigma_y is missing", "plastic E nu rho sigma_y H"}},
      {"plastic_converts",
       option("material steel plastic 210e9 0.3 7800 400e6 1e9 convert steel 1e6 type 2"),
       {"part steel cannot convert", "elastic"}},
      {"mooney_negative", option("material pvb mooney -1e6 0 1e9 1100"), {"material pvb", "C10"}},
      {"prony_term_missing",
       option("material pvb prony 2e10 1100 6.9e5 2 3.3e8 12.6"),
       {"material pvb", "missing", "prony K rho G_inf N"}},
      {"interlayer_converts",
       option("material pvb mooney 1.6e6 6e4 1e9 1100 convert pvb 1e6 type 2"),
       {"part pvb cannot convert", "elastic"}},
      {"every_zero", option("every 0"), {"every must be at least 1"}},
      {"collect_zero", option("collect 0"), {"collect must be auto or at least 1"}},
      {"every_too_large",
       option("every 6") + "\nrun 0",
       {"times every 6", "smaller timestep or every"}},
      {"check_word", option("check perhaps"), {"perhaps"}},
      {"material_twice", option("material glass rigid 1"), {"material glass is defined twice"}},
      {"part_twice", option("part a glass part a glass"), {"part a is defined twice"}},
      {"part_named_as_material", option("part glass glass"), {"part glass is defined twice"}},
      {"part_of_unknown_material", option("part panel wood"), {"panel", "unknown material wood"}},
      {"convert_unknown_part", option("convert wood 1 type 2"), {"unknown part wood"}},
      {"convert_rigid_part",
       option("material ball rigid 7800 convert ball 1e6 type 2"),
       {"ball is rigid"}},
      {"convert_without_type", convert("1e12 group particles"), {"convert glass", "type N"}},
      {"convert_type_too_large",
       convert("1e12 type 3 group particles"),
       {"atom type 3 does not exist (1 to 2)"}},
      {"convert_type_zero", convert("1e12 type 0"), {"atom type 0 does not exist (1 to 2)"}},
      {"convert_type_word", convert("1e12 type glass"), {"'glass'"}},
      {"convert_group_missing",
       convert("1e12 type 2 group pieces"),
       {"group pieces does not exist", "group pieces empty"}},
      {"convert_start_unknown",
       convert("1e12 type 2 start nowhere"),
       {"start must be no, all or a region", "nowhere"}},
      {"convert_stress_negative", convert("-5 type 2"), {"conversion stress must be > 0"}},
      {"convert_stress_zero", convert("0 type 2"), {"conversion stress must be > 0"}},
      {"convert_stress_nan", convert("nan type 2"), {"must be a number, not nan"}},
      {"convert_stress_missing", front + fix.substr(0, fix.find(" 1e12")), {"convert", "missing"}},
      {"kernel_unknown", option("kernel fast"), {"kernel must be auto or lagrangian", "fast"}},
      {"stress_unknown", option("stress mean"), {"stress must be centre or gauss", "mean"}},
      {"shield_unknown", option("shield maybe"), {"maybe", "boolean"}},
      {"contact_without_factor", option("contact"), {"contact", "missing argument"}},
      {"contact_negative", option("contact -0.1"), {"contact factor must be >= 0"}},
      {"contact_friction_negative", option("contact 0.1 friction -1"), {"friction must be >= 0"}},
      {"contact_friction_missing",
       option("contact 0.1 friction"),
       {"friction", "missing argument"}},
      {"events_without_file", option("events"), {"events", "missing argument"}},

      // order of commands
      {"mesh_before_fix", with(mesh + fix, fix + mesh), {"fe is not the ID of a fix defe"}},
      {"mesh_before_box",
       Block().header() + "create_hexes fe glass 1 x 0 1 1 y 0 1 1 z 0 1 1",
       {"create_hexes", "after create_box or read_data"}},
      {"mesh_after_conversions",
       convert("1e12 type 2 group particles start all") + "run 1\n" + mesh,
       {"before elements convert"}},
      {"fix_balance_first",
       with("fix lb all balance 100 1.0 shift xyz 5 1.1\n" + fix, fix),
       {"Fix lb balance", "after fix fe"}},
      {"fix_setforce_first",
       with("fix hold all setforce 0 0 0\n" + fix, fix),
       {"Fix hold setforce", "after fix fe"}},

      {"fix_deleted", then("unfix fe\nrun 0"), {"joins the DEs of a fix defe", "define one"}},
      {"start_region_deleted",
       front + "region r block 0 0.002 INF INF INF INF\ngroup particles empty\n" + pair + "\n" +
           replaced(fix, "group particles", "group particles start r") + mesh + motion +
           "region r delete\nrun 0",
       {"convert glass", "start region r does not exist"}},

      {"des_moved_by_no_fix",
       then("unfix move2\nrun 1"),
       {"DEs of part glass (group particles)", "moved by no fix", "fix ID particles nve/sphere"}},
      {"des_moved_twice",
       then("fix again particles nve/sphere\nrun 1"),
       {"DEs of part glass", "fix move2 and fix again"}},

      // create_hexes
      {"hexes_few_words", hexes("fe"), {"create_hexes", "missing argument"}},
      {"hexes_unknown_part", hexes("fe wood 1 x 0 1 1 y 0 1 1 z 0 1 1"), {"no part wood"}},
      {"hexes_unknown_fix",
       hexes("fx glass 1 x 0 1 1 y 0 1 1 z 0 1 1"),
       {"fx is not the ID of a fix defe"}},
      {"hexes_type",
       hexes("fe glass 7 x 0 1 1 y 0 1 1 z 0 1 1"),
       {"atom type 7 does not exist (1 to 2)"}},
      {"hexes_down",
       hexes("fe glass 1 x 0 1 0.001 y 0.01 1 0.002 z 0 1 0.001"),
       {"create_hexes y", "from 0.01 to 0.002 must go up"}},
      {"hexes_none", hexes("fe glass 1 x 0 0 0.001 y 0 1 0.001 z 0 1 0.001"), {"x: 0 elements"}},
      {"hexes_half_an_element",
       hexes("fe glass 1 x 0 1.5 0.001 y 0 1 0.001 z 0 1 0.001"),
       {"create_hexes x", "N an integer"}},
      {"hexes_axis_missing", hexes("fe glass 1 x 0 1 0.001 z 0 1 0.001"), {"expected 'y START"}},
      {"hexes_word_too_many",
       hexes("fe glass 1 x 0 1 0.001 y 0 1 0.001 z 0 1 0.001 w"),
       {"unknown word w"}},
      {"hexes_nan", hexes("fe glass 1 x 0 1 nan y 0 1 0.001 z 0 1 0.001"), {"'nan'"}},
      {"hexes_up_to_the_wall",
       hexes("fe glass 1 x 0 1 0.03 y 0 1 0.001 z 0 1 0.001"),
       {"from 0 to 0.03 in x", "outside the box (-0.02 to below 0.03)"}},
      {"hexes_outside_box",
       hexes("fe glass 1 x 0 1 0.001 y 0 1 0.001 z 0.04 1 0.041"),
       {"from 0.04 to 0.041 in z", "outside the box (-0.02 to below 0.03)"}},
      {"hexes_longer_than_periodic_box",
       replaced(hexes("fe glass 1 x 0 60 0.06 y 0 1 0.001 z 0 1 0.001"), "boundary f f f",
                "boundary p p p"),
       {"from 0 to 0.06 in x", "periodic box (0.05)", "overlap"}},
      {"hexes_closed_without_axes",
       hexes("fe glass 1 x 0 5 0.05 y 0 1 0.001 z 0 1 0.001 closed"),
       {"create_hexes closed", "missing argument"}},
      {"hexes_closed_which_axes",
       replaced(hexes("fe glass 1 x -0.02 5 0.03 y 0 1 0.001 z 0 1 0.001 closed xx"),
                "boundary f f f", "boundary p p p"),
       {"expected axes", "xx"}},
      {"hexes_closed_at_a_wall",
       hexes("fe glass 1 x -0.02 5 0.029 y 0 1 0.001 z 0 1 0.001 closed x"),
       {"not periodic in x", "boundary p"}},
      {"hexes_closed_too_short",
       replaced(hexes("fe glass 1 x -0.02 5 0.029 y 0 1 0.001 z 0 1 0.001 closed x"),
                "boundary f f f", "boundary p p p"),
       {"is 0.049 long in x", "periodic box 0.05"}},
      {"hexes_closed_by_three_elements",
       replaced(hexes("fe glass 1 x -0.02 3 0.03 y 0 1 0.01 z 0 1 0.01 closed x"), "boundary f f f",
                "boundary p p p"),
       {"in x is longer than a quarter of the box"}},
      {"hexes_too_many",
       hexes("fe glass 1 x 0 2000000000 0.01 y 0 1 0.01 z 0 1 0.01"),
       {"too many nodes for the atom IDs"}},

      // computes
      {"compute_atom_unknown",
       then("compute 1 all defe/atom colour"),
       {"Unknown compute defe/atom quantity colour", "damage"}},
      {"compute_atom_nothing", then("compute 1 all defe/atom"), {"defe/atom", "missing argument"}},
      {"compute_hex_unknown",
       then("compute 1 all defe/hex/local colour"),
       {"Unknown compute defe/hex/local quantity colour", "sxx"}},
      {"compute_hex_nothing", then("compute 1 all defe/hex/local"), {"hex/local", "missing"}},
      {"compute_fragment_unknown",
       then("compute 1 all defe/fragment/atom single yes"),
       {"Unknown compute defe/fragment/atom keyword single", "use part"}},
      {"compute_fragment_nothing",
       then("compute 1 all defe/fragment/atom part"),
       {"defe/fragment/atom part", "missing argument"}},
      {"compute_fragment_part",
       then("compute 1 all defe/fragment/atom part wood\nrun 0"),
       {"part wood: fix fe has no part of this name"}},
      {"compute_joint_unknown",
       then("compute 1 all defe/joint/local colour"),
       {"Unknown compute defe/joint/local quantity colour", "length0"}},
      {"compute_joint_nothing", then("compute 1 all defe/joint/local"), {"joint/local", "missing"}},
      {"compute_joint_without_pair",
       then("pair_style zero 0.001\npair_coeff * *\ncompute 1 all defe/joint/local tn\nrun 0"),
       {"Compute defe/joint/local needs a pair style defe/*"}},
      {"compute_without_fix",
       front + "compute 1 all defe/atom damage\nrun 0",
       {"Compute defe/atom needs a fix defe"}},

      // data file
      data("data_nan", "4 1 0 1 0 ", "4 1 0 1 nan ", {"'nan'"}),
      data("data_1e400", "4 1 0 1 0 ", "4 1 0 1 1e400 ", {"1e400"}),
      data("data_header_word", "2 hexes", "two hexes", {"'two hexes'", "N hexes"}),
      data("data_header_negative", "2 hexes", "-2 hexes", {"negative number of hexes", "-2"}),
      data("data_header_too_large", "2 hexes", "3 hexes", {"Unexpected end of data file"}),
      // (one line too many at the end of the file is one that LAMMPS' read_data does not look at)
      data("data_header_too_small", "2 hexes", "0 hexes", {"1 glass"}),
      data("data_header_missing", "2 hexes", "", {"1 glass"}),
      data("data_unknown_part", "2 glass", "2 wood", {"'2 wood", "unknown part: 'wood'"}),
      data("data_part_number", "2 glass", "2 2", {"'2 2 ", "unknown part: '2'"}),
      data("data_part_number_huge", "2 glass", "2 99999999999", {"unknown part: '99999999999'"}),
      data("data_element_id_zero", "2 glass", "0 glass", {"'0 glass", "ID must be > 0"}),
      data("data_element_id_word", "2 glass", "b glass", {"'b glass", "ID part and 8 node IDs"}),
      data("data_seven_nodes", ELEMENT_2, "2 glass 2 3 6 5 8 9 12\n", {"8 node IDs"}),
      data("data_nine_nodes", ELEMENT_2, "2 glass 2 3 6 5 8 9 12 11 10\n", {"too many items"}),
      data("data_node_zero", ELEMENT_2, "2 glass 2 3 0 5 8 9 12 11\n", {"'0'", "no node can"}),
      data("data_node_negative", ELEMENT_2, "2 glass 2 3 6 -5 8 9 12 11\n", {"'-5'"}),
      data("data_node_word", ELEMENT_2, "2 glass 2 3 six 5 8 9 12 11\n", {"six"}),
      data("data_first_node_missing", ELEMENT_2, "2 glass 99 3 6 5 8 9 12 11\n",
           {"'2 glass 99", "first node does not exist"}),
      data("data_first_node_far", ELEMENT_2, "2 glass 2000000000 3 6 5 8 9 12 11\n",
           {"first node does not exist"}),
      cut("data_cut_in_line", "9 12 11\n", {"8 node IDs"}),
      cut("data_cut_in_hexes", ELEMENT_2, {"Unexpected end of data file"}),
      cut("data_cut_before_hexes", "Hexes", {"announced 2 hexes", "was the file cut"}),
      cut("data_cut_in_atoms", "\nHexes", {"announced 2 hexes"}),
      data("data_node_id_twice", "\n12 1 0 1 ", "\n5 1 0 1 ", {"Duplicate atom IDs"}),
      {"data_without_fix",
       replaced(reading(), " fix fe hexes Hexes", ""),
       {"data file", "hexes"},
       DataFile().text},
  };
}

// ---- found by one rank ----

std::string two_cubes(const std::function<void(MeshFile &)> &spoil)
{
  MeshFile mesh;
  mesh.add_block("glass", 1, 2, 1, 1, 2e-3, [](const Vec3 &X) {
    return X;
  });
  spoil(mesh);
  const std::string file = "spoilt." + std::to_string(rank_of(MPI_COMM_WORLD)) + ".data";
  mesh.write(file, MPI_COMM_SELF);
  std::ifstream in(file);
  std::ostringstream all;
  all << in.rdbuf();
  return all.str();
}

std::vector<Mistake> of_one_rank()
{
  const auto mesh = [](const char *name, const std::function<void(MeshFile &)> &spoil,
                       std::vector<std::string> words) {
    return Mistake{name, reading(), std::move(words), two_cubes(spoil)};
  };
  const auto with_second = [&mesh](const char *name, const std::array<tagint, 8> &nodes,
                                   std::vector<std::string> words) {
    return mesh(
        name,
        [&](MeshFile &m) {
          m.hex[1] = nodes;
        },
        std::move(words));
  };
  return {
      with_second("element_inverted", {8, 9, 12, 11, 2, 3, 6, 5},
                  {"Part glass", "hexahedron 2 is inverted", "(0.002 0 0.002)"}),
      with_second("element_nodes_in_wrong_order", {2, 3, 5, 6, 8, 9, 11, 12},
                  {"Part glass", "hexahedron 2"}),
      mesh("element_flat",
           [](MeshFile &m) {
             for (auto &X : m.X) X[2] *= 1e-9;
           },
           {"Part glass", "hexahedron 1 is flat"}),
      with_second("element_node_twice", {2, 3, 6, 6, 8, 9, 12, 11},
                  {"Element 2 of part glass has node 6 twice", "wedges"}),
      with_second("element_node_missing", {2, 3, 6, 5, 8, 9, 12, 99},
                  {"Element 2 of part glass", "node 99 (number 8 of 8) does not exist"}),
      with_second("element_node_missing_far_id", {2, 3, 6, 5, 8, 9, 12, 2000000000},
                  {"node 2000000000", "does not exist"}),
      mesh("element_id_twice",
           [](MeshFile &m) {
             m.hex.push_back(m.hex[0]);
             m.part.push_back("glass");
             m.ids = {1, 2, 2};
           },
           {"Element ID 2 is used twice", "unique"}),
      mesh("elements_on_one_another",
           [](MeshFile &m) {
             m.hex.push_back(m.hex[1]);
             m.part.push_back("glass");
           },
           {"Elements", "share"}),
      mesh("orphan_nodes",
           [](MeshFile &m) {
             m.X.push_back(Vec3(0.01, 0.01, 0.01));
             m.X.push_back(Vec3(0.01, 0.01, 0.02));
             m.type.resize(m.X.size(), 1);
           },
           {"2 atoms without a radius, the first with ID 13, belong to no element", "orphan"}),
      // folded back: each hexahedron is good by itself
      mesh("neighbours_inside_out",
           [](MeshFile &m) {
             for (int n : {2, 5, 8, 11}) m.X[n][0] = 1e-3;
             m.hex[1] = {3, 2, 5, 6, 9, 8, 11, 12};
           },
           {"Elements 1 and 2 share a face but lie on the same side"}),
      {"element_across_periodic_box",
       reading("p p p"),
       {"Element 2 of part glass is 0.0275 long in x", "half of the periodic box (0.05)",
        "image flags"},
       two_cubes([](MeshFile &m) {
         for (int n : {2, 5, 8, 11}) m.X[n][0] = 0.0295;
       })},
      {"node_with_radius",
       reading(),
       {"Node 2", "radius 0.0005", "radius 0"},
       DataFile("\n2 1 0 1 ", "\n2 1 0.001 2500 ").text},
      {"nodes_integrated_as_spheres",
       then("unfix move1\nunfix move2\nfix move all nve/sphere\nrun 0"),
       {"nve/sphere requires extended particles"}},
      {"nodes_moved_twice",
       then("fix again nodes nve\nrun 1"),
       {"Node ", "is moved by fix move1 and by fix again"}},
      {"node_leaves_box",
       then("velocity nodes set 1000 0 0\nrun 1000"),
       {"Node ", "of part glass at 0.03", "left the box through its wall in x at step"}},
      {"node_on_upper_wall",
       then("set atom 3 x 0.03\nrun 0"),
       {"Node ", "left the box through its wall in x at step 0", "make the box larger"}},
      {"nodes_too_fast",
       then("velocity nodes set 2e4 0 0\nrun 1"),
       {"Node ", "of part glass", "moves by 0.001 per step", "use a smaller timestep"}},
      {"events_unwritable", option("events no/such/folder/events.txt"), {"event file", "no/such"}},
  };
}

class MistakeOfAll : public testing::TestWithParam<Mistake> {};
class MistakeOfOne : public testing::TestWithParam<Mistake> {};

}    // namespace

TEST_P(MistakeOfAll, IsNamed)
{
  check(GetParam(), MPI_COMM_WORLD);
}
INSTANTIATE_TEST_SUITE_P(Errors, MistakeOfAll, testing::ValuesIn(of_all_ranks()), name_of);

TEST_P(MistakeOfOne, IsNamed)
{
  if (rank_of(MPI_COMM_WORLD) == 0) check(GetParam(), MPI_COMM_SELF);
  MPI_Barrier(MPI_COMM_WORLD);
}
INSTANTIATE_TEST_SUITE_P(Errors, MistakeOfOne, testing::ValuesIn(of_one_rank()), name_of);

// What the tables start from is right.
TEST(Errors, GoodInputHasNone)
{
  EXPECT_EQ(failure(good() + "run 1"), "");
  if (rank_of(MPI_COMM_WORLD) == 0) std::ofstream("wrong.data") << DataFile().text;
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_EQ(failure(reading()), "");
}

// A plugin of another LAMMPS would load with a line of notice and crash later.
TEST(Errors, PluginOfAnotherLammps)
{
  const auto load = [](const char *plugin) {
    std::string message;
    try {
      Lammps lmp(MPI_COMM_WORLD, plugin);
    } catch (LAMMPS_NS::LAMMPSException &e) {
      message = e.what();
    }
    return message;
  };
  EXPECT_EQ(load(DEFE_PLUGIN_PATH), "");
  EXPECT_THAT(load(DEFE_PLUGIN_OTHER_LAMMPS),
              AllOf(HasSubstr("was built for LAMMPS 1 Jan 2001, but is loaded by LAMMPS"),
                    HasSubstr("rebuild DEFE with -D LAMMPS_SOURCE_DIR")));
  EXPECT_THAT(load(DEFE_PLUGIN_OTHER_MPI),
              AllOf(HasSubstr("was built with Other MPI, but LAMMPS runs with"),
                    HasSubstr("rebuild DEFE with the MPI of this LAMMPS")));
}

// Too small a communication cutoff is no error: the fix knows what its elements need.
TEST(Errors, GhostCutoffIsRaised)
{
  Lammps lmp;
  lmp.commands(good() + "comm_modify cutoff 1e-4\nrun 1");
  EXPECT_GE(lmp->comm->cutghostuser, std::sqrt(3.0) * Block().h);
}

// An element that is squeezed inside out during a run is named.
TEST(Errors, ElementTurnsInsideOut)
{
  if (rank_of(MPI_COMM_WORLD) == 0) {
    for (const char *kernel : {"kernel auto", "kernel lagrangian"}) {
      Block block;
      block.n[0] = block.n[1] = block.n[2] = 1;
      block.options = kernel;
      block.convert = "1e15 type 2 group particles";
      EXPECT_THAT(
          failure(block.script() +
                      "velocity nodes set 0 0 -8e3\nregion low block INF INF INF "
                      "INF INF 0.001\ngroup low region low\nvelocity low set 0 0 8e3\nrun 100",
                  MPI_COMM_SELF),
          AllOf(HasSubstr("Element 1 of part glass turned inside out at step"),
                HasSubstr("timestep")))
          << kernel;
    }
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

TEST(Errors, RestartWithOtherParts)
{
  Block block;
  {
    Lammps lmp;
    lmp.commands(block.script() + "run 1\nwrite_restart parts.restart");
  }
  EXPECT_THAT(failure(block.header() + "read_restart parts.restart\n" + block.fix_only()), "");
  block.options = "part second glass";
  EXPECT_THAT(failure(block.header() + "read_restart parts.restart\n" + block.fix_only()),
              HasSubstr("1 parts"));
}
