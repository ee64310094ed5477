# Compiler flags of DEFE's own targets, and helpers for adding them.
include(GNUInstallDirs)

# Warnings and sanitizers concern our own code only.
add_library(defe_warnings INTERFACE)
target_compile_options(defe_warnings INTERFACE -Wall -Wextra)
# GCC 12 takes its own AVX-512 intrinsics for uninitialised (GCC bug 105593)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(defe_warnings INTERFACE -Wno-uninitialized -Wno-maybe-uninitialized)
endif()

# Passed on to everything that links our libraries: Eigen's alignment, and with it
# the layout of our structs, depends on the instruction set.
add_library(defe_options INTERFACE)
set_target_properties(defe_options PROPERTIES EXPORT_NAME options)
# No -ffast-math: NaN checks and the order of summation must stay. These three change
# neither, and let the compiler vectorise loops with sqrt and comparisons.
target_compile_options(defe_options INTERFACE
  $<$<CONFIG:Release,RelWithDebInfo>:-fno-math-errno -fno-trapping-math -ffp-contract=fast>)
include(CheckCXXCompilerFlag)
include(CheckCXXSourceCompiles)
# A shared library's own functions may be inlined: nobody replaces them at load time.
check_cxx_compiler_flag(-fno-semantic-interposition DEFE_HAS_NO_INTERPOSITION)
if(DEFE_HAS_NO_INTERPOSITION)
  target_compile_options(defe_options INTERFACE -fno-semantic-interposition)
endif()
# The portable build: all libraries as they are (x86-64-v1), and once more for each level with that ending.
set(DEFE_LEVELS "")
if(DEFE_PORTABLE)
  check_cxx_source_compiles("int main() { return __builtin_cpu_supports(\"x86-64-v3\"); }" DEFE_KNOWS_LEVELS)
  if(NOT DEFE_KNOWS_LEVELS)
    message(FATAL_ERROR "DEFE_PORTABLE needs an x86-64 and a compiler that knows its levels (GCC 12, Clang 18 or later): "
      "take another one, or build for this machine only with -D DEFE_PORTABLE=OFF")
  endif()
  foreach(level v3 v4)
    list(APPEND DEFE_LEVELS _${level})
    add_library(defe_options_${level} INTERFACE)
    target_link_libraries(defe_options_${level} INTERFACE defe_options)
    target_compile_options(defe_options_${level} INTERFACE -march=x86-64-${level})
  endforeach()
  # messages name the place in the source, not where it lay when it was built
  target_compile_options(defe_warnings INTERFACE "-fmacro-prefix-map=${PROJECT_SOURCE_DIR}/=")
elseif(DEFE_NATIVE)
  check_cxx_compiler_flag(-march=native DEFE_HAS_MARCH_NATIVE)
  if(DEFE_HAS_MARCH_NATIVE)
    target_compile_options(defe_options INTERFACE -march=native)
  endif()
endif()
if(DEFE_FUZZ)
  # coverage for libFuzzer; its main() is linked to the fuzz targets only
  target_compile_options(defe_options INTERFACE -fsanitize=fuzzer-no-link)
endif()
if(DEFE_SANITIZE)
  set(flags -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  target_compile_options(defe_options INTERFACE ${flags})
  target_link_options(defe_options INTERFACE ${flags})
  target_compile_definitions(defe_options INTERFACE _GLIBCXX_ASSERTIONS DEFE_CHECK)
endif()

# defe_precompile(TARGET KIND headers...): the first target of a kind precompiles them, the others use that
# (all of one kind have the same compiler options). It saves a third of the time to build. Files include what
# they need all the same: builds with sanitizers do without, for some of their tests have options of their own.
function(defe_precompile target kind)
  if(DEFE_SANITIZE)
    return()
  endif()
  get_property(owner GLOBAL PROPERTY defe_precompiled_${kind})
  if(owner)
    target_precompile_headers(${target} REUSE_FROM ${owner})
  else()
    target_precompile_headers(${target} PRIVATE ${ARGN})
    set_property(GLOBAL PROPERTY defe_precompiled_${kind} ${target})
  endif()
endfunction()

# defe_add_library(NAME [LINK targets...]): static library of src/*.cpp with public headers in include/,
# and NAME_LEVEL for each level.
function(defe_add_library name)
  cmake_parse_arguments(arg "" "" "LINK" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS src/*.cpp)
  foreach(level IN ITEMS "" ${DEFE_LEVELS})
    set(target ${name}${level})
    set(links ${arg_LINK})
    list(TRANSFORM links APPEND "${level}" REGEX "^defe_")
    add_library(${target} STATIC ${sources})
    target_include_directories(${target} PUBLIC "$<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>"
      "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>" PRIVATE src)
    target_link_libraries(${target} PUBLIC defe_options${level} ${links} PRIVATE $<BUILD_INTERFACE:defe_warnings>)
    defe_precompile(${target} ${target} <Eigen/Dense> <algorithm> <cmath> <sstream> <string> <unordered_map> <vector>)
  endforeach()
  string(REPLACE "defe_" "" short "${name}")
  set_target_properties(${name} PROPERTIES EXPORT_NAME ${short}) # DEFE::fe
  if(DEFE_PORTABLE)
    # as in the library, whatever instructions a program has that links it
    target_compile_definitions(${name} INTERFACE $<INSTALL_INTERFACE:EIGEN_MAX_ALIGN_BYTES=16>)
  endif()
endfunction()
