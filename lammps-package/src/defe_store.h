/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

#ifndef LMP_DEFE_STORE_H
#define LMP_DEFE_STORE_H

#include "defe_component.h"
#include "defe_records.h"

#include <algorithm>
#include <memory>
#include <vector>

namespace LAMMPS_NS {

/** One kind of data that atoms have: how it grows, moves, and travels in their records. */
class DefeField {
 public:
  virtual void grow(int n) = 0;
  /** LAMMPS copies only to move: what is at `from` is not used any more. */
  virtual void move(int from, int to) = 0;
  virtual int size(int i) const = 0;
  virtual int pack(int i, double *buf) const = 0;
  virtual int unpack(int i, const double *buf) = 0;
  /** No atom of this rank has more, also after a conversion that follows. */
  virtual int most() const = 0;

 protected:
  ~DefeField() = default;    // never deleted through this class
};

/** Data that few atoms have; null: it has none. */
template <class T> class DefeSparseField : public DefeField {
 public:
  void grow(int n) override { of.resize(n); }
  void move(int from, int to) override { of[to] = std::move(of[from]); }
  /** Also of an atom that there is no room for yet, and if the field is not in use. */
  void clear(int i)
  {
    if (i < static_cast<int>(of.size())) of[i].reset();
  }

 protected:
  std::vector<std::unique_ptr<T>> of;    // by atom
};

/** Data that so few atoms have that a look at all atoms would take longer than all else that is done with them. */
template <class T> class DefeRareField : public DefeSparseField<T> {
 public:
  void move(int from, int to) override
  {
    DefeSparseField<T>::move(from, to);
    if (of[to]) came(to);
  }
  /** Of the first n atoms those that have it, in order. */
  const std::vector<int> &places(int n) const
  {
    if (!in_order) std::sort(listed.begin(), listed.end());
    in_order = true;
    listed.erase(std::unique(listed.begin(), listed.end()), listed.end());
    const auto gone = [this, n](int i) {
      return i >= n || !of[i];
    };
    listed.erase(std::remove_if(listed.begin(), listed.end(), gone), listed.end());
    return listed;
  }

 protected:
  using DefeSparseField<T>::of;
  void came(int i)
  {
    in_order = in_order && (listed.empty() || listed.back() <= i);
    listed.push_back(i);
  }

 private:
  mutable std::vector<int> listed;    // all that have it, some twice, and some that had it
  mutable bool in_order = true;
};

/** Lists that few atoms have. */
template <class T> class DefeListField : public DefeSparseField<std::vector<T>> {
 public:
  double memory_usage() const
  {
    double bytes = static_cast<double>(of.capacity()) * sizeof(of[0]);
    for (const auto &one : of)
      if (one) bytes += sizeof(*one) + one->capacity() * sizeof(T);
    return bytes;
  }

 protected:
  using DefeSparseField<std::vector<T>>::of;

  void add(int i, const T &one)
  {
    if (!of[i]) of[i] = std::make_unique<std::vector<T>>();
    of[i]->push_back(one);
  }
  template <class F> void drop_if(int i, const F &which)
  {
    auto &list = *of[i];
    list.erase(std::remove_if(list.begin(), list.end(), which), list.end());
    if (list.empty()) of[i].reset();
  }
  /** The largest size() of so many atoms. */
  int largest_size(int n) const
  {
    int most = 1;
    for (int i = 0; i < n; i++) most = std::max(most, this->size(i));
    return most;
  }
};

/** Doubles that hold so many bytes. */
constexpr int doubles_of(size_t bytes)
{
  return static_cast<int>((bytes + sizeof(double) - 1) / sizeof(double));
}

/** What atoms have: reference positions, elements, DEs and contacts, and what others add to the table of
    fields. Migrates with them, and is in restart files. */
class DefeStore : protected DefeComponent {
 public:
  explicit DefeStore(DefeSystem &);
  ~DefeStore() override;
  void add_field(DefeField *);

  /** Reference position, never wrapped; and in the periodic frame of the current x. */
  double *x_ref(int i) const { return frames.ref[i]; }
  double *x_frame(int i) const { return frames.now[i]; }
  void set_reference(int i, const double *x);

