/* -*- c++ -*- ----------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifdef FIX_CLASS
// clang-format off
FixStyle(defe,FixDefe);
// clang-format on
#else

#ifndef LMP_FIX_DEFE_H
#define LMP_FIX_DEFE_H

#include "fix.h"

#include "defe_joint_table.h"
#include "defe_records.h"

#include "defe/coupling/cohesive.h"
#include "defe/coupling/conversion_plan.h"
#include "defe/coupling/corner_strain.h"
#include "defe/coupling/criterion.h"
#include "defe/coupling/event_log.h"
#include "defe/coupling/ledger.h"
#include "defe/coupling/subcycle.h"
#include "defe/exact_sum.h"
#include "defe/fe/kernel.h"
#include "defe/fe/material_law.h"

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

namespace LAMMPS_NS {

class FixDefe : public Fix {
 public:
  FixDefe(class LAMMPS *, int, char **);
  ~FixDefe() override;
  int setmask() override;
  void init() override;
  void setup_pre_exchange() override;
  void setup_pre_neighbor() override { pre_neighbor(); }
  void setup_pre_reverse(int, int) override;
  void setup(int) override;
  void min_pre_neighbor() override { pre_neighbor(); }
  void min_pre_reverse(int eflag, int vflag) override { pre_reverse(eflag, vflag); }
  void initial_integrate(int) override;
  void post_integrate() override;
  void pre_exchange() override;
  void min_pre_exchange() override;
  void pre_neighbor() override;
  void pre_reverse(int, int) override;
  void post_force(int) override;
  void end_of_step() override;
  void reset_dt() override;
  void post_run() override;

  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override;
  int maxsize_restart() override;
  void write_restart(FILE *) override;
  void write_restart_file(const char *) override;
  void restart(char *) override;

  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;
  int pack_reverse_comm(int, int, double *) override;
  void unpack_reverse_comm(int, int *, double *) override;

  void read_data_header(char *) override;
  void read_data_section(char *, int, char *, tagint) override;
  bigint read_data_skip_lines(char *) override;
  void write_data_header(FILE *, int) override;
  void write_data_section_size(int, int &, int &) override;
  void write_data_section_pack(int, double **) override;
  void write_data_section_keyword(int, FILE *) override;
  void write_data_section(int, FILE *, int, double **, int) override;

  double compute_scalar() override;
  double compute_vector(int) override;
  int image(int *&, double **&) override;
  void *extract(const char *, int &) override;
  double memory_usage() override;

  /** The forces on an atom at the end of a run, for a next one that goes on from there. */
  struct KeptForces {
    double x[3];    // unwrapped
    double f[3], torque[3];
    uint64_t motion = 0;    // checksum of velocity, spin, radius, mass and type
  };

  // ---- what the command create_hexes, the pair styles and the computes use ----

  struct Material {
    std::string name;
    std::string words;    // law and constants, as given
    std::shared_ptr<const defe::fe::MaterialLaw> law;
    bool rigid() const { return law->rigid(); }
    /** Density, and moduli of small and fast deformation. */
    const defe::fe::IsotropicElastic &elastic() const { return law->elastic(); }
  };

  struct Part {
    std::string name;
    int material = -1;
    bool convertible = false;
    std::shared_ptr<const defe::ConversionCriterion> criterion;
    std::string
        criterion_words;    // name and numbers; of the largest principal stress the number alone
    double stress = 0.0;    // in uniaxial tension, at which elements convert
    int type = 0;           // atom type of its DEs
    int group = 0;          // group its DEs join
    double shield_time = 0.0;    // tau = 3 h / c_d, from the mean element size
    std::string start;           // region converted at step 0, "all", or empty
  };

  std::vector<Material> materials;
  std::vector<Part> parts;
  const Material &material_of(const Part &p) const { return materials[p.material]; }
  int find_part(const std::string &) const;

  /** Ties of DEs of `part` to elements of `base` that can break. */
  struct Adhesive {
    int part, base;
    defe::CohesiveParameters law;
  };
  std::vector<Adhesive> adhesives;
  /** Null: ties between these parts do not break. */
  const Adhesive *adhesive_of(int part, int base) const
  {
    for (const auto &a : adhesives)
      if (a.part == part && a.base == base) return &a;
    return nullptr;
  }

  /** Append an element anchored at owned atom i (its first node). Topology is made in init(). */
  void add_hex(int i, tagint id, int part, const tagint *nodes);
  void set_reference(int i, const double *x);
  void mesh_changed() { mesh_dirty = true; }
  bigint last_hex_id() const;    // collective

  /** Neighbours, masses and checks of new elements; collective, does nothing if there are none.
      Pair styles call it in their init(), which comes before ours: they need the DEs' radii. */
  void build_topology();

  double largest_element() const { return max_diagonal; }
  /** Distance from the centre at which a sphere begins, for spheres that are not bonded to it and
      facets of other parts: of a DE its outer face, of others their radius. Owned and ghost. */
  double reach_of(int i) const;
  /** Stiffness of a ball or a facet of another part against a DE (N/m): f_s K A^2/2V of its outer face,
      which is that of the same area of its element (four times A, eight times V), so that a contact does not
      change at a conversion. 0 if there is no contact of surfaces. */
  double ball_stiffness(int part, int i) const;
  double max_de_radius(int type) const;     // largest DE of that type that can ever be born
  double radius_to_come(int type) const;    // largest sphere of that type that fixes will insert
  bigint des_total = 0;                     // on all ranks

  // tables of local indices, made anew with the neighbour lists; how often, also within one step

  bigint tables_built = 0;

  JointTable jt;
  std::vector<defe::CornerModuli> corner_moduli;    // per part
  /** Strain energy of the corners of DE d with these joints; at the end the force on it by each joint. */
  double de_energy(int d, unsigned present, defe::Vec3 *half_force = nullptr) const;
  double *x_frame(int i) const { return xframe[i]; }
  const DERecord *de_record(int i) const { return de[i].get(); }
  /** The elements were evaluated in this step: what they and the cracks before them want is taken down. */
  bool elements_evaluated() const { return subcycle.due(); }
  bool cracks_ask = false;       // for elements that are in their way: set by the pair style
  bool is_loose(int i) const;    // a DE that nothing holds
  int elements_at(int i) const { return nelem[i]; }
  const std::vector<HexRecord> &hexes_of(int i) const { return hexes[i]; }

  /** Contacts of an owned atom, null if it has none; and the same, made if there are none. */
  AtomTouch *touches(int i) { return touch[i].get(); }
  AtomTouch &touch_at(int i)
  {
    if (!touch[i]) touch[i] = std::make_unique<AtomTouch>();
    return *touch[i];
  }

  defe::EnergyLedger ledger;
  defe::StoredEnergy stored;    // set by the pair style

  /** State changes of joints and elements, for the event file. */
  void record_event(const defe::Event &e) { event_log.record(e); }
  double now() const;    // simulated time
  void note_damage()
  {
    if (first_damage < 0.0) first_damage = now();
  }

  // ---- the same bits on any number of ranks: fix_defe_reproducible.cpp ----

  bool reproducible = false;
  defe::SumGrid force_grid, torque_grid;    // on if reproducible
  /** A contribution to f[i] or torque[i], rounded to its grid if there is one. */
  double on_grid(const defe::SumGrid &grid, double value, int i)
  {
    if (!grid.on()) return value;
    const double rounded = grid.round(value);
    if (grid.beyond(rounded)) beyond_grid = i;
    return rounded;
  }

  void centre_stress(const HexRecord &, double *centre, double *stress6, double &s1) const;
  bool local_hex(const HexRecord &, int anchor, int *idx) const;

  /** Current and reference coordinates of the nodes of an element, from local indices. */
  void hex_coords(const int *idx, defe::fe::HexCoords &x, defe::fe::HexCoords &X) const;

 private:
  // ---- options ----
  double contact_factor = 0.0;
  double contact_friction = 0.0;
  // overlaps that are there before the first step; of balls those that are deep are refused by default
  bool refuse_overlaps = false, ease_overlaps = false;
  double largest_force = 0.0;    // that an element bears at a strain of 1
  int beyond_grid = -1;          // an atom with a force or torque that is too large for exact sums
  void make_grids();
  void note_unreproducible();
  void check_range(bool sums);
  double element_mass(const Part &, double volume) const;
  double mean_size(const std::vector<HexRecord *> &, int part) const;
  bool shield = true;
  bool gauss_stress = false;
  bool force_lagrangian = false;
  defe::Subcycle subcycle;    // of the finite elements
