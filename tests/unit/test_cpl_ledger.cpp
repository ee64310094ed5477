// The account of energies: what its entries are, as the page and the examples say, and what they add up to.

#include "defe/coupling/ledger.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

using namespace defe;

namespace {

std::string text_of(const std::string &file)
{
  std::ifstream in(std::string(DEFE_SOURCE_DIR) + "/" + file);
  std::ostringstream text;
  text << in.rdbuf();
  EXPECT_FALSE(text.str().empty()) << file;
  return text.str();
}

/// With one blank between words.
std::string even(const std::string &text)
{
  std::istringstream in(text);
  std::string word, all;
  while (in >> word) all += (all.empty() ? "" : " ") + word;
  return all;
}

/// Rows of the table of entries on the page of fix defe.
std::vector<std::vector<std::string>> rows_of_page()
{
  const std::string page = text_of("lammps-package/doc/fix_defe.rst");
  std::istringstream in(page.substr(page.find("   * - Entry\n")));
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(in, line) && (line.empty() || line[0] == ' ');) {
    if (line.compare(0, 7, "   * - ") == 0)
      rows.push_back({line.substr(7)});
    else if (line.compare(0, 6, "     -") == 0)
      rows.back().push_back(line.substr(6));
    else
      rows.back().back() += " " + line;
  }
  for (auto &row : rows)
    for (auto &cell : row) cell = even(cell);
  return rows;
}

/// Numbers of entries, as "2, 15 to 21 and 30".
template <class Which> std::string numbers(const Which &which)
{
  std::vector<std::string> ranges;
  for (int k = 0; k < entries::COUNT; k++) {
    if (!which(k)) continue;
    int last = k;
    while (last + 1 < entries::COUNT && which(last + 1)) last++;
    if (last == k + 1) last = k;    // two are listed
    ranges.push_back(std::to_string(k + 1) + (last > k ? " to " + std::to_string(last + 1) : ""));
    k = last;
  }
  std::string all;
  for (size_t r = 0; r < ranges.size(); r++)
    all += (r == 0 ? "" : r + 1 == ranges.size() ? " and " : ", ") + ranges[r];
  return all;
}

}    // namespace

TEST(Ledger, PageHasTheEntries)
{
  const auto rows = rows_of_page();
  ASSERT_EQ(rows.size(), 1u + entries::COUNT);
  for (int k = 0; k < entries::COUNT; k++) {
    const auto &facts = entry_facts[k];
    const auto &row = rows[k + 1];
    ASSERT_EQ(row.size(), 5u) << k + 1;
    EXPECT_EQ(row[0], std::to_string(k + 1));
    EXPECT_EQ(row[1], facts.name);
    EXPECT_THAT(row[2], testing::StartsWith(facts.meaning));
    EXPECT_EQ(row[3], facts.unit) << facts.name;
    EXPECT_EQ(row[4],
              facts.in_total > 0       ? "\\+"
                  : facts.in_total < 0 ? "\\-"
                  : facts.in_balance   ? "no"
                                       : "")
        << facts.name;
  }
  const std::string page = text_of("lammps-package/doc/fix_defe.rst");
  const std::string cumulative = numbers([](int k) {
    return entry_facts[k].cumulative;
  });
  for (const std::string &sentence :
       {"Entries " + cumulative + " are cumulative",
        "a global vector of length " + std::to_string(entries::COUNT)})
    EXPECT_NE(page.find(sentence), std::string::npos) << "not on the page: " << sentence;
}

TEST(Ledger, MeaningOfTotalIsWhatIsAdded)
{
  EXPECT_EQ(std::string(entry_facts[entries::TOTAL].meaning),
            "sum of entries " + numbers([](int k) {
              return entry_facts[k].in_total > 0;
            }) + " less entry " +
                numbers([](int k) {
                  return entry_facts[k].in_total < 0;
                }));
  EXPECT_EQ(std::string(entry_facts[entries::BALANCE].meaning),
            "entry " + std::to_string(entries::TOTAL + 1) + " plus entries 19 and 20");
  EXPECT_TRUE(entry_facts[18].in_balance && entry_facts[19].in_balance);
}

