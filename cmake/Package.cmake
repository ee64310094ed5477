# cpack in the folder of the portable build: a .deb.
#
# A plugin fits one LAMMPS and one MPI. The package depends on the Debian package that the lmp of the build belongs
# to, in exactly that version; where this lmp is of no package, DEFE_DEB_LAMMPS can name one that is the same
# release with the same settings ("lammps (= VERSION)"), else the description says which LAMMPS is needed.
set(DEFE_DEB_LAMMPS "" CACHE STRING "What the Debian package depends on for LAMMPS, such as: lammps (= VERSION)")

set(lammps "${DEFE_DEB_LAMMPS}")
find_program(DPKG_QUERY dpkg-query)
if(DPKG_QUERY AND NOT lammps)
  file(REAL_PATH "${DEFE_LMP_EXECUTABLE}" program)
  execute_process(COMMAND "${DPKG_QUERY}" -S "${program}" OUTPUT_VARIABLE owner ERROR_QUIET)
  if(owner MATCHES "^([a-z0-9.+-]+)[:a-z0-9]*: ")
    set(owner "${CMAKE_MATCH_1}")
    execute_process(COMMAND "${DPKG_QUERY}" -W -f "\${Version}" "${owner}" OUTPUT_VARIABLE version)
    set(lammps "${owner} (= ${version})")
  endif()
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME defe)
set(CPACK_PACKAGE_CONTACT "the DEFE developers <defe@localhost>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "finite elements that become bonded spheres where glass cracks, for LAMMPS")
set(fits "The plugin fits LAMMPS ${DEFE_LAMMPS_VERSION} with ${DEFE_MPI_ID}.")
if(NOT lammps)
  string(APPEND fits "\nThis LAMMPS is not among the dependencies: it was in no Debian package.\n`plugin load` refuses any other.")
endif()
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "A package of LAMMPS as plugin, with its tools, pages and examples,
and the libraries DEFE::fe and DEFE::coupling.
${fits}")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
# MPI and the C++ library are found by dpkg-shlibdeps, with the versions that they need
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "${lammps}")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-numpy, python3-matplotlib, python3-pil")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "libeigen3-dev, python3-gmsh, python3-meshio")
# all of it in one package, without the link to this machine's lmp
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ALL_COMPONENTS_IN_ONE)
set(CPACK_COMPONENTS_ALL plugin tools doc development)
include(CPack)
