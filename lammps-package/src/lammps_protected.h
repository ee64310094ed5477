/* ----------------------------------------------------------------------
   DEFE: adaptive finite elements to bonded discrete elements for LAMMPS
   https://www.lammps.org/
   This software is distributed under the GNU General Public License.
------------------------------------------------------------------------- */

// Members of LAMMPS' classes that are protected: it has no functions for single atoms that come and go.

#ifndef LMP_DEFE_LAMMPS_PROTECTED_H
#define LMP_DEFE_LAMMPS_PROTECTED_H

#include "atom.h"
#include "comm_brick.h"
#include "memory.h"
#include "neighbor.h"

#include <algorithm>
#include <vector>

namespace LAMMPS_NS::Protected {

/** From IDs to local indices. */
struct Map : Atom {
  /** For n more IDs, the largest of them `last`, the same on all ranks; false: only by a new map. */
  static bool make_room(Atom *atom, Memory *memory, int n, tagint last)
  {
    if (atom->map_style != Atom::MAP_ARRAY) {
      make_room_in_hash(atom, n);
      return true;
    }
    if (last <= atom->map_tag_max) return true;
    if (last >= MAXSMALLINT) return false;
    const int room = static_cast<int>(MIN(static_cast<bigint>(last) + last / 8, MAXSMALLINT - 1));
    int *&array = atom->*(&Map::map_array);
    memory->grow(array, room + 1, "atom:map_array");
    std::fill(array + atom->map_tag_max + 1, array + room + 1, -1);
    atom->map_tag_max = atom->*(&Map::map_maxarray) = room;
    return true;
  }
  /** Longer chains from the same buckets. */
  static void make_room_in_hash(Atom *atom, int n)
  {
    if (atom->map_style != Atom::MAP_HASH) return;
    const int used = atom->*(&Map::map_nused), old = atom->*(&Map::map_nhash);
    if (used + n <= old) return;
    const int room = used + n + used / 8;
    auto *const grown = new HashElem[room];
    HashElem *&hash = atom->*(&Map::map_hash);
    std::copy_n(hash, old, grown);
    for (int k = old; k < room; k++) grown[k].next = k + 1;
    grown[room - 1].next = atom->*(&Map::map_free);
    atom->*(&Map::map_free) = old;
    delete[] hash;
    hash = grown;
    atom->*(&Map::map_nhash) = room;
  }
  static int room_for_images(const Atom *atom) { return atom->*(&Map::max_same); }
  static void make_room_for_images(Atom *atom, Memory *memory, int n)
  {
    if (n <= room_for_images(atom)) return;
    atom->*(&Map::max_same) = n;
    memory->grow(atom->sametag, n, "atom:sametag");
  }
  static void set(Atom *atom, tagint tag, int i)
  {
    atom->map_tag_max = MAX(atom->map_tag_max, tag);    // of a hash; an array has the room
    atom->map_one(tag, i);
  }
  static void remove(Atom *atom, tagint tag)
  {
    if (atom->map_style == Atom::MAP_ARRAY) {
      atom->map_one(tag, -1);
      return;
    }
    HashElem *const hash = atom->*(&Map::map_hash);
    int *link = &(atom->*(&Map::map_bucket))[tag % atom->*(&Map::map_nbucket)];
    while (*link >= 0 && hash[*link].global != tag) link = &hash[*link].next;
    if (*link < 0) return;
    const int entry = *link;
    *link = hash[entry].next;
    hash[entry].next = atom->*(&Map::map_free);
    atom->*(&Map::map_free) = entry;
    (atom->*(&Map::map_nused))--;
  }
};

/** Positions at the last reneighbouring. */
struct Lists : Neighbor {
  static void make_room(Neighbor *neighbor, Memory *memory, int n)
  {
    if (n <= neighbor->*(&Lists::maxhold)) return;
    neighbor->*(&Lists::maxhold) = n;
    memory->grow(neighbor->*(&Lists::xhold), n, 3, "neigh:xhold");
  }
};

/** What is sent to ghosts, and where they are. */
struct Swaps : CommBrick {
  static int count(const CommBrick *c) { return c->*(&Swaps::nswap); }
  static int &first(CommBrick *c, int s) { return (c->*(&Swaps::firstrecv))[s]; }
  static int sent(const CommBrick *c, int s) { return (c->*(&Swaps::sendnum))[s]; }
  static int received(const CommBrick *c, int s) { return (c->*(&Swaps::recvnum))[s]; }
  static int *list(CommBrick *c, int s) { return (c->*(&Swaps::sendlist))[s]; }
  static int to(const CommBrick *c, int s) { return (c->*(&Swaps::sendproc))[s]; }
  static int from(const CommBrick *c, int s) { return (c->*(&Swaps::recvproc))[s]; }
  static int across(const CommBrick *c, int s) { return (c->*(&Swaps::pbc_flag))[s]; }
  static int *shift(CommBrick *c, int s) { return (c->*(&Swaps::pbc))[s]; }
  static int size_of_atom(const CommBrick *c) { return c->*(&Swaps::size_border); }

