/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_MARKS_H
#define LMP_DEFE_MARKS_H

#include "defe_component.h"
#include "defe_ghosts.h"

#include "defe/types.h"

#include <unordered_map>
#include <unordered_set>
#include <vector>

namespace LAMMPS_NS {

struct DefeBatch;
struct DefePart;
struct HexRecord;

/** Which elements convert, and when: their criterion, shields, cracks that are on their way to them, and the
    question to all ranks, which is asked at the end of a step and answered in the next. */
class DefeMarks : protected DefeComponent {
 public:
  explicit DefeMarks(DefeSystem &);
  ~DefeMarks() override;

  /** The elements were evaluated in this step: marks those that are above their criterion or that cracks ask for. */
  void mark();
  /** Before a run: marks them anew, or restores what was marked at the last evaluation. */
  void begin_run();
  /** After all atoms have moved: does any rank have marked elements? */
  void answer();
  void end_run();
  bool any();    // marked, of any rank

  /** Steps of a window at the end of which elements convert (collect). */
  int window() const;
  /** In which a crack runs no farther than DEs are apart, in any part; 1 if no part waits for windows. */
  int longest_window() const;
  bool waits(const DefePart &) const;
  double crack_speed(const DefePart &) const;    // at most
  double de_spacing(const DefePart &) const;

  bool due() const;    // in this step
  void done();         // they convert now
  /** The clock was set forward by so many steps. */
  void follow(bigint steps);

  // most that goes per atom
  static constexpr int MESSAGE_SIZE = 36;

  /** Cracks may ask for elements that are in their way: set by the pair style. */
  void let_cracks_ask(bool yes) { cracks_ask_ = yes; }
  bool cracks_ask() const { return cracks_ask_; }
  void mark_asked();

 private:
  bigint convert_step = -1;
  // since the last conversion; 2: one of them far above, see note_jump()
  int marked_here = 0, marked_anywhere = 0;
  MPI_Request request = MPI_REQUEST_NULL;
  struct Jump {
    double ratio = 0.0;
    tagint id = 0;
  } jump;    // of the elements marked in this step, the one farthest above its conversion stress
  bool jump_told = false;
  bool cracks_ask_ = false;

  double value_of(const DefeBatch &, int e, defe::Vec3 &direction) const;
  bool is_shielded(HexRecord &, const DefePart &, double value, double limit,
                   const defe::Vec3 &direction) const;
  void mark_batch(int batch);
  bool closes(bigint evaluation) const;
  void schedule(int steps);
  void ask();
  void take();
  void note_jump(tagint id, double ratio);
  void report_jump();

  /** Elements that cracks want to enter, as the DEs in front of them say. */
  class Asked : public DefeMessage {
   public:
    std::unordered_map<int, std::vector<tagint>> at;    // by DE atom
    std::unordered_set<tagint> known;                   // those that this rank knows of
    int pack_forward(int n, const int *list, const double *shift, double *buf) override;
    void unpack_forward(int n, int first, const double *buf) override;
  } asked;
};

}    // namespace LAMMPS_NS

#endif