#if defined(NDEBUG) && !defined(DEFE_CHECK)
  bool checking = false;      // of all records after every reneighbouring
#else
  bool checking = true;
#endif
  enum EnergyCheck { ENERGY_NO, ENERGY_WARN, ENERGY_STOP } energy_check = ENERGY_WARN;

  // ---- per-atom data ----
  double **xref = nullptr;      // reference position, never wrapped
  double **xframe = nullptr;    // the same, in the periodic frame that x is in now
  int *nelem = nullptr;         // finite elements at this node
  std::vector<std::vector<HexRecord>> hexes;
  std::vector<std::unique_ptr<DERecord>> de;
  std::vector<std::unique_ptr<AtomTouch>> touch;    // contacts at the last step
  int hexes_per_node = 1;    // largest number of elements with one first node, on any rank

  // DEs seen from outside, owned and ghost, 0 for other atoms: distance of their outer face, and its
  // A^2/2V, which times f_s K is a penalty stiffness
  std::vector<double> outer_reach, outer_length;
  bool mesh_dirty = false;
  bool reading = false;
  std::vector<char> just_read;    // by atom: its elements came with the data file that is read
  bool mesh_from_file = false;
  bigint nhex_header = 0;      // of the data file that is read
  bigint hexes_awaited = 0;    // announced by a header, section not met yet
  tagint de_base = 0;          // DEs have the IDs above, see de_tag()
  bool lots_moved = false;     // lots of IDs are dealt in the order of birth, see deal_lots()
  tagint last_id = 0;          // largest ID that an atom had when elements converted last
  tagint last_born = 0;        // largest ID of a DE so far
  bool giving_birth = false;
  bigint natoms_known = -1;                  // at the last reneighbouring
  std::vector<tagint> doubtful_newcomers;    // IDs of inserted atoms that a DE may have
  tagint last_element = 0;                   // largest element ID of the mesh
  bigint hexes_total = 0, nodes_total = 0;
  bigint hexes_added = 0;    // to the mesh by this rank, since its topology was made
  double mass_total = 0.0;
  double max_step_length = 0.0;    // a quarter of the shortest edge
  bigint des_gone = 0;             // of this rank: left the box, as the user allowed
  double mass_gone = 0.0;
  double dt_finite = 0.0, dt_discrete = 0.0;     // stable time steps, 0 = none
  double dt_joints = 0.0;                        // of DEs without ties
  double max_diagonal = 0.0, max_facet = 0.0;    // of elements and of their faces
  std::vector<double> de_radius_max;             // per type
  bool start_done = false;

  // ---- a mesh that was just made or read ----
  struct Mesh;
  void mesh_directory(Mesh &);
  void mesh_shapes(Mesh &);
  void mesh_masses(const Mesh &);
  void mesh_neighbours(const Mesh &);
  void check_orphans();

  // ---- kernels ----
  struct Kernel {
    std::unique_ptr<defe::fe::HexKernel> kernel;
    int part;
    bool of_shape = false;    // for elements congruent to `shape` only
    int history = 0;          // doubles per element
    defe::fe::HexCoords shape;
  };
  std::vector<Kernel> kernels;
  struct Batch {
    int kernel;
    bool rigid, convertible;
    std::vector<std::array<int, 8>> node;
    std::vector<HexRecord *> hex;
    std::vector<double> bound;
    std::vector<double *> history;    // empty if the material has none
    void clear();
  };
  std::vector<Batch> batches;    // one per kernel, of this rank's elements
  int kernel_of(int part, const defe::fe::HexCoords &X);

  // ---- surfaces ----
  friend class DefeSurfaceSearch;
  friend class DefeContactMemory;
  defe::SurfaceTables surface;
  std::shared_ptr<class DefeSurfaceSearch> surface_search;
  std::vector<std::array<int, 4>> facet_nodes;    // of its facets, closely packed
  bool planes_fresh = false;                      // they are of the positions now
  void pack_facet_nodes();
  void update_planes();
  bool is_ball(int i) const;    // a sphere that is no DE, owned or ghost
  defe::SurfaceArrays surface_arrays() const;
  double contact_energy_now();
  void book_contacts(const defe::SurfaceResult &);
  bool contact_to_book = false;    // a conversion waits for the contact energy of its DEs
  std::vector<int> fresh;          // owned DEs that were just born
  bigint through_count = 0;        // points that were let through, by this rank
  struct Through {
    bigint step = -1;
    tagint tag = 0;
    double depth = 0.0, x[3] = {0.0, 0.0, 0.0};
  } first_through;
  void note_let_through(int i, double depth);
  void report_contacts();
  bigint through_total = 0;
  bool through_told = false, overlaps_told = false, balls_told = false;
  bigint overlaps = 0;    // contacts that began overlapped, before the first step
  double overlap_depth = 0.0;
  tagint overlap_tag = 0;
  bool balls_placed = false;    // what they overlap now, motion has made
  // of balls that begin in a face, the deepest one also by its radius
  double ball_depth = 0.0, ball_energy = 0.0, ball_share = 0.0;
  tagint ball_tag = 0;
  void report_balls();
  bool tied(int de, tagint element) const;
  // batch and number of elements with free faces
  std::vector<std::pair<int, int>> exposed;
  double contact_energy = 0.0;    // at the last force evaluation, this rank
  void build_surfaces();
  void contact_forces();

  // ---- two clocks: see pre_reverse() ----
  void evaluate_finite(double *f, double history_step);

  // ---- conversion ----
  bigint convert_step = -1;
  std::vector<defe::ConvertingHex> converting;    // at least those with a node on this rank, by ID
  // by atom: index into converting, and corner
  std::unordered_map<int, std::vector<std::pair<int, int>>> marked_at;
  void tell_neighbours(std::vector<defe::ConvertingHex> &&);
  // elements that cracks want to enter: by DE atom, and what this rank knows of
  std::unordered_map<int, std::vector<tagint>> asked_at;
  std::unordered_set<tagint> asked;
  void mark_asked_elements();
  struct BallShare {
    tagint element, node, ball;
    double energy, push;
  };
  void ball_shares(const defe::ConversionPlan &, std::vector<BallShare> &);
  double first_conversion = -1.0, first_damage = -1.0;    // times
  void mark_elements();
  int set_criterion(Part &, const std::vector<std::string> &words);
  double criterion_value(const Batch &, int e, defe::Vec3 &direction) const;
  bool is_shielded(HexRecord &, const Part &, double value, const defe::Vec3 &direction) const;
  void schedule_conversion(int steps);

  // whether any rank has marked elements is asked at the end of a step, and the answer is taken in
  // the next when all have moved
  int marked_here = 0, marked_anywhere = 0;    // 2: one of them far above, see note_jump()
  MPI_Request mark_request = MPI_REQUEST_NULL;
  struct Jump {
    double ratio = 0.0;
    tagint id = 0;
  } jump;    // of the elements marked in this step, the one farthest above its conversion stress
  bool jump_told = false;
  void note_jump(tagint id, double ratio);
  void report_jump();
  void ask_marks();
  void take_marks();
  struct Conversion;
  struct OwnConversion;
  void convert_marked();
  void collect_marked(Conversion &);
  void ties_to_joints(const defe::ConversionPlan &);
  void update_beside(const defe::ConversionPlan &);
  void add_shields(const defe::ConversionPlan &, HexRecord &, const std::array<int, 8> &idx);
  void add_births(Conversion &, const OwnConversion &);
  static void fill_record(DERecord &, const defe::NewDE &, const defe::PlannedDE &);
  void hold_apart(tagint tag, DERecord &, int slot, const defe::PlannedDE &, const defe::NewDE &,
                  const std::array<int, 8> &idx, const defe::fe::HexCoords &element);
  bigint remove_converted(const Conversion &);
  void create_des(const Conversion &);
  void finish_conversion(bigint converted, bigint nodes_gone);
  std::vector<tagint> deal_lots(const std::vector<tagint> &elements);
  void register_newcomer(int i);
  void check_newcomers();
  void check_walls();
  void check_communication();
  void check_minimizer();
  std::string minimizer_hint() const;
  double wall_energy() const;
  void note_energy_in_walls();
  double distance_if_swung(int i, const tagint *face, int corner,
                           const defe::fe::HexCoords &element, int part) const;

  // ---- ghosts: no farther away than elements, joints and contacts need them ----
  double longest_provided = 0.0;    // distance between nodes of an element that they are enough for
  double largest_ball = 0.0;
  double ghost_reach() const;
  double longest_element() const;
  void provide_ghosts(double longest);
  void make_ghosts_for_setup();
  void find_all_nodes();
  void ghost_positions();

  // ---- communication ----
  enum CommMode { FRAME, POSVEL, SURFACE, ASKED, MARKED, LOSS, FINITE };
  // of SURFACE and MARKED: most that goes per atom and round; only atoms that have something send it
  static constexpr int SURFACE_SIZE = 2 + static_cast<int>((sizeof(HexPod) + 7) / 8);
  static constexpr int MARKED_SIZE = 2 + 2 + 8 + 24;
  CommMode comm_mode = FRAME;
  int comm_round = 0;
  std::unordered_map<int, std::vector<HexPod>> surface_at;    // exposed elements by first node
  std::vector<double> loss_mass;
  std::vector<int> loss_count;

  // ---- ledger ----
  std::vector<int> forced;           // owned atoms that other fixes may put forces on
  std::vector<double> f_internal;    // their forces and torques before that
  int forced_bits = 0;               // groups of these atoms
  int groups_forced() const;
  double external_power = 0.0;
  bool after_setup = false;
  double clock = 0.0;       // simulated time at the last step
  bigint last_step = -1;    // its number
  double power_of_others() const;
  bool in_account(int i) const;

  // watch over the balance: see fix_defe_watch.cpp
  std::string unseen_work() const;
  void prepare_energy_watch();
  void begin_energy_watch();
  void watch_energy();
  void watch_rigid_elements();
  bool energy_watched = false, balance_known = false, energy_told = false;
  double balance_start = 0.0, balance_last = 0.0, energy_put_in = 0.0, swing_start = 0.0;
  double energy_swing() const;
  double virial_fe[6];
  double fe_energy_all();
  defe::EntryValues vector_values{};
  double surface_energy_all = 0.0;
  bigint vector_step = -1;
  bool between_runs = false;    // and there was one
  void fill_vector();
  void count_joints_and_motion(defe::EntryValues &);
  double largest_stress() const;
  bigint conversions_total = 0;
  std::vector<double> scratch;
  defe::EventLog event_log;
  void flush_events();
  void name_run();
  void stop_by_first_rank(std::string complaint);
  bigint restart_step = -1;    // of the file that was read

  // ---- pictures ----
  std::vector<double> image_data;
  std::vector<double *> image_rows;
  std::vector<int> image_vec;

  // ---- what the script said: fix_defe_script.cpp ----
  std::string describe_part(const Part &) const;
  std::map<std::string, std::string> settings() const;
  std::string pack_script() const;
  /** Returns the name of the event file. */
  std::string unpack_script(const char *data, size_t bytes);
  void note_changes(const std::map<std::string, std::string> &before);

  // ---- notes at the first run ----
  bool notes_due = false;        // the mesh was made or has grown since the last run
  bool contact_given = false;    // the keyword, also with 0
  std::vector<std::string> notes_said;
  void say_notes();
  void say(const std::string &note);
  void note_strengths();
  void note_bodies();
  void note_untied();

  // ---- checks ----
  void check_records(const char *when);
  void check_masses();
  void account_for_deleted();
  void watch_walls();
  void watch_speed();
  void stop_exploded();
  void check_integrators();
  bool may_convert(const Part &) const;
  void check_movers();
  void check_spins();
  void check_rigid_bodies();
  void check_rigid_parts();
  struct MovedNode;
  MovedNode first_moved(const std::vector<char> &of_parts, const std::vector<Fix *> &movers,
                        int held) const;
  void check_time_step(bool changed);
  bool warned_of_step = false;
  double checked_dt = -1.0;
  void check_name(const char *what, const std::string &name) const;
  void check_numbers_as_names() const;
  void check_bond_fixes(bool converting);
  void check_adhesives();
  std::string describe(int i) const;
  double kinetic_energy(int i) const;

  // ---- forces at the end of a run, or in a restart file: see fix_defe_kept.cpp ----
  std::vector<KeptForces> kept;    // by atom; empty while a run goes on
  bigint kept_step = -1, kept_natoms = 0;
  uint64_t kept_law = 0;       // checksum of what the script says about them
  bool running = false;        // between the first step of a run and its end
  bool needs_setup = false;    // LAMMPS was initialized, which sends atoms around
  bool has_kept(int i) const
  {
    return !kept.empty() && kept[i].motion != 0;
  }
  uint64_t kept_motion(int i) const;
  uint64_t kept_laws() const;
  void keep_forces();
  void drop_kept_forces();
  void continue_with_kept_forces();
  bool kept_places() const;
  void begin_run();
  void follow_clock(bigint step);

  // ---- restart files: see fix_defe_restart.cpp ----
  int restart_maxsize = 0;    // of the record of any atom on any rank
  struct RestartCheck {
    bool unread = false;    // a file was read, and check_restart() is to come
    bigint records_of_file = 0;
    uint64_t sum_of_file = 0;
    bigint records = 0, damaged = 0, other_steps = 0, other_step = -1;    // this rank
    uint64_t sum = 0;
    tagint first = 0;    // of the damaged ones
  } restart_check;
  uint64_t restart_checksum(int i, const double *record, int n) const;
  void check_restart();

  int history_most = 0;    // doubles of material history that an element has
  int local_of(tagint) const;
  /** The eight DEs of an element have the IDs of one lot: that with the number of the element, as
      long as no other atoms have come; see deal_lots(). */
  tagint de_tag(tagint lot, int corner) const
  {
    return de_base + 8 * (lot - 1) + corner + 1;
  }
  tagint last_de() const
  {
    return de_base + 8 * last_element;
  }
  void require_hex_section();
  void update_maxexchange();
  int pack_record(int, double *) const;
  int unpack_record(int, const double *);
  int record_size(int) const;
};

}    // namespace LAMMPS_NS

#endif
#endif
