# HDF5 with MPI, for the files of fix defe/vtk: the target defe_hdf5, which is empty where there is none
# (the fix then says which package to install).
#
# DEFE_HDF5  OFF: build without it
option(DEFE_HDF5 "Let fix defe/vtk write its files, by HDF5 with MPI" ON)

add_library(defe_hdf5 INTERFACE)
set(DEFE_HDF5_PACKAGE "libhdf5-openmpi-dev")
set(flavour openmpi)
if(DEFE_MPI_ID STREQUAL "MPICH")
  set(DEFE_HDF5_PACKAGE "libhdf5-mpich-dev")
  set(flavour mpich)
endif()
target_compile_definitions(defe_hdf5 INTERFACE DEFE_HDF5_PACKAGE="${DEFE_HDF5_PACKAGE}")
if(NOT DEFE_HDF5)
  return()
endif()

# Debian keeps one HDF5 per MPI; elsewhere the one there is must be parallel.
find_path(DEFE_HDF5_INCLUDE_DIR hdf5.h PATH_SUFFIXES hdf5/${flavour})
find_library(DEFE_HDF5_LIBRARY NAMES hdf5_${flavour} hdf5)
mark_as_advanced(DEFE_HDF5_INCLUDE_DIR DEFE_HDF5_LIBRARY)
if(DEFE_HDF5_INCLUDE_DIR AND DEFE_HDF5_LIBRARY)
  include(CheckCXXSourceCompiles)
  set(CMAKE_REQUIRED_INCLUDES "${DEFE_HDF5_INCLUDE_DIR}")
  set(CMAKE_REQUIRED_LIBRARIES MPI::MPI_CXX "${DEFE_HDF5_LIBRARY}")
  check_cxx_source_compiles(
    "#include <hdf5.h>\nint main() { return H5Pset_fapl_mpio(0, MPI_COMM_WORLD, MPI_INFO_NULL); }" DEFE_HDF5_WORKS)
endif()
if(DEFE_HDF5_WORKS)
  target_include_directories(defe_hdf5 SYSTEM INTERFACE "${DEFE_HDF5_INCLUDE_DIR}")
  target_compile_definitions(defe_hdf5 INTERFACE DEFE_WITH_HDF5)
  target_link_libraries(defe_hdf5 INTERFACE "${DEFE_HDF5_LIBRARY}")
  message(STATUS "HDF5: ${DEFE_HDF5_LIBRARY}")
else()
  message(STATUS "HDF5: none with MPI, so fix defe/vtk cannot write (tools/install-deps.sh build, or ${DEFE_HDF5_PACKAGE})")
endif()
