# Writes OUTPUT, a header with the commit of SOURCE. Run at every build; the file changes only when its text does.
cmake_minimum_required(VERSION 3.25)
set(commit "unknown")
set(dirty "unknown")
find_program(GIT git)
if(GIT)
  execute_process(COMMAND ${GIT} -C ${SOURCE} rev-parse --verify HEAD
                  OUTPUT_VARIABLE head RESULT_VARIABLE failed ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT failed)
    set(commit "${head}")
    execute_process(COMMAND ${GIT} -C ${SOURCE} status --porcelain --untracked-files=no
                    OUTPUT_VARIABLE changes RESULT_VARIABLE failed ERROR_QUIET)
    if(failed)
      set(dirty "unknown")
    elseif(changes STREQUAL "")
      set(dirty "no")
    else()
      set(dirty "yes")
    endif()
  endif()
endif()
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "#pragma once
#define FEDER_GIT_COMMIT \"@commit@\"
#define FEDER_GIT_DIRTY \"@dirty@\"
" @ONLY)