  /** Swaps there and back in a dimension, and how many of these this rank sends in. */
  static int pairs(const CommBrick *c, int dim) { return (c->*(&Swaps::maxneed))[dim]; }
  static int pairs_sent(const CommBrick *c, int dim, int back)
  {
    return (c->*(&Swaps::sendneed))[dim][back];
  }
  /** Where atoms of this type are sent from. */
  static double low(const CommBrick *c, const Neighbor *neighbor, int s, int type)
  {
    return c->mode == Comm::MULTI ? (c->*(&Swaps::multilo))[s][neighbor->type2collection[type]]
                                  : (c->*(&Swaps::slablo))[s];
  }
  static double high(const CommBrick *c, const Neighbor *neighbor, int s, int type)
  {
    return c->mode == Comm::MULTI ? (c->*(&Swaps::multihi))[s][neighbor->type2collection[type]]
                                  : (c->*(&Swaps::slabhi))[s];
  }

  static void set_sent(CommBrick *c, int s, const std::vector<int> &list)
  {
    const int n = static_cast<int>(list.size());
    if (n > (c->*(&Swaps::maxsendlist))[s]) (c->*(&Swaps::grow_list))(s, n);
    std::copy(list.begin(), list.end(), Swaps::list(c, s));
    (c->*(&Swaps::sendnum))[s] = n;
    (c->*(&Swaps::size_reverse_recv))[s] = n * c->*(&Swaps::size_reverse);
  }
  static void set_received(CommBrick *c, int s, int first, int n)
  {
    (c->*(&Swaps::firstrecv))[s] = first;
    (c->*(&Swaps::recvnum))[s] = n;
    (c->*(&Swaps::size_forward_recv))[s] = n * c->*(&Swaps::size_forward);
    (c->*(&Swaps::size_reverse_send))[s] = n * c->*(&Swaps::size_reverse);
  }
  /** As CommBrick::borders() ends. */
  static void make_room(CommBrick *c)
  {
    int sent = 0, received = 0;
    for (int s = 0; s < count(c); s++) {
      sent = MAX(sent, Swaps::sent(c, s));
      received = MAX(received, Swaps::received(c, s));
    }
    c->*(&Swaps::smax) = sent;
    c->*(&Swaps::rmax) = received;
    const int forward = c->*(&Swaps::maxforward), reverse = c->*(&Swaps::maxreverse);
    const int out = MAX(forward * sent, reverse * received);
    if (out > c->*(&Swaps::maxsend)) (c->*(&Swaps::grow_send))(out, 0);
    const int in = MAX(forward * received, reverse * sent);
    if (in > c->*(&Swaps::maxrecv)) (c->*(&Swaps::grow_recv))(in);
  }
};

}    // namespace LAMMPS_NS::Protected

#endif
