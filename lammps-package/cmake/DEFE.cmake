# Package DEFE of LAMMPS (cmake -D PKG_DEFE=on): the mechanics in lib/defe as a library, and Eigen.
# tools/into-lammps of DEFE puts this file into cmake/Modules/Packages.
if(CMAKE_CXX_STANDARD LESS 17)
  message(FATAL_ERROR "Package DEFE is written in C++17: configure with -D CMAKE_CXX_STANDARD=17")
endif()
find_package(Eigen3 3.3 NO_MODULE REQUIRED)

if(NOT BUILD_MPI)
  message(FATAL_ERROR "Package DEFE needs MPI, also for one rank: configure with -D BUILD_MPI=on "
    "(LAMMPS' stand-in for MPI, src/STUBS, lacks what it calls)")
endif()

set(DEFE_LIB_DIR "${LAMMPS_LIB_SOURCE_DIR}/defe")
file(GLOB DEFE_LIB_SOURCES CONFIGURE_DEPENDS ${DEFE_LIB_DIR}/fe-module/src/[^.]*.cpp ${DEFE_LIB_DIR}/coupling/src/[^.]*.cpp)
add_library(defe STATIC ${DEFE_LIB_SOURCES})
set_target_properties(defe PROPERTIES OUTPUT_NAME lammps_defe${LAMMPS_MACHINE})
target_include_directories(defe PUBLIC ${DEFE_LIB_DIR}/fe-module/include ${DEFE_LIB_DIR}/coupling/include
  PRIVATE ${DEFE_LIB_DIR}/fe-module/src ${DEFE_LIB_DIR}/coupling/src)
target_link_libraries(defe PUBLIC Eigen3::Eigen)
target_precompile_headers(defe PRIVATE <Eigen/Dense> <algorithm> <cmath> <sstream> <string> <unordered_map> <vector>)
target_link_libraries(lammps PRIVATE defe)

# for fix defe/vtk
if(MPI_CXX_LIBRARY_VERSION_STRING MATCHES "^MPICH")
  set(DEFE_MPI_ID MPICH)
endif()
include("${DEFE_LIB_DIR}/Hdf5.cmake")
target_link_libraries(lammps PRIVATE defe_hdf5)

# Library and styles are compiled for the same instructions: the layout of their structs depends on them.
# The flags are those of DEFE's own build, see cmake/DefeTargets.cmake there.
separate_arguments(DEFE_TUNE_FLAGS UNIX_COMMAND "${CMAKE_TUNE_FLAGS}")
target_compile_options(defe PRIVATE ${DEFE_TUNE_FLAGS})
if(CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
  set(DEFE_FLAGS -fno-math-errno -fno-trapping-math -ffp-contract=fast)
  target_compile_options(defe PRIVATE ${DEFE_FLAGS})
  file(GLOB DEFE_STYLES CONFIGURE_DEPENDS ${LAMMPS_SOURCE_DIR}/DEFE/[^.]*.cpp)
  set_source_files_properties(${DEFE_STYLES} PROPERTIES COMPILE_OPTIONS "${DEFE_FLAGS}")
endif()
