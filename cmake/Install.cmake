# cmake --install: the plugin, the tools, pages, examples, and the two libraries for find_package(DEFE).
#
#   <libdir>/lammps/plugins/       the plugin, for LAMMPS_PLUGIN_PATH
#   <libdir>/defeplugin.so         a link to it: below /usr, `plugin load defeplugin.so` then needs no path
#   <bindir>/                      mesh2data, layers2data, elements2stl, defe-config
#   <datadir>/defe/                tools/, python/ and examples/, which run from a copy in the user's folder
#   <docdir>                       pages
#   <includedir>, <libdir>         defe_fe, defe_coupling
#
# Components: plugin, tools, doc, development, and host (links to the lmp of this machine and to its
# Python module).
include(CMakePackageConfigHelpers)

set(plugins "${CMAKE_INSTALL_LIBDIR}/lammps/plugins")
set(data "${CMAKE_INSTALL_DATADIR}/defe")
set(docs "${CMAKE_INSTALL_DATADIR}/doc/defe")
set(generated "${PROJECT_BINARY_DIR}/generated/install")
file(MAKE_DIRECTORY "${generated}/bin" "${generated}/lib")

# --- plugin -----------------------------------------------------------------

install(TARGETS ${DEFE_PLUGINS} LIBRARY DESTINATION "${plugins}" COMPONENT plugin)
file(CREATE_LINK lammps/plugins/defeplugin.so "${generated}/lib/defeplugin.so" SYMBOLIC)
install(FILES "${generated}/lib/defeplugin.so" DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT plugin)
install(FILES "${PROJECT_BINARY_DIR}/lmp" DESTINATION "${data}" COMPONENT host)
install(DIRECTORY "${PROJECT_BINARY_DIR}/python/lammps" DESTINATION "${data}/python" COMPONENT host PATTERN __pycache__ EXCLUDE)

# --- tools and examples -----------------------------------------------------

file(RELATIVE_PATH to_data "/${CMAKE_INSTALL_BINDIR}" "/${data}")
foreach(tool mesh2data layers2data elements2stl)
  file(CREATE_LINK "${to_data}/tools/${tool}" "${generated}/bin/${tool}" SYMBOLIC)
  install(FILES "${generated}/bin/${tool}" DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT tools)
endforeach()
file(RELATIVE_PATH DEFE_UP "/${CMAKE_INSTALL_BINDIR}" "/")
set(DEFE_PLUGIN_FOLDER "${plugins}")
set(DEFE_DATA "${data}")
set(DEFE_DOCS "${docs}")
configure_file(tools/defe-config.in "${generated}/bin/defe-config" @ONLY)
install(PROGRAMS "${generated}/bin/defe-config" DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT tools)
install(PROGRAMS tools/mesh2data tools/layers2data tools/elements2stl tools/mpirun.sh tools/install-deps.sh
  DESTINATION "${data}/tools" COMPONENT tools)
install(FILES tools/common.sh tools/materials.inc tools/paraview_scene.py DESTINATION "${data}/tools" COMPONENT tools)
install(DIRECTORY python DESTINATION "${data}" COMPONENT tools FILES_MATCHING PATTERN "*.py" PATTERN "*.md"
  PATTERN __pycache__ EXCLUDE)
install(DIRECTORY examples DESTINATION "${data}" COMPONENT tools USE_SOURCE_PERMISSIONS
  PATTERN output EXCLUDE PATTERN __pycache__ EXCLUDE PATTERN "*~" EXCLUDE)

# --- pages ------------------------------------------------------------------

install(DIRECTORY lammps-package/doc/ DESTINATION "${docs}" COMPONENT doc)
install(FILES README.md CHANGELOG.md DESTINATION "${docs}" COMPONENT doc)
install(FILES LICENSE DESTINATION "${docs}" RENAME copyright COMPONENT doc)

# --- libraries --------------------------------------------------------------

install(TARGETS defe_fe defe_coupling defe_options EXPORT DEFETargets
  ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT development)
install(DIRECTORY fe-module/include/ coupling/include/ DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}"
  COMPONENT development FILES_MATCHING PATTERN "*.h")
set(package "${CMAKE_INSTALL_LIBDIR}/cmake/DEFE")
install(EXPORT DEFETargets NAMESPACE DEFE:: DESTINATION "${package}" COMPONENT development)
configure_package_config_file(cmake/DEFEConfig.cmake.in "${generated}/DEFEConfig.cmake" INSTALL_DESTINATION "${package}")
write_basic_package_version_file("${generated}/DEFEConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${generated}/DEFEConfig.cmake" "${generated}/DEFEConfigVersion.cmake"
  DESTINATION "${package}" COMPONENT development)

add_custom_target(uninstall COMMAND "${CMAKE_COMMAND}" -D "MANIFEST=${PROJECT_BINARY_DIR}/install_manifest.txt"
  -P "${PROJECT_SOURCE_DIR}/cmake/uninstall.cmake" VERBATIM)

if(DEFE_PORTABLE)
  include(Package)
else()
  file(WRITE "${PROJECT_BINARY_DIR}/CPackConfig.cmake" "message(FATAL_ERROR \"DEFE: a package is made of the build for any x86-64, \"
  \"this one is for its own processor: tools/install.sh --deb, which is cpack in build/portable\")\n")
endif()
