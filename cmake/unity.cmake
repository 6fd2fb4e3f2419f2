# Compiles a room in a few large pieces: for a build from nothing, where each file would read the same headers again.
# A developer's build does without, because a change of one file would compile its whole piece.
#
#   granuscope_unity(<target> <sources>...)
#
# Files that give the same name to something of their own (in an unnamed namespace) go to different pieces. Files that
# are compiled once for each instruction set stay alone.

set(granuscope_unity_files 12)  # at the most in a piece: two cores share the larger rooms

# What a source declares in its unnamed namespaces, and what a file beside it may therefore not declare there: a name, or
# a function of these types of parameters (templates and those with defaults: any). Such declarations begin a line
# (.clang-format).
function(granuscope_own_names source names clashes)
  file(READ ${source} text)
  string(REGEX REPLACE "[][;\\\\]" "" text "${text}")  # what would be read as syntax of a list
  set(own)
  set(others)
  string(FIND "${text}" "\nnamespace {\n" from)
  while(NOT from EQUAL -1)
    string(SUBSTRING "${text}" ${from} -1 text)
    string(FIND "${text}" "\n}  // namespace\n" length)
    string(SUBSTRING "${text}" 0 ${length} part)
    string(REGEX MATCHALL "\n[a-zA-Z][^\n]*" declarations "${part}")
    list(FILTER declarations EXCLUDE REGEX "\n(using|namespace) ")  # of the same thing by the same name
    set(template FALSE)
    foreach(declaration IN LISTS declarations)
      if(declaration MATCHES "\n(struct|class|enum class|enum) ([A-Za-z0-9_]+)")
        list(APPEND own ${CMAKE_MATCH_2})
        list(APPEND others ${CMAKE_MATCH_2} "${CMAKE_MATCH_2}()")
      elseif(declaration MATCHES "^[^(={]*[ *&]([A-Za-z0-9_]+) *\\(([^)=]*)($|\\))" AND NOT template)
        set(name ${CMAKE_MATCH_1})
        string(REGEX REPLACE " [a-z0-9_]+(,|$)" "\\1" types "${CMAKE_MATCH_2}")  # without names of parameters
        string(MAKE_C_IDENTIFIER "${types}" types)
        list(APPEND own "${name}()" "${name}(${types})")
        list(APPEND others ${name} "${name}(${types})")
      elseif(declaration MATCHES "^[^(={]*[ *&]([A-Za-z0-9_]+) *($|[(={])")
        list(APPEND own ${CMAKE_MATCH_1})
        list(APPEND others ${CMAKE_MATCH_1} "${CMAKE_MATCH_1}()")
      endif()
      string(REGEX MATCH "^\ntemplate" template "${declaration}")
    endforeach()
    string(SUBSTRING "${text}" 1 -1 text)
    string(FIND "${text}" "\nnamespace {\n" from)
  endwhile()
  list(REMOVE_DUPLICATES own)
  set(${names} ${own} PARENT_SCOPE)
  set(${clashes} ${others} PARENT_SCOPE)
endfunction()

function(granuscope_unity target)
  set(pieces 0)
  foreach(source IN LISTS ARGN)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
    file(STRINGS ${source} kernels REGEX "hwy/foreach_target.h")
    if(kernels)
      continue()
    endif()
    granuscope_own_names(${source} names clashes)
    set(piece 0)
    while(TRUE)
      math(EXPR piece "${piece} + 1")
      set(common ${names_${piece}})
      set(others ${names_${piece}})
      list(REMOVE_ITEM others ${clashes} "")
      list(LENGTH common before)
      list(LENGTH others after)
      list(LENGTH files_${piece} files)
      if(before EQUAL after AND files LESS granuscope_unity_files)
        break()
      endif()
    endwhile()
    list(APPEND names_${piece} ${names})
    list(APPEND files_${piece} ${source})
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${target}_${piece})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