  /** Finite elements at this node. */
  int elements_at(int i) const { return frames.elements[i]; }
  void set_elements_at(int i, int n) { frames.elements[i] = n; }
  /** Of which it is the first node. */
  std::vector<HexRecord> &hexes(int i) { return elements.of[i]; }
  const std::vector<HexRecord> &hexes(int i) const { return elements.of[i]; }

  /** Null: it is not a DE. */
  DERecord *de(int i) const { return des.of[i].get(); }
  void set_de(int i, std::unique_ptr<DERecord> r) { des.set(i, std::move(r)); }
  /** Owned atoms that are DEs, in order. */
  const std::vector<int> &de_atoms() const;
  bool is_loose(int i) const;    // a DE that nothing holds
  bool is_node(int i) const { return !de(i) && elements_at(i) > 0; }
  bool is_ours(int i) const { return de(i) || elements_at(i) > 0; }

  /** Contacts of an owned atom, null if it has none; and the same, made if there are none. */
  AtomContacts *contacts_of(int i) const { return contacts.of[i].get(); }
  AtomContacts &contacts_at(int i);
  /** Owned atoms with contacts or cracks, in order. */
  const std::vector<int> &contact_atoms() const;

  // what has changed since settle(): tables of local indices need to be made anew there only

  /** Places of which the atom or the list of its elements is another one; in any order. */
  const std::vector<int> &changed() const { return changed_list; }
  bool changed(int i) const { return changed_at[i] != 0; }
  void touch(int i);
  void settle();

  void grow(int n);
  void move(int from, int to);
  /** For a new atom. */
  void clear(int i);
  /** For one that is gone, and whose place no other atom has taken. */
  void forget(int i);

  // the record of one atom, with its size at the front

  int record_size(int i) const;
  int pack(int i, double *buf) const;
  int unpack(int i, const double *buf);
  void update_maxexchange();

  /** Of a data file that is read: its elements come before LAMMPS makes the arrays of the atoms. */
  void begin_reading();
  void end_reading();
  void came_with_file(int i);

  double memory_usage() const;

 private:
  struct Frames : DefeField {
    double **ref = nullptr, **now = nullptr;
    int *elements = nullptr;
    Memory *memory = nullptr;
    void grow(int n) override;
    void move(int from, int to) override;
    int size(int) const override { return SIZE; }
    int pack(int i, double *buf) const override;
    int unpack(int i, const double *buf) override;
    int most() const override { return SIZE; }
    static constexpr int SIZE = 4;
  } frames;
  struct DEs : DefeRareField<DERecord> {
    using DefeRareField::of;
    void set(int i, std::unique_ptr<DERecord> r)
    {
      of[i] = std::move(r);
      came(i);
    }
    int size(int i) const override;
    int pack(int i, double *buf) const override;
    int unpack(int i, const double *buf) override;
    int most() const override;
  } des;
  struct Contacts : DefeRareField<AtomContacts> {
    using DefeRareField::of;
    const Atom *atom = nullptr;
    AtomContacts &at(int i)
    {
      if (!of[i]) {
        of[i] = std::make_unique<AtomContacts>();
        came(i);
      }
      return *of[i];
    }
    int size(int i) const override;
    int pack(int i, double *buf) const override;
    int unpack(int i, const double *buf) override;
    int most() const override;
  } contacts;
  struct Elements : DefeField {
    std::vector<std::vector<HexRecord>> of;
    DefeSystem *sys = nullptr;
    void grow(int n) override { of.resize(n); }
    void move(int from, int to) override;
    int size(int i) const override;
    int pack(int i, double *buf) const override;
    int unpack(int i, const double *buf) override;
    int most() const override;
  } elements;
  std::vector<DefeField *> fields;

  std::vector<char> changed_at;    // by atom
  std::vector<int> changed_list;

  bool reading = false;
  std::vector<char>
      just_read;    // by atom: its elements came with the data file that is being read
};

}    // namespace LAMMPS_NS

#endif
