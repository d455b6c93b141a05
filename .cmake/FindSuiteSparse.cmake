# SuiteSparse 5.12 of Debian 12 ships no CMake package. Defines SuiteSparse::CHOLMOD, ::KLU and ::SPQR.
find_path(SuiteSparse_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse)
find_library(SuiteSparse_CHOLMOD_LIBRARY cholmod)
find_library(SuiteSparse_KLU_LIBRARY klu)
find_library(SuiteSparse_SPQR_LIBRARY spqr)
find_library(SuiteSparse_CONFIG_LIBRARY suitesparseconfig)
if(SuiteSparse_INCLUDE_DIR)
  file(STRINGS "${SuiteSparse_INCLUDE_DIR}/SuiteSparse_config.h" feder_lines
       REGEX "#define SUITESPARSE_(MAIN|SUB|SUBSUB)_VERSION +[0-9]+")
  string(REGEX MATCHALL "[0-9]+" feder_numbers "${feder_lines}")
  list(JOIN feder_numbers "." SuiteSparse_VERSION)
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(SuiteSparse REQUIRED_VARS SuiteSparse_CHOLMOD_LIBRARY SuiteSparse_KLU_LIBRARY
                                  SuiteSparse_SPQR_LIBRARY SuiteSparse_CONFIG_LIBRARY SuiteSparse_INCLUDE_DIR VERSION_VAR SuiteSparse_VERSION)
if(SuiteSparse_FOUND)
  foreach(part CHOLMOD KLU SPQR)
    if(NOT TARGET SuiteSparse::${part})
      add_library(SuiteSparse::${part} UNKNOWN IMPORTED)
      set_target_properties(SuiteSparse::${part} PROPERTIES
        IMPORTED_LOCATION "${SuiteSparse_${part}_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${SuiteSparse_INCLUDE_DIR}"
        INTERFACE_LINK_LIBRARIES "${SuiteSparse_CONFIG_LIBRARY}")
    endif()
  endforeach()
endif()
mark_as_advanced(SuiteSparse_INCLUDE_DIR SuiteSparse_CHOLMOD_LIBRARY SuiteSparse_KLU_LIBRARY SuiteSparse_SPQR_LIBRARY
                 SuiteSparse_CONFIG_LIBRARY)
