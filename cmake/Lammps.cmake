# The LAMMPS host: found, or fetched and built once outside the project tree.
#
# Takes   LAMMPS_SOURCE_DIR  own source tree, built in the cache
#         LAMMPS_BINARY_DIR  own CMake build of it (shared library), used as it is
#         DEFE_LAMMPS_SHA256 checksum to demand of the upstream tarball, where that is fetched
# Gives   defe_lammps_headers  includes, definitions and MPI, for code that a running LAMMPS loads
#         defe_lammps          the same with liblammps, for programs
#         DEFE_LMP_EXECUTABLE, LAMMPS_SOURCE_DIR, DEFE_LAMMPS_VERSION, DEFE_MPI_ID
#         <build>/generated/defe_build_info.h, <build>/lmp

set(LAMMPS_SOURCE_DIR "" CACHE PATH "LAMMPS source tree to use instead of the fetched one")
set(LAMMPS_BINARY_DIR "" CACHE PATH "Finished CMake build of LAMMPS to use instead of building one")
set(DEFE_LAMMPS_RELEASE "4Feb2025" CACHE STRING "LAMMPS release to fetch")
set(DEFE_LAMMPS_SHA256 "" CACHE STRING "Checksum to demand of the upstream tarball of LAMMPS")

set(MPI_DETERMINE_LIBRARY_VERSION TRUE)
find_package(MPI REQUIRED COMPONENTS CXX)
# "Open MPI v4.1.4, package ..." -> "Open MPI"; "MPICH Version: 4.0.2 ..." -> "MPICH"
string(REGEX MATCH "^(Open MPI|MPICH|MVAPICH2?|Intel\\(R\\) MPI)" DEFE_MPI_ID "${MPI_CXX_LIBRARY_VERSION_STRING}")

# --- where it is ------------------------------------------------------------

if(LAMMPS_BINARY_DIR)
  set(lammps_build "${LAMMPS_BINARY_DIR}")
  if(NOT EXISTS "${lammps_build}/CMakeCache.txt")
    message(FATAL_ERROR "LAMMPS_BINARY_DIR=${lammps_build} is no CMake build of LAMMPS (no CMakeCache.txt)")
  endif()
  load_cache("${lammps_build}" READ_WITH_PREFIX lammps_ CMAKE_HOME_DIRECTORY)
  get_filename_component(lammps_source "${lammps_CMAKE_HOME_DIRECTORY}" DIRECTORY)
else()
  # A compiler wrapper or cross-compilation aside, FindMPI's compiler gives LAMMPS the same MPI as ours.
  set(args --result "${CMAKE_CURRENT_BINARY_DIR}/lammps-host.txt" --release "${DEFE_LAMMPS_RELEASE}"
    --cxx "${CMAKE_CXX_COMPILER}" --mpi-id "${MPI_CXX_LIBRARY_VERSION_STRING}")
  if(MPI_CXX_COMPILER)
    list(APPEND args --mpicxx "${MPI_CXX_COMPILER}")
  endif()
  if(LAMMPS_SOURCE_DIR)
    list(APPEND args --source "${LAMMPS_SOURCE_DIR}")
  endif()
  if(DEFE_LAMMPS_SHA256)
    list(APPEND args --sha256 "${DEFE_LAMMPS_SHA256}")
  endif()
  # The generator of this project is none of LAMMPS' business.
  execute_process(
    COMMAND "${CMAKE_COMMAND}" -E env --unset=CMAKE_GENERATOR --unset=CXXFLAGS --unset=LDFLAGS
            bash "${CMAKE_CURRENT_LIST_DIR}/get-lammps.sh" ${args}
    RESULT_VARIABLE result)
  if(result)
    message(FATAL_ERROR "No LAMMPS to build against; see above")
  endif()
  file(STRINGS "${CMAKE_CURRENT_BINARY_DIR}/lammps-host.txt" host)
  list(TRANSFORM host REPLACE "^[a-z]+=" "")
  list(GET host 0 lammps_source)
  list(GET host 1 lammps_build)
endif()
set(LAMMPS_SOURCE_DIR "${lammps_source}") # for the rest of this configure run; the cache keeps what the user gave

