# Run by every build: cmake -DSOURCE_DIR=... -DOUTPUT=... -P git_state.cmake
# Writes the commit and the dirty flag into a header, and touches it only when they have changed.
set(commit "unknown")
set(dirty "false")

# Without --no-optional-locks a build would take the index lock from under somebody's `git add`.
function(git result)
  execute_process(COMMAND git --no-optional-locks -C ${SOURCE_DIR} ${ARGN}
                  OUTPUT_VARIABLE text ERROR_QUIET RESULT_VARIABLE status OUTPUT_STRIP_TRAILING_WHITESPACE)
  set(${result} "${text}" PARENT_SCOPE)
  set(${result}_status "${status}" PARENT_SCOPE)
endfunction()

# A source archive unpacked inside another project's checkout must not claim that project's commit.
git(top rev-parse --show-toplevel)
if(top_status STREQUAL "0")
  file(REAL_PATH "${SOURCE_DIR}" here)
  file(REAL_PATH "${top}" top)
  if(top STREQUAL here)
    git(head rev-parse --verify HEAD)
    if(head_status STREQUAL "0" AND head MATCHES "^[0-9a-f]+$")
      set(commit "${head}")
      # Changed files anywhere, and new ones where they would be built or used; an author's own experiment is neither.
      git(changed status --porcelain --untracked-files=no)
      git(added ls-files --others --exclude-standard -- src cmake templates)
      if(NOT changed STREQUAL "" OR NOT added STREQUAL "")
        set(dirty "true")
      endif()
    endif()
  endif()
endif()

file(CONFIGURE OUTPUT "${OUTPUT}" @ONLY CONTENT [[#pragma once

// Written by every build, from cmake/git_state.cmake.
namespace granuscope::git_state {

inline constexpr const char* commit = "@commit@";
inline constexpr bool dirty = @dirty@;

}  // namespace granuscope::git_state
]])
