# Compiles a room in a few large pieces: for a build from nothing, where each file would read the same headers again.
# A developer's build does without, because a change of one file would compile its whole piece. Names in unnamed
# namespaces are therefore unique in a room. Files that are compiled once for each instruction set stay alone.
#
#   granuscope_unity(<target> <sources>...)

set(granuscope_unity_files 12)  # at the most in a piece: two cores share the larger rooms

function(granuscope_unity target)
  set(joined 0)
  foreach(source IN LISTS ARGN)
    file(STRINGS ${source} kernels REGEX "hwy/foreach_target.h")
    if(kernels)
      set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    else()
      math(EXPR joined "${joined} + 1")
    endif()
  endforeach()
  math(EXPR pieces "(${joined} + ${granuscope_unity_files} - 1) / ${granuscope_unity_files}")
  math(EXPR batch "(${joined} + ${pieces} - 1) / ${pieces}")
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${batch})
endfunction()