TEST(Ledger, ExamplesNameTheColumns)
{
  for (const std::string file :
       {"glass_beam/in.glass_beam", "laminated_beam/in.laminated_beam", "pane_output.inc"}) {
    const std::string script = text_of("examples/" + file);
    const size_t from = script.find("time_us elements");
    ASSERT_NE(from, std::string::npos) << file;
    std::istringstream in(script.substr(from, script.find('"', from) - from));
    std::string word, expected;
    in >> word;
    int k = 0;
    for (const auto &facts : entry_facts) {
      do in >> word;
      while (word == "&");
      EXPECT_EQ(word, facts.column) << file;
      if (++k == 28) break;    // f_fe[*28]
    }
    EXPECT_NE(script.find("f_fe[*28]"), std::string::npos) << file;
  }
}

TEST(Ledger, TotalAndBalance)
{
  EntryValues w{};
  for (int k = 0; k < entries::COUNT; k++) w[k] = std::ldexp(1.0, k);    // a bit each
  double total = 0.0;
  for (int k = entries::E_ELEMENTS; k <= entries::FRICTION; k++) total += w[k];
  total += w[entries::VISCOUS] + w[entries::E_LET_THROUGH] - w[entries::EXTERNAL];
  EXPECT_EQ(total_of(w), total);
  EXPECT_EQ(balance_of(w), total + w[entries::CONV_STRAIN] + w[entries::CONV_KINETIC]);
}

// What is dissipated, lost or put in moves from one entry to another: where the total changes, the balance does
// not, and work from outside changes neither.
TEST(Ledger, WhatIsLostIsInTheBalance)
{
  EntryValues w{};
  w[entries::E_KINETIC] = 3.0;
  w[entries::E_ELEMENTS] = 1.0;
  EnergyLedger ledger;
  ledger.fill(w);
  const double total = total_of(w);
  const auto moved = [&](double EnergyLedger::*to, entries::Entry from) {
    EntryValues after = w;
    EnergyLedger one;
    one.*to = 0.25;
    one.fill(after);
    after[from] -= 0.25;
    return after;
  };
  for (auto to : {&EnergyLedger::fracture, &EnergyLedger::release, &EnergyLedger::damping,
                  &EnergyLedger::friction, &EnergyLedger::viscous, &EnergyLedger::through}) {
    const auto after = moved(to, entries::E_ELEMENTS);
    EXPECT_EQ(total_of(after), total);
    EXPECT_EQ(balance_of(after), total);
  }
  for (auto to : {&EnergyLedger::conv_strain, &EnergyLedger::conv_kinetic}) {
    const auto after = moved(to, entries::E_KINETIC);
    EXPECT_EQ(total_of(after), total - 0.25);
    EXPECT_EQ(balance_of(after), total);
  }
  EntryValues pushed = w;
  ledger.external = 0.5;
  ledger.fill(pushed);
  pushed[entries::E_KINETIC] += 0.5;
  EXPECT_EQ(balance_of(pushed), total);
}

TEST(Ledger, FilesKeepTheSums)
{
  EnergyLedger a, b;
  double numbers[EnergyLedger::size], again[EnergyLedger::size];
  for (int k = 0; k < EnergyLedger::size; k++) numbers[k] = 0.1 + k;
  a.unpack(numbers);
  a.pack(again);
  for (int k = 0; k < EnergyLedger::size; k++) EXPECT_EQ(again[k], numbers[k]);
  // each of them is in an entry of its own
  EntryValues w{};
  a.fill(w);
  double sum = 0.0, expected = 0.0;
  for (double value : w) sum += value;
  for (double value : numbers) expected += value;
  EXPECT_DOUBLE_EQ(sum, expected);
}
