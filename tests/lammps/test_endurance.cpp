// Many conversions and many steps, as far as the time of the normal suite allows; the full length
// is in tests/verification/test_endurance.cpp.
//
// ranks: 1 4
// timeout: 200

#include "endurance.h"

using namespace defe::test;

TEST(Endurance, ThousandConversions)
{
  shatter(11, 60, 1000);
}

TEST(Endurance, FiftyThousandSteps)
{
  if (size_of(MPI_COMM_WORLD) > 1) GTEST_SKIP() << "one fragment, one rank";
  tumble(50000);
}