# --- how it was built -------------------------------------------------------

# The definitions must be exactly those of LAMMPS' own files (sizes of ints, alignment, ...).
# They are read off the compile command of one of them.
set(commands "${lammps_build}/compile_commands.json")
if(NOT EXISTS "${commands}")
  message(FATAL_ERROR "${commands} is missing: configure LAMMPS with -D CMAKE_EXPORT_COMPILE_COMMANDS=ON")
endif()
file(STRINGS "${commands}" command REGEX "\"command\".*/src/pair\\.cpp" LIMIT_COUNT 1)
if(NOT command)
  message(FATAL_ERROR "No compile command of LAMMPS' src/pair.cpp in ${commands}")
endif()
string(REGEX REPLACE "^ *\"command\": *\"|\",?$" "" command "${command}")
separate_arguments(command UNIX_COMMAND "${command}")
set(definitions "${command}")
list(FILTER definitions INCLUDE REGEX "^-D")
list(FILTER definitions EXCLUDE REGEX "^-D(lammps_EXPORTS|NDEBUG)")
list(TRANSFORM definitions REPLACE "^-D" "")
# src and the folders of its packages
set(includes "${command}")
list(FILTER includes INCLUDE REGEX "^-I.*/src(/[A-Z0-9-]+)?$")
list(TRANSFORM includes REPLACE "^-I" "")

find_library(lammps_library NAMES lammps PATHS "${lammps_build}" NO_DEFAULT_PATH NO_CACHE)
find_program(DEFE_LMP_EXECUTABLE NAMES lmp PATHS "${lammps_build}" NO_DEFAULT_PATH NO_CACHE)
if(NOT lammps_library OR NOT DEFE_LMP_EXECUTABLE)
  message(FATAL_ERROR "No lmp or no liblammps in ${lammps_build}: build LAMMPS with -D BUILD_SHARED_LIBS=ON")
endif()

set(months Jan Feb Mar Apr May Jun Jul Aug Sep Oct Nov Dec)
file(STRINGS "${LAMMPS_SOURCE_DIR}/src/version.h" version REGEX "LAMMPS_VERSION")
string(REGEX REPLACE ".*\"(.*)\".*" "\\1" DEFE_LAMMPS_VERSION "${version}")
# "4 Feb 2025" -> 20250204, the number that lammps_version() returns
string(REGEX MATCH "^([0-9]+) ([A-Z][a-z][a-z])[a-z]* ([0-9]+)" match "${DEFE_LAMMPS_VERSION}")
list(FIND months "${CMAKE_MATCH_2}" month)
math(EXPR DEFE_LAMMPS_VERSION_NUM "10000 * ${CMAKE_MATCH_3} + 100 * (${month} + 1) + ${CMAKE_MATCH_1}")

# --- what the rest of the build sees ----------------------------------------

# A plugin is not linked with liblammps: it takes the symbols of the LAMMPS that loads it,
# and works with an lmp that has LAMMPS linked in statically as well.
add_library(defe_lammps_headers INTERFACE)
target_include_directories(defe_lammps_headers SYSTEM INTERFACE ${includes})
target_compile_definitions(defe_lammps_headers INTERFACE ${definitions})
target_link_libraries(defe_lammps_headers INTERFACE MPI::MPI_CXX)

add_library(defe_lammps INTERFACE)
target_link_libraries(defe_lammps INTERFACE defe_lammps_headers "${lammps_library}")

configure_file("${CMAKE_CURRENT_LIST_DIR}/defe_build_info.h.in" "${PROJECT_BINARY_DIR}/generated/defe_build_info.h")
# An lmp beside the plugin, whatever the cache's folder is called.
file(CREATE_LINK "${DEFE_LMP_EXECUTABLE}" "${PROJECT_BINARY_DIR}/lmp" SYMBOLIC)

list(JOIN definitions " " text)
message(STATUS "LAMMPS ${DEFE_LAMMPS_VERSION}: ${lammps_build}")
message(STATUS "LAMMPS definitions: ${text}")
message(STATUS "MPI: ${DEFE_MPI_ID}")
