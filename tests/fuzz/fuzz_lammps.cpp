#include "fuzz_lammps.h"

#include "lammpsplugin.h"

#include "force.h"
#include "modify.h"

#include <mpi.h>

#include <cstdlib>
#include <cstring>
#include <sstream>

using namespace LAMMPS_NS;

extern "C" {
// Open MPI keeps memory to the end; AddressSanitizer's word goes before Open MPI's signal handlers.
const char *__asan_default_options()
{
  return "detect_leaks=0:handle_segv=2:handle_sigbus=2:handle_sigfpe=2:handle_abort=2:"
         "allocator_may_return_null=1";
}
const char *__ubsan_default_options()
{
  return "print_stacktrace=1";
}

int LLVMFuzzerInitialize(int * /*argc*/, char *** /*argv*/)
{
  int done = 0;
  MPI_Initialized(&done);
  if (!done) {
    setenv("OMPI_MCA_opal_signal", "", 1);
    MPI_Init(nullptr, nullptr);
    std::atexit([] {
      MPI_Finalize();
    });
  }
  return 0;
}
}

namespace {

/// Takes the styles from the plugin's entry point without a shared object to load or close.
void register_style(lammpsplugin_t *plugin, void *ptr)
{
  auto *lmp = static_cast<LAMMPS *>(ptr);
  const std::string style = plugin->style;
  if (style == "fix")
    (*lmp->modify->fix_map)[plugin->name] =
        reinterpret_cast<Modify::FixCreator>(plugin->creator.v2);
  else if (style == "compute")
    (*lmp->modify->compute_map)[plugin->name] =
        reinterpret_cast<Modify::ComputeCreator>(plugin->creator.v2);
  else if (style == "pair")
    (*lmp->force->pair_map)[plugin->name] =
        reinterpret_cast<Force::PairCreator>(plugin->creator.v1);
  else if (style == "command")
    (*lmp->input->command_map)[plugin->name] =
        reinterpret_cast<Input::CommandCreator>(plugin->creator.v1);
  else
    std::abort();
}

}    // namespace

namespace defe::fuzz {

std::unique_ptr<LAMMPS> start(const std::vector<std::string> &script)
{
  std::vector<std::string> words = {"fuzz", "-screen", "none", "-log", "none", "-nocite"};
  Arguments arguments(words);
  auto lmp = std::make_unique<LAMMPS>(arguments.narg(), arguments.arg.data(), MPI_COMM_WORLD);
  lammpsplugin_init(lmp.get(), nullptr, reinterpret_cast<void *>(&register_style));
  for (const auto &line : script) lmp->input->one(line);
  return lmp;
}

std::vector<std::string> lines_of(const std::uint8_t *data, std::size_t size)
{
  const std::string text(reinterpret_cast<const char *>(data), size);
  std::istringstream in(text.substr(0, text.find('\0')));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> words_of(const std::string &line)
{
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

}    // namespace defe::fuzz
