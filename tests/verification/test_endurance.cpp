// Issue 3, endurance: 100 000 conversions in one run, and one million steps of a tumbling fragment.
// Minutes each.
//
// ranks: 2
// timeout: 3600

#include "endurance.h"

using namespace defe::test;

TEST(Endurance, HundredThousandConversions)
{
  shatter(52, 100, 1e5);
}

TEST(Endurance, MillionSteps)
{
  if (rank_of(MPI_COMM_WORLD) == 0) tumble(1000000, MPI_COMM_SELF);
}
