# FindSuiteSparse: libraries of SuiteSparse by component (KLU BTF AMD CAMD COLAMD CCOLAMD CHOLMOD
# SPQR) as targets SuiteSparse::<component>, each with the components it needs.
# Result: SuiteSparse_FOUND, SuiteSparse_<component>_FOUND, SuiteSparse_INCLUDE_DIR.
include(FindPackageHandleStandardArgs)

set(SuiteSparse_needs_KLU AMD COLAMD BTF)
set(SuiteSparse_needs_CHOLMOD AMD COLAMD CAMD CCOLAMD)
set(SuiteSparse_needs_SPQR CHOLMOD)

find_path(SuiteSparse_INCLUDE_DIR SuiteSparse_config.h PATH_SUFFIXES suitesparse)
find_library(SuiteSparse_config_LIBRARY suitesparseconfig)
mark_as_advanced(SuiteSparse_INCLUDE_DIR SuiteSparse_config_LIBRARY)

# Needed components come before the components that need them.
set(SuiteSparse_order_)
foreach(component AMD CAMD COLAMD CCOLAMD BTF KLU CHOLMOD SPQR)
  foreach(wanted ${SuiteSparse_FIND_COMPONENTS})
    set(closure_ ${wanted} ${SuiteSparse_needs_${wanted}})
    foreach(needed ${SuiteSparse_needs_${wanted}})
      list(APPEND closure_ ${SuiteSparse_needs_${needed}})
    endforeach()
    if(component IN_LIST closure_ AND NOT component IN_LIST SuiteSparse_order_)
      list(APPEND SuiteSparse_order_ ${component})
    endif()
  endforeach()
endforeach()

foreach(component ${SuiteSparse_order_})
  string(TOLOWER ${component} name_)
  find_library(SuiteSparse_${component}_LIBRARY ${name_})
  mark_as_advanced(SuiteSparse_${component}_LIBRARY)
  if(SuiteSparse_${component}_LIBRARY AND SuiteSparse_INCLUDE_DIR AND SuiteSparse_config_LIBRARY)
    set(SuiteSparse_${component}_FOUND TRUE)
    if(NOT TARGET SuiteSparse::${component})
      set(links_ ${SuiteSparse_needs_${component}})
      list(TRANSFORM links_ PREPEND SuiteSparse::)
      add_library(SuiteSparse::${component} UNKNOWN IMPORTED)
      set_target_properties(SuiteSparse::${component} PROPERTIES
        IMPORTED_LOCATION ${SuiteSparse_${component}_LIBRARY}
        INTERFACE_INCLUDE_DIRECTORIES ${SuiteSparse_INCLUDE_DIR}
        INTERFACE_LINK_LIBRARIES "${links_};${SuiteSparse_config_LIBRARY}")
    endif()
  endif()
endforeach()

find_package_handle_standard_args(SuiteSparse HANDLE_COMPONENTS
  REQUIRED_VARS SuiteSparse_INCLUDE_DIR SuiteSparse_config_LIBRARY)
