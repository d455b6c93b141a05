# Flags every target of this project shares. Linked privately, so a consumer inherits none of them.
add_library(feder_flags INTERFACE)
target_compile_options(feder_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
                                             -ffp-contract=off)
if(FEDER_WARNINGS_AS_ERRORS)
  target_compile_options(feder_flags INTERFACE -Werror)
endif()
if(FEDER_SANITIZERS)
  target_compile_options(feder_flags INTERFACE -fsanitize=${FEDER_SANITIZERS} -fno-omit-frame-pointer
                                               -fno-sanitize-recover=all)
  target_link_options(feder_flags INTERFACE -fsanitize=${FEDER_SANITIZERS})
endif()
if(FEDER_FUZZ)
  target_compile_options(feder_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()
if(FEDER_COVERAGE)
  target_compile_options(feder_flags INTERFACE --coverage -O0)
  target_link_options(feder_flags INTERFACE --coverage)
endif()

# feder_library(NAME SOURCES...): the library feder_NAME, exported as feder::NAME.
function(feder_library name)
  add_library(feder_${name} STATIC ${ARGN})
  add_library(feder::${name} ALIAS feder_${name})
  set_target_properties(feder_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_include_directories(feder_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                  $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/feder>)
  target_compile_features(feder_${name} PUBLIC cxx_std_20)
  target_link_libraries(feder_${name} PRIVATE $<BUILD_INTERFACE:feder_flags>)
  # A third of the time to compile; sources with options of their own skip it.
  target_precompile_headers(feder_${name} PRIVATE <Eigen/Dense>)
endfunction()
